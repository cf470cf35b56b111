"""The ledger: every printed statement of both papers, and what became of it.

`statements.csv` has a line for each theorem, lemma, figure, table and quantitative or checkable
sentence, in the papers' order. Its status follows from the verdicts of the rows of its claims:

reproduced            at least one is attained, holds or exceeds
not reproduced        at least one is not reproduced
false as printed      at least one is contradicted; or the line derives what follows instead, with
                      its effect: see EFFECTS
cannot be checked     the line says why; rows are findings at most
future work done      of the papers' outlooks; rows are findings at most
future work not done  likewise, the line says what there is
not checked           it could be; the line says by what
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path

from benchmarks.checks.bounds import (
    ATTAINED,
    CONTRADICTED,
    EXCEEDS,
    HOLDS,
    NOT_REPRODUCED,
)
from benchmarks.checks.claim import Row

FILE = Path(__file__).with_name("statements.csv")
REPRODUCED, FALSE = "reproduced", "false as printed"
STATUSES = {  # status: the verdicts of which one is needed
    REPRODUCED: {ATTAINED, HOLDS, EXCEEDS},
    NOT_REPRODUCED: {NOT_REPRODUCED},
    FALSE: {CONTRADICTED},
    "cannot be checked": set(),
    "future work done": set(),
    "future work not done": set(),
    "not checked": set(),
}
EFFECTS = {
    "harmless": "nothing rests on it",
    "too cautious": "more is true",
    "too strong": "less is true",
    "other result": "who computes by it gets something else",
}


@dataclass(frozen=True)
class Statement:
    """A printed statement.

    where      as in the `source` of rows, e.g. "H thm. 2.3.1"
    kind       theorem, lemma, figure, formula, sentence, ...
    statement  what it says, in our words
    status     one of STATUSES
    effect     of one that is false as printed, one of EFFECTS; else ""
    claims     ids of the claims that check it
    why        of what is not reproduced: what follows instead, or what is missing; else a remark
    """

    where: str
    kind: str
    statement: str
    status: str
    effect: str
    claims: tuple[str, ...]
    why: str


@cache
def statements() -> tuple[Statement, ...]:
    """All of them."""
    with FILE.open(encoding="utf-8", newline="") as file:
        return tuple(
            Statement(**{**line, "claims": tuple(line["claims"].split())})
            for line in csv.DictReader(file)
        )


def unfounded(found: Sequence[Statement], rows: Iterable[Row]) -> list[str]:
    """A sentence for each status that the rows do not support, for each claim with a row that is
    not reproduced or contradicted and no statement that says so, and for praise of a number that
    the source measured."""
    verdicts: dict[str, set[str]] = {}
    for row in rows:
        verdicts.setdefault(row.id, set()).add(row.verdict)
    said = []
    for one in found:
        needed = STATUSES[one.status]
        seen = set().union(*(verdicts.get(name, set()) for name in one.claims))
        derived = one.status == FALSE and one.effect
        if needed and not derived and not needed & seen:
            said.append(f"{one.where} ({one.statement}) is called {one.status}; no row says so.")
    figures = {name for one in found if one.status == NOT_REPRODUCED for name in one.claims}
    for name in sorted(figures):
        if EXCEEDS in verdicts.get(name, ()):
            said.append(f"{name} exceeds what was measured: only proved bounds are exceeded.")
    for status in (NOT_REPRODUCED, FALSE):
        for name, seen in verdicts.items():
            told = any(name in one.claims for one in found if one.status == status)
            if STATUSES[status] & seen and not told:
                said.append(f"{name} has a row that is {status}; no statement of it is called so.")
    return said


def counted(found: Sequence[Statement]) -> str:
    """How many statements became what, in a sentence."""
    counts = Counter(one.status for one in found)
    harmless = sum(one.effect == "harmless" for one in found)
    parts = [f"{counts[status]} {_words(status, counts[status])}" for status in STATUSES]
    parts[list(STATUSES).index(FALSE)] += f" ({harmless} of them harmless misprints)"
    return f"Of {len(found)} printed statements of the two papers, {', '.join(parts)}."


def _words(status: str, count: int) -> str:
    """The status with its verb."""
    if status.startswith("cannot"):
        return status
    return f"{'is' if count == 1 else 'are'} {status}"

"""The printed statements of both papers, with their status.

Under each heading of a paper a document has a table with a line for each theorem, lemma, figure,
table and quantitative or checkable sentence: where it is printed, its kind, its content in our
words, its status and effect, the claims that check it, with or without the rows ("V11 at H fig.
1.1: energy"), and a reason. The status must agree with the verdicts of the claims' rows that check
it, which are found by their `source`:

reproduced            at least one is attained, holds or exceeds
not reproduced        at least one is not reproduced
false as printed      at least one is contradicted; or no claim checks it, and the line derives the
                      correct statement; it has an effect, see EFFECTS
cannot be checked     the line says why; rows are findings at most
future work done      of the papers' outlooks; rows are findings at most
future work not done  likewise; the line says what exists
not checked           it could be checked; the line says how
"""

from __future__ import annotations

from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import cache
from itertools import chain

from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, EXCEEDS, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Claim, Row
from benchmarks.claims.documents import Part, all_documents
from benchmarks.store.tables import table_of

PAPERS = ("H", "M")
REPRODUCED, FALSE, UNCHECKABLE = "reproduced", "false as printed", "cannot be checked"
STATUSES = {  # status -> the verdicts, at least one of which it requires
    REPRODUCED: {ATTAINED, HOLDS, EXCEEDS},
    NOT_REPRODUCED: {NOT_REPRODUCED},
    FALSE: {CONTRADICTED},
    UNCHECKABLE: set(),
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

    Attributes
    ----------
    where
        its place, as in the `source` of rows, e.g. "H thm. 2.3.1"
    kind
        theorem, lemma, figure, formula, sentence, ...
    statement
        its content in our words
    status
        a key of STATUSES
    effect
        a key of EFFECTS if it is false as printed, else ""
    claims
        ids of the claims that check it
    rows
        the rows of these claims: places in their `source`, separated by "; ", each with or without
        a text in the quantity, "place: text"; "" for the place `where`
    why
        if it is not reproduced, the correct statement or what is missing; else a remark
    """

    where: str
    kind: str
    statement: str
    status: str
    effect: str
    claims: tuple[str, ...]
    rows: str
    why: str

    def is_checked_by(self, row: Row) -> bool:
        """Whether a row checks this statement."""
        if row.id not in self.claims:
            return False
        sources = {row.source, *places(row.source)}
        named = [name.partition(": ") for name in (self.rows or self.where).split("; ")]
        return any(where in sources and text in row.quantity for where, _, text in named)


def places(source: str) -> list[str]:
    """The places in a row's source: "H thm. 2.1.1, 3.1.1" gives H thm. 2.1.1 and H thm. 3.1.1.

    Sections are left out if there is a theorem, figure or formula, which they only locate.
    """
    by_kind, paper, kind = [], "", ""
    for part in source.split(", "):
        names = part.split(" ")
        if names[0] in PAPERS:
            paper, kind, names = names[0], "", names[1:]
        if names[0][:1].islower():
            kind, names = names[0], names[1:]
        elif names[0][:1] == "(":
            kind = ""
        by_kind.append((kind, " ".join(filter(None, (paper, kind, *names)))))
    exact = [name for kind, name in by_kind if kind not in ("", "sec.", "section") or "(" in name]
    return exact or [name for _, name in by_kind]


def claims_by_place(claims: Sequence[Claim]) -> dict[str, set[str]]:
    """Place, such as "H fig. 3.5" -> ids of the claims that check its contents, by the statements
    there, by the sources of the claims' rows, and by their figures."""
    claim_ids, by_place = {claim.id for claim in claims}, defaultdict(set)
    for statement in statements():
        for where in (statement.where, *places(statement.where)):
            by_place[where] |= claim_ids & {*statement.claims}
    for claim in claims:
        sources = (*claim.figures, *(row.source for row in claim.check(table_of([]))))
        for where in chain(*map(places, sources)):
            by_place[where].add(claim.id)
    return by_place


def why_unchecked(where: str) -> str:
    """The status of the statements at a place that no claim checks."""
    return "; ".join(
        f"{statement.status}: {statement.why}".rstrip(".")
        for statement in statements()
        if where in (statement.where, *places(statement.where))
    )


@cache
def statements() -> tuple[Statement, ...]:
    """All statements, in the order of the documents."""
    return tuple(
        statement
        for document in all_documents()
        for part in document.parts
        for statement in statements_of(part)
    )


def statements_of(part: Part) -> Iterator[Statement]:
    """The statements under one heading of a paper. Raises ValueError for an invalid status."""
    for cells in part.statements:
        status, _, effect = cells["status"].partition(", ")
        claims, _, rows = cells["checks"].partition(" at ")
        if status not in STATUSES or (status == FALSE) != (effect in EFFECTS):
            raise ValueError(
                f"{cells['where']}: a status is of {[*STATUSES]}, and {FALSE!r} has an effect, "
                f"after a comma, of {[*EFFECTS]}; received {cells['status']!r}."
            )
        texts = (cells["where"], cells["kind"], cells["statement"], status, effect)
        yield Statement(*texts, tuple(claims.split()), rows, cells["why"])


def unfounded(printed: Sequence[Statement], rows: Iterable[Row]) -> list[str]:
    """Objections to the statements: a sentence for each status that the statement's rows do not
    support, for each named row that does not exist, for each row that is not reproduced or
    contradicted without a statement of that status, and for each statement that is not reproduced
    though one of its rows exceeds the bound."""
    rows = list(rows)
    checks = {
        statement: [row for row in rows if statement.is_checked_by(row)] for statement in printed
    }
    objections = [text for pair in checks.items() for text in _objections(*pair)]
    for status in (NOT_REPRODUCED, FALSE):
        stated = {
            id(row)
            for statement, checking in checks.items()
            if statement.status == status
            for row in checking
        }
        objections += [
            f"{row.id} has a row that is {status}; no statement of it is called so."
            for row in rows
            if row.verdict in STATUSES[status] and id(row) not in stated
        ]
    return list(dict.fromkeys(objections))


def _objections(statement: Statement, rows: list[Row]) -> Iterator[str]:
    """Sentences on the status and the named rows of a statement that `rows` do not support."""
    name = f"{statement.where} ({statement.statement})"
    for named in statement.rows.split("; ") if statement.rows else ():
        if not any(replace(statement, rows=named).is_checked_by(row) for row in rows):
            yield f"{name} names rows that are not there: {named}."
    needed, verdicts = STATUSES[statement.status], {row.verdict for row in rows}
    is_derived = statement.status == FALSE and not statement.claims
    if needed and not is_derived and not needed & verdicts:
        yield f"{name} is called {statement.status}; no row says so."
    if statement.status == REPRODUCED and STATUSES[NOT_REPRODUCED] & verdicts:
        yield f"{name} is called reproduced; a row says not."
    if statement.status == NOT_REPRODUCED and EXCEEDS in verdicts:
        yield f"{statement.where} exceeds what was measured: only proved bounds are exceeded."


def status_counts(printed: Sequence[Statement]) -> str:
    """A sentence with the number of statements of each status."""
    counts = Counter(statement.status for statement in printed)
    harmless = sum(statement.effect == "harmless" for statement in printed)
    parts = [
        f"{counts[status]} {_with_verb(status, counts[status])}"
        + (f" ({harmless} of them harmless misprints)" if status == FALSE else "")
        for status in STATUSES
        if counts[status]
    ]
    return f"Of {len(printed)} printed statements of the two papers, {', '.join(parts)}."


def _with_verb(status: str, count: int) -> str:
    """The status with "is" or "are", unless it has a verb."""
    if status == UNCHECKABLE:
        return status
    return f"{'is' if count == 1 else 'are'} {status}"

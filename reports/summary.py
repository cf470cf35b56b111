"""What the verdicts add up to: counts, differences from what was expected, one sentence."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable
from dataclasses import dataclass

from benchmarks.claim import Row

VERDICTS = ("holds", "exceeds", "contradicted", "not run")


@dataclass(frozen=True)
class Summary:
    """Rows of claims, counted.

    differing  rows whose verdict is not the expected one
    """

    rows: tuple[Row, ...]

    @property
    def differing(self) -> tuple[Row, ...]:
        return tuple(row for row in self.rows if row.verdict != row.expected)

    @property
    def as_expected(self) -> bool:
        """Whether something was checked and nothing came out differently."""
        return bool(self.rows) and not self.differing

    def __str__(self) -> str:
        claims = len({row.id for row in self.rows})
        counts = Counter(row.verdict for row in self.rows)
        counted = ", ".join(f"{counts[v]} {v}" for v in VERDICTS if counts[v])
        if not self.rows:
            return "No claim was checked."
        checks = f"{_many(claims, 'claim')} in {_many(len(self.rows), 'check')}: {counted}"
        if not self.differing:
            return f"{checks}; every verdict is the expected one."
        differ = "differs" if len(self.differing) == 1 else "differ"
        named = ", ".join(dict.fromkeys(row.id for row in self.differing))
        return f"{checks}; {len(self.differing)} {differ} from what was expected ({named})."


def summary(rows: Iterable[Row]) -> Summary:
    return Summary(tuple(rows))


def _many(count: int, noun: str) -> str:
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"

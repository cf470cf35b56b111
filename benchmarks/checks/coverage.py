"""How often the stated errors of fitted orders contain the true order, where that is known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from benchmarks.checks.claim import Row

SIGMAS, EXPECTED_FRACTION = 2.0, 0.05  # standard errors, and expected fraction beyond them
LEAST_PROBABILITY = 1e-3  # of as many misses: below it the stated errors are too small


@dataclass(frozen=True)
class Coverage:
    """Of ``orders`` with a known true value, ``beyond`` are off by more than SIGMAS of their stated
    errors."""

    orders: int
    beyond: int

    @property
    def is_plausible(self) -> bool:
        """Whether as many misses have at least the LEAST_PROBABILITY; True without orders."""
        from scipy.stats import binom  # half a second

        return (
            self.beyond == 0
            or float(binom.sf(self.beyond - 1, self.orders, EXPECTED_FRACTION)) >= LEAST_PROBABILITY
        )

    def __str__(self) -> str:
        return (
            f"of {self.orders} fitted orders whose true value is known, {self.beyond} miss it by "
            f"more than two of their standard errors "
            f"({EXPECTED_FRACTION * self.orders:.0f} would by chance)"
        )


def coverage(rows: Iterable[Row]) -> Coverage:
    """The coverage of these rows; a fit in several rows counts once."""
    misses = {(row.id, row.measured): row.misses for row in rows if row.misses is not None}
    return Coverage(len(misses), sum(abs(miss) > SIGMAS for miss in misses.values()))

"""Do the stated errors of fitted orders cover? Counted over orders whose true value is known."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from benchmarks.checks.claim import Row

SIGMAS, SHARE = 2.0, 0.05  # standard errors, and the share of orders farther off than that
CHANCE = 1e-3  # probability of as many misses, below which the stated errors are too small


@dataclass(frozen=True)
class Coverage:
    """Of ``orders`` with a known true value, ``beyond`` are off by more than SIGMAS of their stated
    errors."""

    orders: int
    beyond: int

    @property
    def is_plausible(self) -> bool:
        """Whether as many misses have at least the probability CHANCE; True without orders."""
        from scipy.stats import binom  # half a second

        return self.beyond == 0 or float(binom.sf(self.beyond - 1, self.orders, SHARE)) >= CHANCE

    def __str__(self) -> str:
        return (
            f"of {self.orders} fitted orders whose true value is known, {self.beyond} miss it by "
            f"more than two of their standard errors ({SHARE * self.orders:.0f} would by chance)"
        )


def coverage(rows: Iterable[Row]) -> Coverage:
    """The coverage of these rows; a fit in several rows counts once."""
    misses = {(row.id, row.measured): row.misses for row in rows if row.misses is not None}
    return Coverage(len(misses), sum(abs(miss) > SIGMAS for miss in misses.values()))

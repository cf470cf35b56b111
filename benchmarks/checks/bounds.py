"""Bounds on measured numbers, which have both a text and a verdict.

Each bound states its comparisons in numbers and in words; `Bound.verdict` turns them into a
verdict. NaN never holds. The verdicts:

attained        a rate, order or constant is met within its uncertainty
holds           an inequality or a qualitative statement is true, with the row's slack
exceeds         a rate or order is better than a proved lower bound, beyond that uncertainty
not reproduced  what the source measured comes out otherwise, on either side, as the reason says
contradicted    false under the source's own protocol, in the reading that the row's reason states;
                also an index slip, whichever side it errs on
finding         a finding of this suite: the source says nothing about it, or too little
not run         nothing was measured
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ClassVar

from benchmarks.statistics.estimate import Measurement, estimate

ATTAINED = "attained"
HOLDS = "holds"
EXCEEDS = "exceeds"
NOT_REPRODUCED = "not reproduced"
CONTRADICTED = "contradicted"
FINDING = "finding"
NOT_RUN = "not run"
VERDICTS = (ATTAINED, HOLDS, EXCEEDS, NOT_REPRODUCED, CONTRADICTED, FINDING, NOT_RUN)

ORDER_RESOLUTION = 0.25  # the papers print orders as multiples of a half
ABOVE, BELOW = 1, -1


@dataclass(frozen=True)
class Comparison:
    """A number and the closed interval that it should lie in.

    Attributes
    ----------
    better
        the side of the interval on which the number is better than claimed: ABOVE, BELOW or 0
    tolerance
        distance beyond either end that is tolerated
    """

    number: float
    low: float = -math.inf
    high: float = math.inf
    better: int = 0
    tolerance: float = 0.0

    def verdict(self, met: str) -> str:
        """`met` inside the interval, EXCEEDS or CONTRADICTED outside, NOT_RUN without a number."""
        low, high = self.low - self.tolerance, self.high + self.tolerance
        if any(math.isnan(x) for x in (self.number, low, high)):
            return NOT_RUN
        if low <= self.number <= high:
            return met
        beyond = ABOVE if self.number > high else BELOW
        return EXCEEDS if beyond == self.better else CONTRADICTED

    @property
    def slack(self) -> float:
        """The factor by which the number may grow or shrink before it reaches an end.

        NaN for a number that is not positive, and without a positive end.
        """
        if not self.number > 0.0:
            return math.nan
        low, high = self.low - self.tolerance, self.high + self.tolerance
        factors = [high / self.number, self.number / low if low > 0.0 else math.inf]
        return min(factors) if 0.0 < min(factors) < math.inf else math.nan


class Bound(ABC):
    """A bound on a measurement.

    Attributes
    ----------
    met
        the verdict where every comparison is met: ATTAINED for a rate, order or constant
    """

    met: ClassVar[str] = HOLDS

    @property
    @abstractmethod
    def text(self) -> str:
        """The bound in words, as in a row of claims.csv."""

    @abstractmethod
    def comparisons(self, measured: Any) -> tuple[Comparison, ...]:
        """The comparisons that the text states."""

    def verdict(self, measured: Measurement) -> str:
        """The worst verdict of the comparisons.

        CONTRADICTED for a measurement that refutes any rate; otherwise NOT_RUN unless the measured
        number is finite.
        """
        estimated = estimate(measured)
        if estimated.refuted:
            return CONTRADICTED
        if not math.isfinite(estimated.value):
            return NOT_RUN
        verdicts = {comparison.verdict(self.met) for comparison in self.comparisons(measured)}
        worst_first = (NOT_RUN, CONTRADICTED, EXCEEDS)
        return next((word for word in worst_first if word in verdicts), self.met)

    def slack(self, measured: Measurement) -> float:
        """The factor between measured number and bound where the bound HOLDS; NaN elsewhere."""
        if self.met != HOLDS or self.verdict(measured) != HOLDS:
            return math.nan
        factors = [
            comparison.slack
            for comparison in self.comparisons(measured)
            if math.isfinite(comparison.slack)
        ]
        return min(factors, default=math.nan)


@dataclass(frozen=True, kw_only=True)
class Interval(Bound):
    """A closed interval for one number.

    Attributes
    ----------
    round_off
        tolerance for rounding beyond either end
    uncertainty
        standard error of the ends, 0 for printed ones: two standard errors, of the ends and of the
        measured number, are tolerated in addition; None for no tolerance
    better
        the side on which a number is better than claimed: ABOVE, BELOW or 0
    largest_tolerance
        largest tolerance for standard errors
    """

    round_off: float = 0.0
    uncertainty: float | None = None
    better: int = 0
    largest_tolerance: float = math.inf

    @property
    @abstractmethod
    def ends_text(self) -> str:
        """The ends in words, without tolerances."""

    @property
    @abstractmethod
    def ends(self) -> tuple[float, float]:
        """(low, high)."""

    @property
    def text(self) -> str:
        tolerances = [in_words(self.round_off)] if self.round_off else []
        if self.uncertainty is not None:
            of_both = " of both" if self.uncertainty else ""
            at_most = (
                f" ({in_words(self.largest_tolerance)} at most)"
                if self.largest_tolerance < math.inf
                else ""
            )
            tolerances.append(f"two standard errors{of_both}{at_most}")
        low, high = self.ends
        if -math.inf < low and high < math.inf:
            joint = " plus " if " within " in self.ends_text else " within "
            return joint.join(filter(None, (self.ends_text, " plus ".join(tolerances))))
        return (" minus " if high == math.inf else " plus ").join([self.ends_text, *tolerances])

    def comparisons(self, measured: Measurement) -> tuple[Comparison, ...]:
        tolerance = self.round_off + min(
            standard_errors(measured, self.uncertainty), self.largest_tolerance
        )
        return (Comparison(estimate(measured).value, *self.ends, self.better, tolerance),)


@dataclass(frozen=True)
class Limit(Interval):
    """An interval with one end; `side` is "at most", "at least", "above" or "below"."""

    limit: float
    side: str = field(kw_only=True)

    @property
    def ends_text(self) -> str:
        return f"{self.side} {in_words(self.limit, self.round_off)}"

    @property
    def ends(self) -> tuple[float, float]:
        return {
            "at most": (-math.inf, self.limit),
            "at least": (self.limit, math.inf),
            "above": (math.nextafter(self.limit, math.inf), math.inf),
            "below": (-math.inf, math.nextafter(self.limit, -math.inf)),
        }[self.side]


AtMost, AtLeast = partial(Limit, side="at most"), partial(Limit, side="at least")
Above, Below = partial(Limit, side="above"), partial(Limit, side="below")


@dataclass(frozen=True)
class Within(Interval):
    """low <= measured <= high."""

    low: float
    high: float

    @property
    def ends_text(self) -> str:
        return f"{in_words(self.low)} to {in_words(self.high)}"

    @property
    def ends(self) -> tuple[float, float]:
        return self.low, self.high


@dataclass(frozen=True)
class Exactly(Interval):
    """measured == value, for counts and fractions."""

    value: float

    @property
    def ends_text(self) -> str:
        return f"exactly {in_words(self.value)}"

    @property
    def ends(self) -> tuple[float, float]:
        return self.value, self.value


@dataclass(frozen=True)
class Near(Interval):
    """claimed - resolution <= measured <= claimed + resolution."""

    claimed: float
    resolution: float
    noun: str = field(default="", kw_only=True)
    met: ClassVar[str] = ATTAINED

    @property
    def ends_text(self) -> str:
        claimed = in_words(self.claimed, self.resolution)
        return f"{self.noun} {claimed} within {in_words(self.resolution)}".lstrip()

    @property
    def ends(self) -> tuple[float, float]:
        return self.claimed - self.resolution, self.claimed + self.resolution


@dataclass(frozen=True)
class Order(Near):
    """The order of a Fit, error = O(h^claimed); a larger order is better.

    Standard errors are tolerated up to one more resolution, so that scatter does not meet an order.
    """

    resolution: float = ORDER_RESOLUTION
    uncertainty: float | None = field(default=0.0, kw_only=True)
    better: int = field(default=ABOVE, kw_only=True)
    noun: str = field(default="order", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "largest_tolerance", self.resolution)


@dataclass(frozen=True)
class Base(Near):
    """The base of a Fit, error = O(claimed^n); a smaller base is better.

    Standard errors are tolerated up to two more resolutions, one unit of the last printed digit.
    """

    uncertainty: float | None = field(default=0.0, kw_only=True)
    better: int = field(default=BELOW, kw_only=True)
    noun: str = field(default="base", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "largest_tolerance", 2.0 * self.resolution)


@dataclass(frozen=True)
class Converges(Bound):
    """The order of a Fit exceeds 0 by two standard errors."""

    text = "order above 0 by 2 standard errors"

    def comparisons(self, measured: Measurement) -> tuple[Comparison, ...]:
        low = math.nextafter(standard_errors(measured, 0.0), math.inf)
        return (Comparison(estimate(measured).value, low=low),)


@dataclass(frozen=True)
class Finding(Bound):
    """A number about which the source says nothing: FINDING where `our_bound` is met or None, else
    CONTRADICTED."""

    our_bound: Bound | None = None
    met: ClassVar[str] = FINDING

    @property
    def text(self) -> str:
        return self.our_bound.text if self.our_bound else "none"

    def comparisons(self, measured: Any) -> tuple[Comparison, ...]:
        comparisons = self.our_bound.comparisons(measured) if self.our_bound else ()
        return tuple(replace(comparison, better=0) for comparison in comparisons)


@dataclass(frozen=True)
class Reported(Bound):
    """A number that the source measured.

    The verdict is that of `reported` where that bound is met; NOT_REPRODUCED where `instead`, the
    bound of the value measured here, is met; otherwise CONTRADICTED or NOT_RUN.
    """

    reported: Bound
    instead: Bound

    @property
    def text(self) -> str:
        return f"{self.reported.text}; or, not reproduced, {self.instead.text}"

    def comparisons(self, measured: Any) -> tuple[Comparison, ...]:
        return tuple(
            replace(comparison, better=0) for comparison in self.reported.comparisons(measured)
        )

    def verdict(self, measured: Measurement) -> str:
        verdict = super().verdict(measured)
        if verdict == HOLDS:
            return self.reported.met
        is_own_value = Finding(self.instead).verdict(measured) == FINDING
        return NOT_REPRODUCED if is_own_value else verdict


def standard_errors(measured: Measurement, uncertainty: float | None) -> float:
    """Twice the sum of the standard errors of the measured and the claimed number; 0 where
    `uncertainty` is None."""
    error = estimate(measured).uncertainty
    return 0.0 if uncertainty is None else 2.0 * ((error or 0.0) + uncertainty)


def in_words(value: float, resolution: float = 0.0) -> str:
    """The number as text with four digits, or as many as the resolution requires."""
    digits = 4
    if resolution > 0.0 and abs(value) > resolution:
        digits = max(digits, 1 + math.ceil(math.log10(abs(value) / resolution)))
    return f"{value:.{digits}g}"

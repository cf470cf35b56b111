"""Bounds on measured numbers, as values that give both their text and the verdict.

Each bound states its comparisons in numbers and in words; `Bound.verdict` is the only rule that
turns them into a verdict. NaN never holds. The verdicts, one meaning each:

attained      a rate, order or constant is met within its uncertainty
holds         an inequality or a qualitative statement is true, with the row's slack
exceeds       a rate or order is better than claimed, beyond that uncertainty
contradicted  false under the source's own protocol, in the reading that the row's reason states
finding       true, but of our own: the source says nothing about it
not run       nothing was measured
"""

from __future__ import annotations

import math
from abc import ABC, abstractmethod
from dataclasses import dataclass, field, replace
from typing import Any, ClassVar

from benchmarks.statistics.convergence_fits import Decay
from benchmarks.statistics.drift import Drift
from benchmarks.statistics.estimate import Measurement, estimate

ATTAINED = "attained"
HOLDS = "holds"
EXCEEDS = "exceeds"
CONTRADICTED = "contradicted"
FINDING = "finding"
NOT_RUN = "not run"
VERDICTS = (ATTAINED, HOLDS, EXCEEDS, CONTRADICTED, FINDING, NOT_RUN)

ORDER_RESOLUTION = 0.25  # the papers print orders as multiples of a half
GROWTH = 0.025  # largest change over a run of an error that does not grow: half of what is seen
SIGMAS = 5.0  # standard errors of that change which must fit into it
ABOVE, BELOW = 1, -1


@dataclass(frozen=True)
class Comparison:
    """A number and the closed interval that it should lie in.

    better  the side of the interval on which the number is better than claimed: ABOVE, BELOW or 0
    room    tolerance beyond either end
    """

    number: float
    low: float = -math.inf
    high: float = math.inf
    better: int = 0
    room: float = 0.0

    def verdict(self, met: str) -> str:
        """`met` inside the interval, EXCEEDS or CONTRADICTED outside, NOT_RUN without a number."""
        low, high = self.low - self.room, self.high + self.room
        if any(math.isnan(x) for x in (self.number, low, high)):
            return NOT_RUN
        if low <= self.number <= high:
            return met
        beyond = ABOVE if self.number > high else BELOW
        return EXCEEDS if beyond == self.better else CONTRADICTED

    @property
    def slack(self) -> float:
        """The factor by which the number may grow or shrink before it reaches an end.

        NaN for a number or an end that is not positive, and where there is no end.
        """
        if not self.number > 0.0:
            return math.nan
        low, high = self.low - self.room, self.high + self.room
        factors = [high / self.number, self.number / low if low > 0.0 else math.inf]
        return min(factors) if 0.0 < min(factors) < math.inf else math.nan


class Bound(ABC):
    """A bound on a measurement.

    met  the verdict where every comparison is met: ATTAINED for a rate, order or constant
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
        """The worst of the comparisons; NOT_RUN unless the measured number is finite."""
        seen = estimate(measured)
        if seen.refuted:
            return CONTRADICTED
        if not math.isfinite(seen.value):
            return NOT_RUN
        verdicts = {one.verdict(self.met) for one in self.comparisons(measured)}
        worst_first = (NOT_RUN, CONTRADICTED, EXCEEDS)
        return next((word for word in worst_first if word in verdicts), self.met)

    def slack(self, measured: Measurement) -> float:
        """The factor between measured number and bound where the bound HOLDS; NaN elsewhere."""
        if self.met != HOLDS or self.verdict(measured) != HOLDS:
            return math.nan
        factors = [one.slack for one in self.comparisons(measured) if math.isfinite(one.slack)]
        return min(factors, default=math.nan)


@dataclass(frozen=True, kw_only=True)
class Interval(Bound):
    """A closed interval for one number.

    round_off    tolerance for rounding beyond either end
    uncertainty  standard error of the ends, 0 for printed ones: two standard errors, of the ends
                 and of the measured number, are tolerated in addition; None for no tolerance
    better       the side on which a number is better than claimed: ABOVE, BELOW or 0
    most         largest tolerance for standard errors
    """

    round_off: float = 0.0
    uncertainty: float | None = None
    better: int = 0
    most: float = math.inf

    @property
    @abstractmethod
    def words(self) -> str:
        """The ends in words, without tolerances."""

    @property
    @abstractmethod
    def ends(self) -> tuple[float, float]:
        """(low, high)."""

    @property
    def text(self) -> str:
        room = [_number(self.round_off)] if self.round_off else []
        if self.uncertainty is not None:
            both = " of both" if self.uncertainty else ""
            most = f" ({_number(self.most)} at most)" if self.most < math.inf else ""
            room.append(f"two standard errors{both}{most}")
        low, high = self.ends
        if -math.inf < low and high < math.inf:
            joint = " plus " if " within " in self.words else " within "
            return joint.join(filter(None, (self.words, " plus ".join(room))))
        return (" minus " if high == math.inf else " plus ").join([self.words, *room])

    def comparisons(self, measured: Measurement) -> tuple[Comparison, ...]:
        room = self.round_off + min(_errors(measured, self.uncertainty), self.most)
        return (Comparison(estimate(measured).value, *self.ends, self.better, room),)


@dataclass(frozen=True)
class Limit(Interval):
    """An interval with one end; `word` is what the text says before the limit."""

    limit: float
    word: ClassVar[str]

    @property
    def words(self) -> str:
        return f"{self.word} {_number(self.limit, self.round_off)}"


@dataclass(frozen=True)
class AtMost(Limit):
    """measured <= limit."""

    word: ClassVar[str] = "at most"

    @property
    def ends(self) -> tuple[float, float]:
        return -math.inf, self.limit


@dataclass(frozen=True)
class AtLeast(Limit):
    """measured >= limit."""

    word: ClassVar[str] = "at least"

    @property
    def ends(self) -> tuple[float, float]:
        return self.limit, math.inf


@dataclass(frozen=True)
class Above(Limit):
    """measured > limit."""

    word: ClassVar[str] = "above"

    @property
    def ends(self) -> tuple[float, float]:
        return math.nextafter(self.limit, math.inf), math.inf


@dataclass(frozen=True)
class Below(Limit):
    """measured < limit."""

    word: ClassVar[str] = "below"

    @property
    def ends(self) -> tuple[float, float]:
        return -math.inf, math.nextafter(self.limit, -math.inf)


@dataclass(frozen=True)
class Within(Interval):
    """low <= measured <= high."""

    low: float
    high: float

    @property
    def words(self) -> str:
        return f"{_number(self.low)} to {_number(self.high)}"

    @property
    def ends(self) -> tuple[float, float]:
        return self.low, self.high


@dataclass(frozen=True)
class Exactly(Interval):
    """measured == value, for counts and shares."""

    value: float

    @property
    def words(self) -> str:
        return f"exactly {_number(self.value)}"

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
    def words(self) -> str:
        claimed = _number(self.claimed, self.resolution)
        return f"{self.noun} {claimed} within {_number(self.resolution)}".lstrip()

    @property
    def ends(self) -> tuple[float, float]:
        return self.claimed - self.resolution, self.claimed + self.resolution


@dataclass(frozen=True)
class Order(Near):
    """error = O(h^claimed), of a Fit: a larger order is better. No scatter meets an order: standard
    errors are tolerated up to one more resolution."""

    resolution: float = ORDER_RESOLUTION
    uncertainty: float | None = field(default=0.0, kw_only=True)
    better: int = field(default=ABOVE, kw_only=True)
    noun: str = field(default="order", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "most", self.resolution)


@dataclass(frozen=True)
class Base(Near):
    """error = O(claimed^n), of a Fit: a smaller base is better. Standard errors are tolerated up to
    two more resolutions, one unit of the last printed digit."""

    uncertainty: float | None = field(default=0.0, kw_only=True)
    better: int = field(default=BELOW, kw_only=True)
    noun: str = field(default="base", kw_only=True)

    def __post_init__(self) -> None:
        object.__setattr__(self, "most", 2.0 * self.resolution)


@dataclass(frozen=True)
class Converges(Bound):
    """The order of a Fit exceeds 0 by two standard errors."""

    text = "order above 0 by 2 standard errors"

    def comparisons(self, measured: Measurement) -> tuple[Comparison, ...]:
        low = math.nextafter(_errors(measured, 0.0), math.inf)
        return (Comparison(estimate(measured).value, low=low),)


@dataclass(frozen=True)
class Geometric(Bound):
    """Errors of a Decay shrink geometrically with n, by a factor that does not tend to 1: for a
    power of n the later half would be slower than the earlier."""

    text = "base below 1 by 2 standard errors, later half of the window not slower"

    def comparisons(self, measured: Decay) -> tuple[Comparison, ...]:
        early, late = measured.early, measured.late
        room = 2.0 * math.hypot(early.uncertainty, late.uncertainty)
        below_one = math.nextafter(1.0 - _errors(measured, 0.0), -math.inf)
        return (
            Comparison(measured.fit.rate, high=below_one),
            Comparison(late.rate, high=early.rate, room=room),
        )


@dataclass(frozen=True)
class FactorPerN(Bound):
    """Each increase of n multiplies the error of a Decay by at most `limit` < 1, until round-off;
    for a power of n the worst of these factors would be near 1."""

    limit: float

    @property
    def text(self) -> str:
        return f"each n multiplies the error by at most {_number(self.limit)}, until round-off"

    def comparisons(self, measured: Decay) -> tuple[Comparison, ...]:
        return (Comparison(measured.worst, high=self.limit),)


@dataclass(frozen=True)
class NoGrowth(Bound):
    """The largest error of a Drift is at most `limit`, and neither mean nor maxima change.

    Twice GROWTH over the run is seen, as a trend of the mean in either direction or as a growth of
    the maxima over a period. Where the standard errors are too large for that, a change beyond
    SIGMAS of them is still CONTRADICTED; otherwise the run is too short to tell.

    round_off   level, stated by the study, below which a change is attributed to rounding
    conclusive  whether a run too short to tell is NOT_RUN, or else tells what it can
    """

    limit: float
    round_off: float = 0.0
    conclusive: bool = True

    @property
    def text(self) -> str:
        rounded = f" or {_number(self.round_off)}" if self.round_off else ""
        return (
            f"at most {_number(self.limit)}; over the run the mean, and the maxima of its periods, "
            f"change by at most {100.0 * GROWTH:g} %{rounded}, or by {SIGMAS:g} standard errors "
            "where that is more"
        )

    def comparisons(self, measured: Drift) -> tuple[Comparison, ...]:
        largest = Comparison(measured.largest, high=self.limit)
        if measured.largest <= self.round_off:
            return (largest,)
        room = max(GROWTH, self.round_off / measured.largest)
        sizes = (abs(measured.trend), measured.growth)
        errors = (SIGMAS * measured.trend_error, SIGMAS * measured.growth_error)
        beyond = [size - max(room, error) for size, error in zip(sizes, errors, strict=True)]
        short = self.conclusive and max(errors) > room
        if short and max(beyond) <= 0.0 and measured.largest <= self.limit:
            beyond = [math.nan]
        return (largest, *(Comparison(excess, high=0.0) for excess in beyond))


@dataclass(frozen=True)
class Finding(Bound):
    """A number about which the source says nothing, with a bound of our own or none: FINDING where
    that is met, and CONTRADICTED where it is not."""

    own: Bound | None = None
    met: ClassVar[str] = FINDING

    @property
    def text(self) -> str:
        return self.own.text if self.own else "none"

    def comparisons(self, measured: Any) -> tuple[Comparison, ...]:
        found = self.own.comparisons(measured) if self.own else ()
        return tuple(replace(one, better=0) for one in found)


def _errors(measured: Measurement, uncertainty: float | None) -> float:
    """Two standard errors, of measured and claimed number combined; 0 where there are none."""
    own = estimate(measured).uncertainty
    return 0.0 if uncertainty is None else 2.0 * ((0.0 if own is None else own) + uncertainty)


def _number(value: float, resolution: float = 0.0) -> str:
    """The number as text with four digits, or as many as the resolution requires."""
    digits = 4
    if resolution > 0.0 and abs(value) > resolution:
        digits = max(digits, 1 + math.ceil(math.log10(abs(value) / resolution)))
    return f"{value:.{digits}g}"

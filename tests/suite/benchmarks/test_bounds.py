"""Each bound from both sides, with NaN, and its text against its verdict."""

from __future__ import annotations

import math
import re
from dataclasses import replace
from inspect import isabstract

import pytest
from hypothesis import given
from hypothesis import strategies as st

from benchmarks.checks.bounds import (
    ABOVE,
    ATTAINED,
    BELOW,
    CONTRADICTED,
    EXCEEDS,
    FINDING,
    HOLDS,
    NOT_REPRODUCED,
    NOT_RUN,
    Above,
    AtLeast,
    AtMost,
    Base,
    Below,
    Bound,
    Converges,
    Exactly,
    Finding,
    Interval,
    Near,
    Order,
    Reported,
    Within,
)
from benchmarks.checks.series_bounds import LARGEST_GROWTH, SIGMAS, FactorPerN, Geometric, NoGrowth
from benchmarks.statistics.convergence_fits import Decay, Fit
from benchmarks.statistics.drift import Drift
from benchmarks.statistics.estimate import Estimate, Measurement

NAN = math.nan
BOUNDS: tuple[Bound, ...] = (
    AtMost(1.0), AtLeast(1.0), Above(1.0), Below(1.0), Within(0.5, 1.0), Exactly(1.0),
    Near(1.0, 0.1), Order(1.0), Base(0.5, 0.1), Converges(), Geometric(), FactorPerN(0.5),
    NoGrowth(1.0), Finding(), Finding(Order(1.0)), Reported(Order(1.0), Order(2.0)),
)  # fmt: skip


def fit(rate: float, uncertainty: float = 0.001) -> Fit:
    return Fit("geometric", rate, uncertainty, (1.0, 9.0), 9, 1.0)


def decay(overall: Fit, early: Fit, late: Fit, worst: float = 0.5) -> Decay:
    return Decay(overall, early, late, worst, 1e-12)


def test_every_class_of_bounds_is_tested() -> None:
    def subclasses(parent: type) -> set[type]:
        children = parent.__subclasses__()
        return {parent, *(grandchild for child in children for grandchild in subclasses(child))}

    classes = {subclass for subclass in subclasses(Bound) if not isabstract(subclass)}
    assert {type(bound) for bound in BOUNDS} == classes


# Parses the text of a bound independently of the code under test.

NUMBER = r"-?[0-9.]+(?:e[-+]?[0-9]+)?"
FORMS = {
    rf"at most ({NUMBER})": lambda x: (-math.inf, x),
    rf"at least ({NUMBER})": lambda x: (x, math.inf),
    rf"above ({NUMBER})": lambda x: (x, math.inf),
    rf"below ({NUMBER})": lambda x: (-math.inf, x),
    rf"exactly ({NUMBER})": lambda x: (x, x),
    rf"({NUMBER}) to ({NUMBER})": lambda low, high: (low, high),
    rf"(?:order |base )?({NUMBER})": lambda x: (x, x),
}
ALLOWED = (
    rf"(?: (?:plus|minus|within) ({NUMBER}))?(?: (?:plus|minus|within) (two) standard errors"
    rf"( of both)?(?: \(({NUMBER}) at most\))?)?"
)


def interval(text: str, standard_error: float, claimed_error: float) -> tuple[float, float]:
    """The interval that the text allows for a number with this standard error, where the claimed
    number has the standard error ``claimed_error``."""
    for form, ends in FORMS.items():
        match = re.fullmatch(form + ALLOWED, text)
        if match:
            *numbers, margin, errors_text, of_both, limit = match.groups()
            low, high = ends(*map(float, numbers))
            both = standard_error + (claimed_error if of_both else 0.0)
            tolerance = min(2.0 * both if errors_text else 0.0, float(limit or math.inf))
            tolerance += float(margin or 0.0)
            return low - tolerance, high + tolerance
    raise AssertionError(f"no reading of {text!r}")


decimals = st.builds(
    lambda digits, power: float(f"{digits}e{power}"),
    st.integers(1, 9999),
    st.integers(-12, 3),
)
relative_margins = st.sampled_from([0.0, 1e-3, 0.02, 0.25])
relative_errors = st.one_of(st.none(), st.just(0.0), st.floats(1e-4, 0.1))


@st.composite
def bounds_on_a_number(draw: st.DrawFn) -> tuple[Interval, float]:
    """A bound on one number, and a standard error of that number."""
    x, y = sorted((draw(decimals), draw(decimals)))
    margin = float(f"{draw(relative_margins) * x:.4g}")
    relative_error = draw(relative_errors)
    claimed_error = None if relative_error is None else relative_error * x
    allowed = {"round_off": margin, "uncertainty": claimed_error}
    bounds = [
        AtMost(x, **allowed),
        AtLeast(x, **allowed),
        Above(x),
        Below(x),
        Exactly(x),
        Within(x, y, **allowed),
        Near(x, margin, uncertainty=claimed_error),
        Order(x, margin or 0.25, uncertainty=claimed_error or 0.0),
        Base(x, margin or 0.25, uncertainty=claimed_error or 0.0),
    ]
    return draw(st.sampled_from(bounds)), x * draw(st.sampled_from([0.0, 1e-3, 0.05]))


@given(bounds_on_a_number())
def test_a_number_just_inside_the_text_holds_and_one_just_outside_does_not(
    drawn: tuple[Interval, float],
) -> None:
    bound, standard_error = drawn
    low, high = interval(bound.text, standard_error, bound.uncertainty or 0.0)
    nudge = 1e-9 * max(abs(end) for end in (low, high) if math.isfinite(end))

    def verdict(value: float) -> str:
        return bound.verdict(Estimate(value, standard_error))

    better = {Order: ABOVE, Base: BELOW}.get(type(bound), 0)
    if math.isfinite(low):
        assert verdict(low - nudge) == (EXCEEDS if better == BELOW else CONTRADICTED)
        assert low == high or verdict(low + nudge) == bound.met
    if math.isfinite(high):
        assert verdict(high + nudge) == (EXCEEDS if better == ABOVE else CONTRADICTED)
        assert low == high or verdict(high - nudge) == bound.met
    assert verdict(NAN) == NOT_RUN


@given(x=decimals, y=decimals)
def test_a_bound_holds_at_itself_unless_it_says_above_or_below(x: float, y: float) -> None:
    low, high = sorted((x, y))
    for bound in (AtMost(x), AtLeast(x), Exactly(x), Within(x, x), Near(x, 0.0)):
        assert bound.verdict(x) == (ATTAINED if isinstance(bound, Near) else HOLDS)
    assert Within(low, high).verdict(low) == Within(low, high).verdict(high) == HOLDS
    assert Above(x).verdict(x) == Below(x).verdict(x) == CONTRADICTED


@given(limit=decimals, share=st.sampled_from([0.0, 1e-3]), conclusive=st.booleans())
def test_growth_is_judged_by_the_numbers_of_its_text(
    limit: float, share: float, conclusive: bool
) -> None:
    level = float(f"{share * limit:.4g}")
    bound = NoGrowth(limit, level, conclusive)
    numbers = [float(x) for x in re.findall(NUMBER, bound.text)]
    assert numbers == [limit, 100.0 * LARGEST_GROWTH, *([level] if level else []), SIGMAS]
    change, error = LARGEST_GROWTH, LARGEST_GROWTH / SIGMAS
    measured = Drift(change, error, change, error, limit)
    assert bound.verdict(measured) == HOLDS and bound.slack(measured) == 1.0
    for outside in (
        {"largest": 1.001 * limit},
        {"trend": 1.001 * change},
        {"trend": -1.001 * change},
        {"growth": 1.001 * change},
        {"growth": math.inf},
    ):
        assert bound.verdict(replace(measured, **outside)) == CONTRADICTED
    assert bound.verdict(replace(measured, growth=-9.0)) == HOLDS  # it decays
    for unclear in ({"trend_error": 1.1 * error}, {"growth_error": 1.1 * error}):
        too_short = replace(measured, **unclear)
        assert bound.verdict(too_short) == (NOT_RUN if conclusive else HOLDS)
        assert (
            bound.verdict(replace(too_short, trend=1.2 * change, growth=1.2 * change))
            == CONTRADICTED
        )
        assert bound.verdict(replace(too_short, largest=1.001 * limit)) == CONTRADICTED
    if level:
        grown = Drift(9.0, 0.1, 9.0, 0.1, level)
        assert bound.verdict(grown) == HOLDS
        assert bound.verdict(replace(grown, largest=1.001 * level)) == CONTRADICTED
        # A trend of a tenth of the largest error is below the level up to ten levels.
        small_trend = replace(grown, trend=0.1, growth=0.0, trend_error=0.0, growth_error=0.0)
        assert bound.verdict(replace(small_trend, largest=9.9 * level)) == HOLDS
        assert bound.verdict(replace(small_trend, largest=10.1 * level)) == CONTRADICTED


@given(limit=st.integers(1, 999).map(lambda k: k / 1000))
def test_every_n_has_to_gain_what_the_text_says(limit: float) -> None:
    bound, rate = FactorPerN(limit), fit(0.05)
    (printed,) = map(float, re.findall(NUMBER, bound.text))

    def verdict(worst: float, overall: Fit = rate) -> str:
        return bound.verdict(decay(overall, rate, rate, worst))

    assert verdict(printed) == HOLDS
    assert verdict(printed * 1.001) == CONTRADICTED
    assert verdict(NAN) == NOT_RUN
    assert verdict(printed, fit(NAN)) == NOT_RUN
    assert verdict(printed, replace(rate, relapse=True)) == CONTRADICTED


def test_more_digits_are_printed_where_a_fine_resolution_asks_for_them() -> None:
    assert Near(1.0 / 3.0, 1e-11).text == "0.333333333333 within 1e-11"
    assert AtMost(math.sqrt(2.5), round_off=1e-6).text == "at most 1.5811388 plus 1e-06"
    assert Order(5.49873).text == "order 5.499 within 0.25 plus two standard errors (0.25 at most)"
    assert (
        Base(NAN, 0.005, uncertainty=NAN).text
        == "base nan within 0.005 plus two standard errors of both (0.01 at most)"
    )


def unknown() -> list[Measurement]:
    """Measurements with a number that is missing or not finite."""
    measured, unmeasured = fit(0.5), fit(NAN, NAN)
    return [
        NAN,
        math.inf,
        -math.inf,
        Estimate(NAN),
        Estimate(NAN, 0.1),
        unmeasured,
        fit(NAN),
        decay(unmeasured, unmeasured, unmeasured, NAN),
        decay(unmeasured, measured, measured),
        Drift(NAN, NAN, NAN, NAN, NAN),
        Drift(0.0, 0.0, 0.0, 0.0, NAN),
    ]


@pytest.mark.parametrize("bound", BOUNDS, ids=lambda bound: bound.text)
def test_what_was_not_measured_never_holds(bound: Bound) -> None:
    assert {bound.verdict(measurement) for measurement in unknown()} == {NOT_RUN}


@pytest.mark.parametrize(
    ("bound", "measured"),
    [
        (AtMost(NAN), 1.0),
        (AtLeast(1.0, uncertainty=NAN), 2.0),
        (Order(4.0), fit(4.0, NAN)),
        (Base(0.56, 0.005), fit(0.5, NAN)),
        (Base(NAN, 0.005), fit(0.5)),
        (Converges(), fit(1.0, NAN)),
        (Geometric(), decay(fit(0.5), fit(NAN), fit(0.5))),
        (Geometric(), decay(fit(0.5), fit(0.5), fit(0.5, NAN))),
        (NoGrowth(1.0), Drift(NAN, NAN, 0.0, 0.0, 0.5)),
        (NoGrowth(1.0, conclusive=False), Drift(0.0, 0.0, NAN, NAN, 0.5)),
    ],
)
def test_a_bound_that_is_not_known_and_a_rate_without_uncertainty_never_hold(
    bound: Bound, measured: Measurement
) -> None:
    assert bound.verdict(measured) == NOT_RUN


@pytest.mark.parametrize(
    "large", [replace(fit(NAN), stays_large=True), replace(fit(4.0), relapse=True)]
)
def test_errors_that_stay_or_become_large_contradict_any_rate(large: Fit) -> None:
    for bound in (Order(4.0), Base(0.56, 0.005), Converges(), AtMost(9.0), Near(4.0, 1.0)):
        assert bound.verdict(large) == CONTRADICTED
    assert Geometric().verdict(decay(large, fit(0.5), fit(0.5))) == CONTRADICTED


def test_what_the_source_does_not_say_is_a_finding() -> None:
    assert (Finding().text, Finding().verdict(3.0)) == ("none", FINDING)
    finding = Finding(Order(4.0))
    assert finding.text == Order(4.0).text
    assert [finding.verdict(fit(rate)) for rate in (4.0, 5.0, 3.0)] == [
        FINDING,
        *[CONTRADICTED] * 2,
    ]


@given(limit=decimals, factor=st.floats(1.0, 1e6))
def test_the_slack_is_the_factor_between_a_number_and_its_bound(
    limit: float, factor: float
) -> None:
    assert AtMost(limit).slack(limit / factor) == pytest.approx(factor)
    assert AtLeast(limit).slack(limit * factor) == pytest.approx(factor)
    inside = Within(limit, 4.0 * limit).slack(limit * min(factor, 4.0))
    assert inside == pytest.approx(min(min(factor, 4.0), 4.0 / min(factor, 4.0)))


def test_only_what_holds_has_a_slack() -> None:
    slacks = (
        AtMost(1.0).slack(1.1),
        AtMost(1.0).slack(0.0),
        AtMost(1.0).slack(NAN),
        AtLeast(-1.0).slack(2.0),
        Order(4.0).slack(fit(4.0)),
        Finding(AtMost(1.0)).slack(0.5),
    )
    assert all(math.isnan(slack) for slack in slacks)


def test_what_converges_has_an_order_above_zero() -> None:
    assert Converges().verdict(fit(0.0021)) == HOLDS
    assert Converges().verdict(fit(0.0019)) == CONTRADICTED
    assert Converges().verdict(fit(0.0, 0.0)) == CONTRADICTED


@pytest.mark.parametrize(
    ("overall", "late", "verdict"),
    [
        # limits: 0.7 + 2 hypot(0.001, 0.001), and 1 - 2 * 0.001
        (0.7, 0.7028, HOLDS),
        (0.7, 0.7029, CONTRADICTED),
        (0.9979, 0.7, HOLDS),
        (0.9981, 0.7, CONTRADICTED),
    ],
)
def test_a_geometric_fall_is_below_one_and_does_not_slow_down(
    overall: float, late: float, verdict: str
) -> None:
    assert Geometric().verdict(decay(fit(overall), fit(0.7), fit(late))) == verdict


@pytest.mark.parametrize(
    ("rate", "verdict"),
    [
        (4.0, ATTAINED),
        (6.0, NOT_REPRODUCED),
        (8.0, CONTRADICTED),
        (2.0, CONTRADICTED),
        (NAN, NOT_RUN),
    ],
)
def test_a_reported_order_is_not_reproduced_only_where_our_own_value_is_met(
    rate: float, verdict: str
) -> None:
    """A better order is not EXCEEDS, and one that misses our own bound too is CONTRADICTED."""
    bound = Reported(Order(4.0), Order(6.0))
    assert bound.verdict(fit(rate)) == verdict
    assert "or, not reproduced, order 6" in bound.text


def test_a_larger_order_exceeds_a_claim_unless_it_is_of_an_exact_order() -> None:
    assert Order(4.0).verdict(fit(6.0)) == EXCEEDS
    assert Order(4.0, better=0).verdict(fit(6.0)) == CONTRADICTED

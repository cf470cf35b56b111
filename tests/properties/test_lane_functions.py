"""Vector functions against mpmath: errors in units of the last place, and edges of the domains;
1 / x, 1 / sqrt(x) and x^(-7/4), with and without the processor's estimates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from types import SimpleNamespace
from typing import Any

import mpmath as mp
import numpy as np
import pytest

from galvi.lanes import functions
from galvi.lanes.vectors import AVX512
from tests.properties.lane_functions import compiled

NAN, INFINITY = float("nan"), float("inf")
SAMPLES = 3_000
DIGITS = 40
INTERVAL_FACTOR = 1.0001  # of the interval of a series, for arguments whose reduction is rounded
NEAR_ZERO = 1e-9  # below, the function is the first term of its series


def uniform(low: float, high: float) -> Callable[[Any, int], Any]:
    return lambda random, count: random.uniform(low, high, count)


def log_uniform(low: float, high: float) -> Callable[[Any, int], Any]:
    """Positive numbers whose logarithms are uniform."""
    return lambda random, count: np.exp(random.uniform(np.log(low), np.log(high), count))


def near_multiples(random: Any, count: int) -> Any:
    """Angles near multiples of pi / 2, of which little remains after the reduction."""
    k = random.integers(-(6 * 10**8), 6 * 10**8, count)
    return np.round(k * (np.pi / 2.0) * 2.0**20) / 2.0**20 if count % 2 else k * (np.pi / 2.0)


def signed_log_uniform(random: Any, count: int) -> Any:
    return log_uniform(1e-300, 1e300)(random, count) * random.choice([-1.0, 1.0], count)


@dataclass(frozen=True)
class Case:
    """A function of lanes and mpmath's, generators of its arguments, the number of values that it
    returns, the index of the one that is compared, and the bound of its error in units of the last
    place."""

    function: Any
    exact: Callable[..., Any]
    arguments: tuple[Callable[[Any, int], Any], ...]
    returned: int = 1
    which: int = 0
    limit: float = 1.0


CASES = {
    "sin": Case(functions.sine_cosine, mp.sin, (uniform(-10.0, 10.0),), 2, 0),
    "cos": Case(functions.sine_cosine, mp.cos, (uniform(-10.0, 10.0),), 2, 1),
    "sin of large": Case(functions.sine_cosine, mp.sin, (uniform(-1e9, 1e9),), 2, 0),
    "sin near multiples": Case(functions.sine_cosine, mp.sin, (near_multiples,), 2, 0),
    "sin of small": Case(functions.sine_cosine, mp.sin, (log_uniform(1e-300, 1.0),), 2, 0),
    "exp": Case(functions.exponential, mp.exp, (uniform(-708.0, 709.7),)),
    "exp near 0": Case(functions.exponential, mp.exp, (uniform(-1.0, 1.0),)),
    "log": Case(functions.logarithm, mp.log, (log_uniform(1e-307, 1e308),)),
    "log near 1": Case(functions.logarithm, mp.log, (uniform(0.5, 2.0),)),
    "sinh": Case(functions.hyperbolic_sine, mp.sinh, (uniform(-20.0, 20.0),), limit=2.5),
    "sinh near 0": Case(functions.hyperbolic_sine, mp.sinh, (log_uniform(1e-300, 1.5),), limit=2.5),
    "cosh": Case(functions.hyperbolic_cosine, mp.cosh, (uniform(-20.0, 20.0),), limit=2.5),
    "tanh": Case(functions.hyperbolic_tangent, mp.tanh, (uniform(-25.0, 25.0),), limit=3.0),
    "tanh near 0": Case(
        functions.hyperbolic_tangent, mp.tanh, (log_uniform(1e-300, 1.5),), limit=3.0
    ),
    "inverse fourth root": Case(
        functions.inverse_fourth_root, lambda x: x ** mp.mpf(-0.25), (log_uniform(1e-300, 1e300),)
    ),
    "sqrt": Case(functions.square_root, mp.sqrt, (log_uniform(1e-300, 1e300),)),
    "power": Case(functions.power, mp.power, (log_uniform(1e-80, 1e80), uniform(-3.5, 3.5))),
    "large power": Case(functions.power, mp.power, (uniform(0.1, 10.0), uniform(-300.0, 300.0))),
    "atan2": Case(functions.arctangent, mp.atan2, (uniform(-1.0, 1.0), uniform(-1.0, 1.0))),
    "atan2 of all sizes": Case(
        functions.arctangent, mp.atan2, (signed_log_uniform, signed_log_uniform)
    ),
}
each_case = pytest.mark.parametrize("case", CASES.values(), ids=CASES.keys())


def largest_error(case: Case, count: int) -> float:
    """The largest error in units of the last place of the exact number."""
    random = np.random.default_rng(7)
    inputs = [make(random, count) for make in case.arguments]
    values = compiled(case.function, len(inputs), case.returned)(*inputs)
    values = values[case.which] if case.returned > 1 else values
    worst = 0.0
    with mp.workdps(DIGITS):
        for value, *arguments in zip(values, *inputs, strict=True):
            exact = case.exact(*map(mp.mpf, map(float, arguments)))
            unit = float(np.spacing(abs(float(exact))))
            worst = max(worst, float(abs(mp.mpf(float(value)) - exact) / unit))
    return worst


@pytest.mark.parametrize("count", [SAMPLES, pytest.param(100_000, marks=pytest.mark.slow)])
@each_case
def test_a_function_errs_by_less_than_its_bound(case: Case, count: int) -> None:
    assert largest_error(case, count) < case.limit


def evaluated(function: Any, *arguments: list[float], returned: int = 1) -> Any:
    return compiled(function, len(arguments), returned)(*map(np.array, arguments))


def test_outside_its_domain_a_function_is_nan() -> None:
    outside = [NAN, INFINITY, -INFINITY, 1.0000001e9, -1e300]
    assert np.isnan(evaluated(functions.sine_cosine, outside, returned=2)).all()
    outside = [NAN, INFINITY, -INFINITY, 0.0, -0.0, -1.0, 1e-310]
    assert np.isnan(evaluated(functions.logarithm, outside)).all()
    assert np.isnan(evaluated(functions.power, outside, [2.5] * len(outside))).all()
    assert np.isnan(evaluated(functions.square_root, [NAN, -1.0, -INFINITY])).all()
    outside = [NAN, -1.0, 0.0, 1e-310, INFINITY, -INFINITY]
    assert np.isnan(evaluated(functions.inverse_fourth_root, outside)).all()
    assert np.isnan(evaluated(functions.exponential, [NAN])).all()
    assert np.isnan(evaluated(functions.arctangent, [0.0, NAN, 1.0], [0.0, 1.0, NAN])).all()


def test_at_the_edges_of_its_range_a_function_is_right() -> None:
    large = [709.782, 709.79, 1e300, INFINITY, -745.0, -746.0, -INFINITY, -720.0]
    with np.errstate(over="ignore", under="ignore"):
        np.testing.assert_allclose(
            evaluated(functions.exponential, large), np.exp(large), rtol=3e-16, atol=5e-324
        )
    y, x = [0.0, 0.0, 1.0, -1.0, 1.0, -1.0], [1.0, -1.0, 0.0, 0.0, 1e308, -1e308]
    np.testing.assert_array_max_ulp(evaluated(functions.arctangent, y, x), np.arctan2(y, x), 1)
    sine, cosine = evaluated(functions.sine_cosine, [0.0, 5e-324, 1e-200, 1e9], returned=2)
    np.testing.assert_array_equal(sine[:3], [0.0, 5e-324, 1e-200])
    np.testing.assert_array_equal(cosine[:3], 1.0)
    np.testing.assert_array_max_ulp(
        evaluated(functions.power, [2.0, 2.0], [-1022.0, 1023.0]),
        np.array([2.0**-1022, 2.0**1023]),
        1,
    )


def series(function: Callable[[Any], Any], low: Any, high: Any, degree: int) -> list[Any]:
    """Coefficients, ascending, of the interpolating polynomial at Chebyshev points."""
    half = (high - low) / 2
    nodes = [
        low + half + half * mp.cos(mp.pi * (2 * k + 1) / (2 * degree + 2))
        for k in range(degree + 1)
    ]
    matrix = mp.matrix([[x**j for j in range(degree + 1)] for x in nodes])
    return list(mp.lu_solve(matrix, mp.matrix([function(x) for x in nodes])))


def series_of_functions() -> dict[str, tuple[Callable[[Any], Any], Any, Any, int]]:
    """Name -> function of z, the ends of its interval, and the degree of its series."""
    squared_quarter_turn, half_log_2 = (
        (mp.pi / 4) ** 2 * INTERVAL_FACTOR,
        mp.log(2) / 2 * INTERVAL_FACTOR,
    )
    squared_ratio = ((mp.sqrt(2) - 1) / (mp.sqrt(2) + 1)) ** 2 * INTERVAL_FACTOR
    squared_tangent = mp.tan(mp.pi / 8) ** 2 * INTERVAL_FACTOR
    root = mp.sqrt

    def or_limit(z: Any, limit: Any, function: Callable[[Any], Any]) -> Any:
        return limit if abs(z) < NEAR_ZERO else function(z)

    return {
        "SINE": (  # sin x = x + x^3 SINE(x^2)
            lambda z: or_limit(z, -mp.mpf(1) / 6, lambda z: (mp.sin(root(z)) / root(z) - 1) / z),
            mp.mpf(0), squared_quarter_turn, 6,
        ),
        "COSINE": (  # cos x = 1 - x^2 / 2 + x^4 COSINE(x^2)
            lambda z: or_limit(z, mp.mpf(1) / 24, lambda z: (mp.cos(root(z)) - 1 + z / 2) / z**2),
            mp.mpf(0), squared_quarter_turn, 6,
        ),
        "EXPONENTIAL": (  # exp x = 1 + x + x^2 EXPONENTIAL(x)
            lambda z: or_limit(z, mp.mpf(1) / 2, lambda z: (mp.exp(z) - 1 - z) / z**2),
            -half_log_2, half_log_2, 11,
        ),
        "LOGARITHM": (  # log((1 + s) / (1 - s)) = 2 s + s^3 (2 / 3 + s^2 LOGARITHM(s^2))
            lambda z: or_limit(
                z, mp.mpf(2) / 5,
                lambda z: ((2 * mp.atanh(root(z)) / root(z) - 2) / z - mp.mpf(2) / 3) / z,
            ),
            mp.mpf(0), squared_ratio, 7,
        ),
        "ARCTANGENT": (  # atan x = x + x^3 ARCTANGENT(x^2)
            lambda z: or_limit(z, -mp.mpf(1) / 3, lambda z: (mp.atan(root(z)) / root(z) - 1) / z),
            mp.mpf(0), squared_tangent, 11,
        ),
    }  # fmt: skip


def test_the_coefficients_are_those_of_the_polynomials_at_chebyshev_points() -> None:
    with mp.workdps(DIGITS):
        for name, (function, low, high, degree) in series_of_functions().items():
            coefficients = [float(c) for c in series(function, low, high, degree)]
            assert coefficients == pytest.approx(getattr(functions, name), rel=1e-12)


def test_a_wrong_digit_of_a_coefficient_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    wrong = (functions.SINE[0] * (1.0 + 1e-14), *functions.SINE[1:])
    monkeypatch.setattr(functions, "SINE", wrong)

    def sine_cosine_with_fault(x: Any) -> Any:
        return functions.sine_cosine(x)

    case = Case(sine_cosine_with_fault, mp.sin, (uniform(-10.0, 10.0),), 2, 0)
    assert largest_error(case, SAMPLES) > 1.0


def reciprocals_for(features: str) -> Any:
    """1 / x, 1 / sqrt(x) and x^(-7/4) as compiled for a processor with ``features``."""
    target = SimpleNamespace(magic_tuple=lambda: ("", "", features))
    context = SimpleNamespace(codegen=lambda: target)

    def reciprocals(x: Any) -> Any:
        operations = functions.Reciprocals(context, x.builder)
        return operations.reciprocal(x), operations.root(x), operations.inverse_quarters(x, 7)

    return reciprocals


def largest_error_in_units(values: Any, exact: Any) -> Any:
    """The largest error in units of the last place."""
    return np.max(np.abs(values - exact) / np.spacing(np.abs(exact)))


@pytest.mark.parametrize("features", ["", "+avx2,+avx512f"])
def test_reciprocals_are_exact_to_about_a_unit(features: str) -> None:
    if features and not AVX512:
        pytest.skip("this processor has no estimates")
    x = np.exp(np.random.default_rng(0).uniform(-200.0, 200.0, 5_000))
    one_over, root, power = compiled(reciprocals_for(features), 1, 3)(x)
    assert largest_error_in_units(one_over, 1.0 / x) <= (1.5 if features else 0.0)
    assert (
        largest_error_in_units(root, (1.0 / np.sqrt(x.astype(np.longdouble))).astype(float)) <= 2.0
    )
    exact = (x.astype(np.longdouble) ** -1.75).astype(float)
    assert largest_error_in_units(power, exact) <= (3.0 if features else 12.0)

"""V23's truth is exact; V27 and V28 catch wrong truths, tables and derivations.

None of them accuses a true statement.
"""

from __future__ import annotations

from fractions import Fraction
from typing import Any

import mpmath
import numpy as np
import pytest
from scipy.integrate import quad

from benchmarks.checks.bounds import CONTRADICTED, HOLDS
from benchmarks.claims.vector_spaces import (
    brownout_crossing,
    brownout_particle,
    nodal_step,
)
from benchmarks.claims.vector_spaces import v28_rates_at_finite_smoothness as v28
from benchmarks.claims.vector_spaces.brownout_particle import ACROSS
from benchmarks.claims.vector_spaces.singular_approximation import closed_errors, quadrature_error
from benchmarks.measures.independent_space import gauss_points
from benchmarks.test_problems.oscillators import SingularDrive
from references.scipy.ivp import RADAU
from tests.suite.benchmarks.planted_tables import CLAIM
from tests.suite.benchmarks.quick_studies import quick


def test_a_truth_that_steps_over_the_kink_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    late = brownout_particle.crossing_time() + 0.03
    monkeypatch.setattr(brownout_particle, "crossing_time", lambda: late)
    truth = brownout_particle.truth.__wrapped__  # not the one computed before
    assert np.max(abs(truth(ACROSS, RADAU) - truth(ACROSS))) > 1e-13  # with the right time 3e-14


@pytest.mark.parametrize("theta", [0.0, 0.1, 0.5, 0.77, 1.0])
def test_the_rule_misses_a_half_parabola_by_the_stated_number(theta: float) -> None:
    t, b = gauss_points(4)
    exact = quad(lambda s: max(s - theta, 0.0) ** 2, 0.0, 1.0, points=[theta])[0]
    missed = float(b @ np.maximum(t - theta, 0.0) ** 2) - exact
    assert brownout_crossing.rule_error(theta, 4) == pytest.approx(missed, abs=1e-14)


def test_the_rational_step_is_that_of_mpmath_on_one_cubic() -> None:
    """q = q0 + v t + a t^2 + b t^3 by mpmath's quadrature of the weak form, h = 1."""
    with mpmath.workdps(30):
        tests = [lambda t: 1 - t, lambda t: (1 - t) * t, lambda t: (1 - t) * t * t]
        slopes = [lambda t: -1, lambda t: 1 - 2 * t, lambda t: 2 * t - 3 * t * t]

        def weak(k: int, i: int) -> Any:
            return mpmath.quad(
                lambda t: k * t ** max(k - 1, 0) * slopes[i](t) - t**k * tests[i](t), [0, 1]
            )

        left = mpmath.matrix([[weak(k, i) for k in (1, 2, 3)] for i in range(3)])
        right = mpmath.matrix([-weak(0, i) for i in range(3)])
        end = 1 + sum(mpmath.lu_solve(left, right))
    step = nodal_step.oscillator_step(nodal_step.chebyshev_points(4), Fraction(1))
    assert float(step[0][0]) == pytest.approx(float(end), abs=1e-15)


@pytest.mark.parametrize(("place", "b"), [(0.5, 0.45), (0.3, 0.25), (0.0, 0.25)])
def test_best_errors_are_those_of_mpmath(place: float, b: float) -> None:
    def slope(t: Any) -> Any:
        return mpmath.sign(t - place) * abs(t - place) ** (1 - b) / (1 - b)

    with mpmath.workdps(20):
        pieces = sorted({0.0, place, 1.0})
        square = mpmath.quad(lambda t: slope(t) ** 2, pieces)
        for k in range(3):
            part = mpmath.quad(lambda t, k=k: slope(t) * mpmath.legendre(k, 2 * t - 1), pieces)
            square -= (2 * k + 1) * part**2
        expected = float(mpmath.sqrt(square))
    drive = SingularDrive(place, b)
    assert closed_errors(place, b, 0.0, 1.0, [3])[0] == pytest.approx(expected, rel=1e-8)
    found = quadrature_error(drive.motion, place, 0.0, 1.0, 3)
    assert found == pytest.approx(expected, rel=1e-8)


def test_a_rate_that_is_true_is_not_accused() -> None:
    table = quick(CLAIM["V28"])
    best = table["quantity"] == v28.BEST
    s = np.where(table.loc[best, "study"].str.contains("b = -0.55"), 3.0, 2.0)
    table.loc[best, "value"] = 0.5 * (table.loc[best, "n"] - 1.0) ** -s
    found = {row.quantity: row.verdict for row in CLAIM["V28"].judge(table)}
    powers = [name for name in found if name.startswith("power of 1 / N")]
    assert len(powers) == 10 and {found[name] for name in powers} == {HOLDS}
    assert found["largest departure of the power of 1 / N from 3/2 - b, t* inside"] == CONTRADICTED

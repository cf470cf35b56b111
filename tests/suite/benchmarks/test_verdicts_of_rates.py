"""Rates beside known factors, the parity of invariants' errors, and discrete Lagrangians."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.special import eval_legendre

import galvi
from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, EXCEEDS, NOT_REPRODUCED, Base, Order
from benchmarks.claims.vector_spaces import step_actions as measured
from benchmarks.claims.vector_spaces import v07_momentum_along_curve as v07
from benchmarks.claims.vector_spaces.kepler_orbit import (
    ECCENTRICITY,
    SINGULARITY,
    STEP,
    convergence_of_polynomials,
    fixed_number,
    problem,
)
from benchmarks.statistics import convergence_fits
from references.closed_forms.kepler import KEPLER
from references.closed_forms.kepler_action import kepler_action
from references.closed_forms.oscillator import OSCILLATOR, oscillator_action
from tests.suite.benchmarks.planted_tables import CLAIM, rows
from tests.suite.benchmarks.quick_studies import quick

FLOOR = 1e-12


# --- fits


@given(base=st.floats(0.3, 0.8), power=st.sampled_from([0.5, 1.0, 1.5]), seed=st.integers(0, 999))
def test_a_base_is_found_beside_a_known_factor(base: float, power: float, seed: int) -> None:
    n = np.arange(8.0, 120.0)
    noise = np.exp(0.1 * np.random.default_rng(seed).standard_normal(n.size))
    fit = convergence_fits.geometric(
        n, n**-power * base**n * noise, floor=FLOOR, power=(power, 0.0)
    )
    assert abs(fit.rate - base) <= max(10.0 * fit.uncertainty, 1e-9)
    assert fit.power == power


def test_a_factor_that_is_left_out_lowers_the_base_beyond_its_uncertainty() -> None:
    """The wrong verdict that neglect gave: better than claimed."""
    n = np.arange(33.0, 62.0)
    errors = 50.0 * n**-1.5 * 0.745**n
    bare = convergence_fits.geometric(n, errors, floor=FLOOR)
    assert Base(0.745, 0.005).verdict(bare) == EXCEEDS
    known = convergence_fits.geometric(n, errors, floor=FLOOR, power=(1.5, 0.0))
    assert Base(0.745, 0.005).verdict(known) == ATTAINED
    assert known.evaluate(n) == pytest.approx(errors)


def test_an_exponent_known_to_within_a_range_adds_its_part() -> None:
    n = np.arange(16.0, 56.0)
    fits = [convergence_fits.geometric(n, 0.6**n, floor=1e-15, power=(g, 0.0)) for g in (0.0, 0.5)]
    wide = convergence_fits.geometric(n, 0.6**n, floor=1e-15, power=(0.25, 0.25))
    assert wide.uncertainty >= 0.9 * 0.5 * abs(fits[1].rate - fits[0].rate)
    assert abs(wide.rate - 0.6) < 2.0 * wide.uncertainty


def test_the_window_does_not_make_a_curved_line_certain() -> None:
    """A slope that still changes has an uncertainty of the size of its change."""
    h = 2.0 ** (-np.arange(4, 20) / 2)
    fit = convergence_fits.algebraic(h, h**4 / (1.0 + 3.0 * h), floor=1e-14)
    assert abs(fit.rate - 4.0) < 2.0 * fit.uncertainty


def test_scatter_does_not_meet_an_order() -> None:
    """Errors without an order have a large uncertainty: not one that any order lies in."""
    h = np.array([0.25, 0.17, 0.125, 0.083, 0.0625, 0.046, 0.031])
    erratic = [1.9e-6, 2e-7, 2.7e-7, 1.8e-9, 5.2e-9, 1e-9, 3.1e-9]
    fit = convergence_fits.algebraic(h, erratic, floor=1e-14)
    assert fit.uncertainty > 0.5
    assert Order(fit.rate + 1.0).verdict(fit) == CONTRADICTED


# --- the theory of the exponents, from the motion in closed form


def test_the_singularity_is_a_branch_point_of_exponent_one_half() -> None:
    """q(t*) - q((1 - d) t*) falls like d^(1/2): not like the 2/3 of a collision."""
    with mp.workdps(40):
        e = mp.mpf("0.6")
        peak = mp.mpc(0, mp.acosh(1 / e))  # of E, where 1 - e cos E = 0
        there = (peak - e * mp.sin(peak)).imag
        assert float(there) == pytest.approx(SINGULARITY, rel=1e-14)
        falls = []
        for d in (mp.mpf("1e-6"), mp.mpf("1e-8")):
            time = mp.mpc(0, there * (1 - d))
            E = mp.findroot(lambda E: E - e * mp.sin(E) - time, peak * (1 - mp.sqrt(d)))  # noqa: B023
            falls.append(abs(mp.cos(E) - mp.cos(peak)))
        assert float(mp.log(falls[0] / falls[1]) / mp.log(100)) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.slow(beside="test_the_singularity_is_a_branch_point_of_exponent_one_half")
@pytest.mark.parametrize("start", [0.0, -STEP / 2])
def test_legendre_coefficients_of_the_velocity_have_no_algebraic_factor(start: float) -> None:
    """Those of q' fall like r^-n, so that the curve falls like n^(-3/2) r^-n."""
    nodes, weights = np.polynomial.legendre.leggauss(120)
    first = problem(start)
    ends = [KEPLER.run(first, float(STEP * (1 + s) / 2), {"samples": 1}) for s in nodes]
    q_rate = np.array([first.system.velocity(one.p)[-1] for one in ends])
    k = np.arange(12, 41, 2)
    size = [
        np.linalg.norm((2 * n + 1) / 2 * (weights * eval_legendre(n, nodes)) @ q_rate)
        + np.linalg.norm((2 * n + 3) / 2 * (weights * eval_legendre(n + 1, nodes)) @ q_rate)
        for n in k
    ]
    rest = np.log(size) - k * math.log(convergence_of_polynomials(start, STEP))
    assert abs(np.polyfit(np.log(k), rest, 1)[0]) < 0.1


def jets(order: int) -> tuple[list[Any], list[Any]]:
    """Taylor coefficients of x and y in time about the pericentre, by r' = v, v' = -r / |r|^3."""
    e = mp.mpf("0.6")
    E = [mp.mpf(0)]  # of the eccentric anomaly: E' = 1 / (1 - e cos E)
    for k in range(order):
        series = mp.taylor(lambda t: 1 / (1 - e * mp.cos(mp.polyval(E[::-1], t))), 0, k)
        E.append(series[k] / (k + 1))
    x = mp.taylor(lambda t: mp.cos(mp.polyval(E[::-1], t)) - e, 0, order)
    y = mp.taylor(lambda t: mp.sqrt(1 - e * e) * mp.sin(mp.polyval(E[::-1], t)), 0, order)
    return x, y


def test_leading_errors_of_invariants_are_odd_in_time_for_even_n() -> None:
    """q x q^(n) and q' . q^(n) vanish at the pericentre for even n, with a slope, and only then."""
    with mp.workdps(60):
        x, y = jets(10)

        def at(c: list[Any], k: int) -> Any:
            return c[k] * mp.factorial(k)  # the k-th derivative at the pericentre

        for n in range(3, 9):
            cross = at(x, 0) * at(y, n) - at(y, 0) * at(x, n)
            dot = at(x, 1) * at(x, n) + at(y, 1) * at(y, n)
            slope = (at(x, 1) * at(y, n) + at(x, 0) * at(y, n + 1)
                     - at(y, 1) * at(x, n) - at(y, 0) * at(x, n + 1))  # fmt: skip
            even = n % 2 == 0
            assert (abs(cross) < 1e-20) == even, (n, cross)
            assert (abs(dot) < 1e-20) == even, (n, dot)
            assert not even or abs(slope) > 1.0


# --- the claims


def test_the_parity_of_the_order_is_seen_at_the_pericentre_only() -> None:
    found = {row.quantity: row.measured for row in rows(CLAIM["V7"])}
    at, off = (
        found[f"order of the {v07.ANGULAR}{of}"]
        for of in (" as h tends to 0, n = 4, 100 steps", ", n = 4, 100 steps from another point")
    )
    assert at is not None and off is not None and at - off > 0.8


@pytest.mark.parametrize(
    ("gain", "verdict"), [(0.5, ATTAINED), (1.0, NOT_REPRODUCED), (0.75, CONTRADICTED)]
)
def test_what_an_order_gains_with_n_is_measured(gain: float, verdict: str) -> None:
    """Planted: errors h^(n/2 + 2), as H reads them off, and others."""
    table = quick(CLAIM["V7"])
    own = (table["quantity"] == v07.ANGULAR) & (table["study"] == fixed_number(100))
    h, n = (table.loc[own, name].to_numpy(float) for name in ("step", "n"))
    table.loc[own, "value"] = np.maximum((10.0 * h) ** (gain * n + 2.0), 1e-15)
    found = {row.quantity: row.verdict for row in CLAIM["V7"].judge(table)}
    name = f"what the order of the {v07.ANGULAR} gains with n, 100 steps"
    assert found[name] == verdict


# --- actions in closed form


@pytest.mark.parametrize("start", [0.0, 1.0, 2.5, -0.3])
@pytest.mark.parametrize("h", [1e-3, 0.1, 0.7])
def test_lamberts_action_is_the_integral_of_the_lagrangian(start: float, h: float) -> None:
    first = problem(start)
    along, end = measured.action_along(first, h, KEPLER)
    # 5e-16 was measured
    assert kepler_action(1.0, first.q0, end, h) == pytest.approx(along, rel=1e-14)


def test_lamberts_action_gives_the_momenta_at_both_ends() -> None:
    """dS/dq1 = p1 and dS/dq0 = -p0 (Hamilton)."""
    first, h, d = problem(0.4), 0.9, 1e-5
    motion = KEPLER.run(first, h, {"samples": 1})
    for end, sign in ((0, -1.0), (1, 1.0)):
        for k in range(2):
            ends = [motion.q.copy() for _ in range(2)]
            ends[0][end, k] += d
            ends[1][end, k] -= d
            up, down = (kepler_action(1.0, *q, h) for q in ends)
            assert sign * (up - down) / (2 * d) == pytest.approx(motion.p[end, k], abs=1e-8)


def test_lamberts_action_scales_and_refuses_what_is_not_an_ellipse() -> None:
    """S(gm, l q, t) = sqrt(gm l) S(1, q, t sqrt(gm / l^3)); a fast passage has no ellipse."""
    q0, q1 = [0.4, 0.1], [0.2, 0.5]
    small = kepler_action(1.0, q0, q1, 0.4)
    large = kepler_action(2.0, [3 * x for x in q0], [3 * x for x in q1], 0.4 * math.sqrt(27 / 2))
    assert large == pytest.approx(math.sqrt(6.0) * small, rel=1e-14)
    assert math.isnan(kepler_action(1.0, q0, q1, 1e-3))


@pytest.mark.parametrize("h", [1e-3, 0.7, 2.9])
def test_the_oscillators_action_is_the_integral_of_the_lagrangian(h: float) -> None:
    system = galvi.Canonical(1.3, galvi.LinearSpring(0.9))
    first = galvi.Problem(system, [0.4], [-0.7])
    along, end = measured.action_along(first, h, OSCILLATOR)
    assert oscillator_action(1.3, 0.9, 0.4, float(end[0]), h) == pytest.approx(along, rel=1e-13)


def test_an_action_without_a_closed_form_is_refused() -> None:
    other = replace(problem(), system=galvi.Canonical(1.0, galvi.CosinePotential(1.0)))
    with pytest.raises(TypeError, match="no action in closed form"):
        measured.exact_lagrangian(other, other.q0, other.q0, 1.0)


def test_the_eccentricity_is_the_problems() -> None:
    assert problem().parameters["eccentricity"] == ECCENTRICITY

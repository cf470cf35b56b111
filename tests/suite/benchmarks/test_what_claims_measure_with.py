"""Measures and references of claims, against other formulas, mpmath and known cases."""

from __future__ import annotations

import math
from dataclasses import replace
from fractions import Fraction
from typing import Any

import mpmath as mp
import numpy as np
import pytest
from scipy.integrate import quad

import galvi
from benchmarks.claims.lie_groups.cayley_curve import (
    cayley_rate,
    distance_of_polynomials,
    rotation_angle,
)
from benchmarks.claims.lie_groups.curves_and_ends import NS, crossing
from benchmarks.claims.vector_spaces import (
    brownout_crossing,
    brownout_particle,
    noether_map,
    solution_map,
    theorem_three,
)
from benchmarks.claims.vector_spaces import step_actions as measured
from benchmarks.claims.vector_spaces import v09_solar_system_in_long_steps as v09
from benchmarks.claims.vector_spaces import v11_euler_methods_on_planets as v11
from benchmarks.claims.vector_spaces import v33_costs_and_step_lengths as v33
from benchmarks.claims.vector_spaces.brownout_particle import ACROSS
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    distances,
    follow,
    least_solvable,
    two_body,
)
from benchmarks.claims.vector_spaces.kepler_orbit import SINGULARITY, problem
from benchmarks.claims.vector_spaces.singular_approximation import closed_errors, quadrature_error
from benchmarks.measures.independent_space import gauss_points
from benchmarks.statistics import convergence_fits
from benchmarks.store.tables import row, table_of
from benchmarks.test_problems.oscillators import NONLINEAR, SingularDrive
from galvi.arrays import Array
from references.closed_forms.kepler import KEPLER
from references.closed_forms.kepler_action import kepler_action
from references.closed_forms.oscillator import OSCILLATOR, oscillator_action, oscillator_step
from references.scipy.ivp import RADAU
from references.textbook.implicit_euler import IMPLICIT_EULER

# ---- other methods, and how far they reach


def test_the_classical_runge_kutta_method_has_its_order() -> None:
    steps = np.array([64, 90, 128, 181, 256, 362, 512])
    exact = KEPLER.run(problem(), 2.0, {"samples": 1}).q[-1]
    ends = [
        v33.RK4.run(problem(), 2.0, {"step": 2.0 / k, "save_every": int(k)}).q[-1] for k in steps
    ]
    errors = [float(np.max(abs(end - exact))) for end in ends]
    fit = convergence_fits.algebraic((2.0 / steps).tolist(), errors, floor=1e-13)
    assert fit.rate == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ([1.0, 0.1, 1e-2, 1e-3], 2.0**-1.5),  # between 0.5 and 0.25, by the power law
        ([1e-3, 0.1, 1e-2, 1e-3], 2.0**-1.5),  # a coarse step that is accurate by chance
        ([1e-2, 1e-3, 1e-4, 1e-5], 1.0),
        ([np.nan, 1e-2, 1e-3, 1e-4], 0.5),
        ([1.0, 1.0, 1.0, 1.0], np.nan),
        ([1e-3, 1e-3, 1e-3, np.nan], np.nan),
    ],
)
def test_the_longest_accurate_step_is_found(errors: list[float], expected: float) -> None:
    table = table_of(
        row(quantity=v33.ERROR, label="any", step=h, value=error)
        for h, error in zip((1.0, 0.5, 0.25, 0.125), errors, strict=True)
    )
    assert v33.longest(table, "any", 10.0**-1.5) == pytest.approx(expected, nan_ok=True)


def test_a_step_of_implicit_euler_has_a_solution_from_its_closed_limit_on() -> None:
    h, mu = np.array(0.005), np.array(39.478)
    smallest, a = least_solvable(mu, h), float(h**2 * mu)
    assert smallest == pytest.approx(0.1882, abs=5e-5)
    r = np.linspace(1e-3, 1.0, 1_000_001)
    assert np.min(r + a / r**2) == pytest.approx(float(smallest), rel=1e-9)
    for size in (1.001 * smallest, 2.0 * smallest):
        for root in distances(np.array([size]), np.array([a])):
            assert root[0] + a / root[0] ** 2 == pytest.approx(float(size), rel=1e-12)
    assert np.all(np.isnan(distances(np.array([0.999 * smallest]), np.array([a]))))


@pytest.mark.parametrize("h", [0.05, 0.2])
def test_newtons_method_stops_where_the_closed_form_has_no_solution(h: float) -> None:
    orbit = galvi.problems.kepler(0.3)
    steps = round(20.0 / h)
    run = IMPLICIT_EULER.run(orbit, steps * h, {"step": h})
    start = orbit.q0[None], orbit.v0[None]
    (unsolved,), _, (last,) = follow(*start, np.ones(1), np.array([h]), steps * h)
    assert run.failed_step is not None and unsolved == run.failed_step - 1
    q, v = run.q[unsolved], run.p[unsolved]
    assert last == pytest.approx(0.5 * v @ v - 1.0 / np.linalg.norm(q), rel=1e-9)


def test_only_a_smaller_solution_throws_a_planet_out_and_a_late_one_those_of_the_caption() -> None:
    """So do the fifth to the twelfth step before the one without a solution, in 1 to 2.9 years."""
    h, stops = np.array([0.005]), np.array([18, 73, 179, 606])
    unsolved, largest, _ = two_body(v11.problem(), h)
    assert np.all(largest < 0.0)
    assert np.array_equal(unsolved + 1, stops)
    unsolved, _, last = two_body(v11.problem(), h, smaller_at=np.ones(4))
    assert np.all(unsolved < 0) and np.all(last > 0.0)
    for late, years in ((5, 1.0), (8, 2.5), (12, 2.9)):
        unsolved, _, last = two_body(v11.problem(), h, years, stops - late)
        assert ((unsolved < 0) & (last > 0.0)).tolist() == [True, True, True, False]


# ---- what limits convergence


def test_mercurys_base_is_that_of_the_singularity_of_its_orbit() -> None:
    e, year = 0.2056, 87.97
    t = year / (2.0 * math.pi) * (math.acosh(1.0 / e) - math.sqrt(1.0 - e**2))
    rho = 2.0 * t / 100.0 + math.hypot(1.0, 2.0 * t / 100.0)
    assert v09.bounds()["mercury_base"] == pytest.approx(rho**-2, abs=1e-3)


def test_the_singularity_is_a_branch_point_of_exponent_one_half() -> None:
    """q(t*) - q((1 - d) t*) falls like d^(1/2): not like the 2/3 of a collision."""
    with mp.workdps(40):
        e = mp.mpf("0.6")
        peak = mp.mpc(0, mp.acosh(1 / e))  # of E, where 1 - e cos E = 0
        singular_time = (peak - e * mp.sin(peak)).imag
        assert float(singular_time) == pytest.approx(SINGULARITY, rel=1e-14)
        falls = []
        for d in (mp.mpf("1e-6"), mp.mpf("1e-8")):
            time = mp.mpc(0, singular_time * (1 - d))
            E = mp.findroot(lambda E: E - e * mp.sin(E) - time, peak * (1 - mp.sqrt(d)))  # noqa: B023
            falls.append(abs(mp.cos(E) - mp.cos(peak)))
        assert float(mp.log(falls[0] / falls[1]) / mp.log(100)) == pytest.approx(0.5, abs=1e-3)


@pytest.mark.parametrize("case", NONLINEAR, ids=lambda case: case.name)
def test_a_lipschitz_constant_is_the_largest_curvature_of_its_interval(case: Any) -> None:
    places, start = case.sample_positions(1), case.problem()
    assert np.max(abs(case.curvature(places))) == pytest.approx(case.lipschitz, rel=1e-15)
    slopes = (case.slope(places + 1e-6) - case.slope(places - 1e-6)) / 2e-6
    assert np.allclose(slopes, case.curvature(places), atol=1e-8)
    gradient = start.system.gradient or start.system.potential.gradient
    assert np.allclose(gradient(start.q0), case.slope(start.q0), rtol=1e-15)


def test_best_errors_are_those_of_mpmath() -> None:
    singularity, b = 0.3, 0.25

    def slope(t: Any) -> Any:
        return mp.sign(t - singularity) * abs(t - singularity) ** (1 - b) / (1 - b)

    with mp.workdps(20):
        pieces = [0.0, singularity, 1.0]
        square = mp.quad(lambda t: slope(t) ** 2, pieces)
        for k in range(3):
            component = mp.quad(lambda t, k=k: slope(t) * mp.legendre(k, 2 * t - 1), pieces)
            square -= (2 * k + 1) * component**2
        expected = float(mp.sqrt(square))
    assert closed_errors(singularity, b, 0.0, 1.0, [3])[0] == pytest.approx(expected, rel=1e-8)
    error = quadrature_error(SingularDrive(singularity, b).motion, singularity, 0.0, 1.0, 3)
    assert error == pytest.approx(expected, rel=1e-8)


def test_the_right_side_of_theorem_3_grows_with_the_error_of_the_rule() -> None:
    """Lobatto N errs in |u'|^2, and not in the force more than N + 1 points: only I_2 tells."""
    case, rules = theorem_three.COMPARISONS[0], (galvi.lobatto(3), galvi.lobatto(4))
    best = [theorem_three.consistency(case, solution_map.nodes(rule), 3, 0.2)[0] for rule in rules]
    assert best[0] > 10.0 * best[1]


# ---- the brownout particle across its kink


def test_a_truth_that_steps_over_the_kink_is_seen(monkeypatch: pytest.MonkeyPatch) -> None:
    late = brownout_particle.crossing_time() + 0.03
    monkeypatch.setattr(brownout_particle, "crossing_time", lambda: late)
    truth = brownout_particle.truth.__wrapped__  # not the one computed before
    assert np.max(abs(truth(ACROSS, RADAU) - truth(ACROSS))) > 1e-13  # with the right time 3e-14


@pytest.mark.parametrize("theta", [0.0, 0.1, 0.77])
def test_the_rule_misses_a_half_parabola_by_the_stated_number(theta: float) -> None:
    t, b = gauss_points(4)
    exact = quad(lambda s: max(s - theta, 0.0) ** 2, 0.0, 1.0, points=[theta])[0]
    missed = float(b @ np.maximum(t - theta, 0.0) ** 2) - exact
    assert brownout_crossing.rule_error(theta, 4) == pytest.approx(missed, abs=1e-14)


# ---- actions and curves


@pytest.mark.parametrize("start", [0.0, 2.5])
@pytest.mark.parametrize("h", [1e-3, 0.7])
def test_lamberts_action_is_the_integral_of_the_lagrangian(start: float, h: float) -> None:
    first = problem(start)
    along, end = measured.action_along(first, h, KEPLER)
    # 5e-16 was measured
    assert kepler_action(1.0, first.q0, end, h) == pytest.approx(along, rel=1e-14)


def test_lamberts_action_scales_and_refuses_what_is_not_an_ellipse() -> None:
    """S(gm, l q, t) = sqrt(gm l) S(1, q, t sqrt(gm / l^3)); a fast passage has no ellipse."""
    q0, q1 = [0.4, 0.1], [0.2, 0.5]
    small = kepler_action(1.0, q0, q1, 0.4)
    large = kepler_action(2.0, [3 * x for x in q0], [3 * x for x in q1], 0.4 * math.sqrt(27 / 2))
    assert large == pytest.approx(math.sqrt(6.0) * small, rel=1e-14)
    assert math.isnan(kepler_action(1.0, q0, q1, 1e-3))
    pendulum = replace(problem(), system=galvi.Canonical(1.0, galvi.CosinePotential(1.0)))
    with pytest.raises(TypeError, match="no action in closed form"):
        measured.exact_lagrangian(pendulum, pendulum.q0, pendulum.q0, 1.0)


@pytest.mark.parametrize("h", [1e-3, 0.7, 2.9])
def test_the_oscillators_action_is_the_integral_of_the_lagrangian(h: float) -> None:
    first = galvi.Problem(galvi.Canonical(1.3, galvi.LinearSpring(0.9)), [0.4], [-0.7])
    along, end = measured.action_along(first, h, OSCILLATOR)
    assert oscillator_action(1.3, 0.9, 0.4, float(end[0]), h) == pytest.approx(along, rel=1e-13)


def test_the_oscillators_form_of_degree_one_is_known_and_without_one_there_is_no_bound() -> None:
    h = Fraction(1, 2)  # L_d = (q1 - q0)^2 / 2h - h (q0^2 + q0 q1 + q1^2) / 6
    form = oscillator_step(1, h)
    assert (form.a, form.b) == (1 / h - h / 3, -1 / h - h / 6)
    limit = Fraction(12) ** Fraction(1, 2)
    assert oscillator_step(1, Fraction(limit * 0.999)).stable
    unstable = oscillator_step(1, Fraction(limit * 1.001))
    assert not unstable.stable and unstable.largest_energy_error == math.inf


def test_the_curve_of_the_noether_map_is_that_of_the_run() -> None:
    """q'' from its values is the slope of its velocity."""
    run = galvi.integrate(problem(), galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(10)), 0.5, 1)
    step = noether_map.step_of(problem(), run, 10)
    assert step is not None
    t, half_step = np.linspace(0.1, 0.4, 7), 1e-5
    slope = (run.velocity(t + half_step) - run.velocity(t - half_step)) / (2.0 * half_step)
    assert step._bend(t) == pytest.approx(slope, abs=1e-8)
    assert step.a @ run.q[0] == 0.0


# ---- curves in Cayley's chart


def turn_about(axis: Array, angles: Array) -> Array:
    """Rotations (k, 3, 3) by Rodrigues' formula."""
    x, y, z = axis / np.linalg.norm(axis)
    hat = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    sines, versines = np.sin(angles)[:, None, None], (1.0 - np.cos(angles))[:, None, None]
    return np.eye(3) + sines * hat + versines * (hat @ hat)


@pytest.mark.parametrize("angle", [0.3, 3.1, 3.2, 5.0])
def test_a_turn_is_followed_beyond_pi(angle: float) -> None:
    path = turn_about(np.array([1.0, -2.0, 0.5]), np.linspace(0.0, angle, 161))
    assert rotation_angle(path) == pytest.approx(angle, abs=1e-12)  # 1e-15 was measured


def test_polynomials_are_as_far_from_a_steady_turn_as_its_pole_says() -> None:
    """n r^-n, with r of Bernstein's ellipse through the pole, which in xi' is a double one."""
    axis, angle, step = np.array([0.6, 0.0, 0.8]), 2.8, 0.6
    t = np.linspace(0.0, angle, 401)
    path, omega = turn_about(axis, t), np.tile(axis * angle / step, (401, 1))
    xi, rate = cayley_rate(path, omega)
    assert np.allclose(xi, 2.0 * np.tan(0.5 * t)[:, None] * axis, rtol=1e-12)
    assert np.allclose(rate, (angle / step / np.cos(0.5 * t) ** 2)[:, None] * axis, rtol=1e-12)
    away = 2.0 * np.pi / angle - 1.0
    r = away + np.sqrt(away**2 - 1.0)
    errors = [distance_of_polynomials(path, omega, degree) for degree in (11, 13)]
    assert errors[0] / errors[1] == pytest.approx(11 / 13 * r**2, rel=0.05)  # 0.5 % was measured


def test_n_star_is_where_the_curve_s_own_error_is_that_of_the_ends() -> None:
    """2^(n - 6.25) is 1 at n = 6.25; there is no n* where it is below or above 1 for all n."""
    excess = 2.0 ** (np.array(NS) - 6.25)
    assert crossing(excess) == pytest.approx(6.25, abs=1e-12)
    assert crossing(4.0 * excess) == pytest.approx(4.25, abs=1e-12)
    mixed = np.where(excess < 1.0, -1.0, excess)
    for without_crossing in (1e3 * excess, 1e-3 * excess, mixed, math.nan * excess):
        assert math.isnan(crossing(without_crossing))

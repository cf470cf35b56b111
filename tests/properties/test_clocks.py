"""Steps in a clock: constant in tau, dt = g(q) dtau, and as variational as those in time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import galvi
from galvi.run.clocked import transformed
from references.stored.encounters import burrau, sitnikov
from references.stored.planets import STORED_TRUTH
from tests.properties.clock_problems import (
    CASES,
    CIRCLES,
    DAMPED,
    DRIVEN,
    GAUSS,
    KEPLER,
    LOBATTO,
    MORE,
    damped,
    driven,
    method,
    three_bodies,
    upright,
)

each = pytest.mark.parametrize("case", list(CASES))


def ends(case: str, s: int, kind: str, step: float) -> Any:
    problem, clock, duration, _ = CASES[case]
    run = galvi.integrate(problem, method(s, clock, kind), step, duration=duration)
    assert run.success, run.status
    assert run.t[-1] == problem.t0 + duration
    return run.q[-1]


@pytest.mark.slow_cases(
    "Kepler, eccentric anomaly-gauss",
    "elastic pendulum-gauss",
    "elastic pendulum-lobatto",
    "elastic pendulum-more points",
    "3D pendulum-gauss",
    "three bodies-lobatto",
)
@pytest.mark.parametrize("kind", [GAUSS, LOBATTO, MORE])
@each
def test_a_run_ends_at_its_time_with_the_order_of_the_method(case: str, kind: str) -> None:
    truth = ends(case, 8, GAUSS, 0.05)
    step = CASES[case][3]
    steps = step / np.array([2.0, 3.0, 4.0])
    errors = [float(np.max(np.abs(ends(case, 2, kind, h) - truth))) for h in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 3.6 < order < 4.7, (errors, order)


@pytest.mark.slow_cases(but=["three bodies-gauss"])
@pytest.mark.parametrize("kind", [GAUSS, LOBATTO, MORE])
@each
def test_a_step_is_symplectic_in_the_extended_phase_space(case: str, kind: str) -> None:
    problem, clock, _, step = CASES[case]
    assert galvi.symplecticity_defect(problem, method(2, clock, kind), step) < 1e-10


@pytest.mark.slow(beside="test_a_step_is_symplectic_in_the_extended_phase_space")
def test_a_clock_without_the_slope_of_g_is_not_symplectic(monkeypatch: pytest.MonkeyPatch) -> None:
    def fixed(in_tau: transformed.LagrangianInTau, driven: bool, t0: float) -> galvi.Problem:
        base, rate, known = in_tau.base, in_tau.rate, in_tau.base.builtin.slopes

        def slopes(q: Any, u: Any) -> Any:
            g, both = rate(q), None
            both = np.array(known(q, u / g))
            both[q.size :] *= g
            return both

        found = galvi.Lagrangian(in_tau.value, base.group, slopes, check=False)
        return galvi.Problem(found, *in_tau.start, t0)

    problem, clock, _, step = CASES["elastic pendulum"]
    assert galvi.symplecticity_defect(problem, method(2, clock), step) < 1e-10
    monkeypatch.setattr(transformed, "in_clock", fixed)
    assert galvi.symplecticity_defect(problem, method(2, clock), step) > 1e-6


def test_momenta_are_kept_to_round_off_where_g_is_invariant() -> None:
    run = galvi.integrate(three_bodies(), method(4, galvi.DynamicalTime()), 0.4, duration=40.0)
    p = run.p.sum(axis=1)
    turning = np.cross(run.q, run.p).sum(axis=1)
    assert np.max(np.abs(p - p[0])) < 1e-14
    assert np.max(np.abs(turning - turning[0])) < 1e-14
    assert np.max(np.abs(galvi.energy(run) - galvi.energy(run)[0])) > 1e-12  # coarse, and not kept


@pytest.mark.slow_cases("Kepler, Sundman", "elastic pendulum")
@each
def test_steps_back_cancel_steps_forward(case: str) -> None:
    problem, clock, duration, step = CASES[case]
    symmetric = case != "3D pendulum"  # charts on groups are based at the step's start
    error = galvi.round_trip_error(problem, method(3, clock), step, 10)
    assert error < (1e-13 if symmetric else 1e-3)
    there = galvi.integrate(problem, method(8, clock), step, duration=duration)
    start = galvi.Problem(problem.system, there.q[-1], there.v[-1], duration)
    back = galvi.integrate(start, method(8, clock), -step, duration=duration)
    assert back.success and back.t[-1] == 0.0 and np.all(np.diff(back.t) < 0.0)
    assert np.max(np.abs(back.q[-1] - problem.q0)) < 1e-8


@pytest.mark.slow(beside="test_clock_kernel.py::test_curves_and_rates_are_those_of_the_steps")
def test_the_curve_has_its_order_and_states_between_steps_that_of_the_steps() -> None:
    problem, clock, duration, _ = CASES["Kepler, Sundman"]
    times = np.linspace(0.01, 5.99, 401)
    truth = galvi.integrate(problem, method(12, clock), 0.05, duration=duration)(times)
    steps = np.array([0.3, 0.2, 0.15])
    curve, state = [], []
    for h in steps:
        run = galvi.integrate(problem, method(3, clock), h, duration=duration)
        curve.append(np.max(np.abs(run(times) - truth)))
        state.append(np.max(np.abs(galvi.states_at(run, times[::20])[0] - truth[::20])))
        assert np.max(np.abs(run(run.t) - run.q)) < 2e-15
    orders = [np.polyfit(np.log(steps), np.log(e), 1)[0] for e in (curve, state)]
    assert 3.4 < orders[0] < 4.8 and 5.5 < orders[1] < 6.9, orders


@pytest.mark.slow(beside="test_events.py::test_states_at_many_times_are_those_at_each")
def test_states_at_are_those_of_a_run_in_time_too() -> None:
    problem = galvi.problems.kepler(0.3)
    run = galvi.integrate(problem, method(6, None), 0.2, 20, save_every=3)
    q, p = galvi.states_at(run, 2.35)
    fine = galvi.integrate(problem, method(8, None), 2.35 / 40, 40)
    assert np.max(np.abs(q - fine.q[-1])) < 1e-10 and np.max(np.abs(p - fine.p[-1])) < 1e-10
    with pytest.raises(ValueError, match="inside the run"):
        galvi.states_at(run, 4.1)


@pytest.mark.slow(beside="test_clock_runs.py::test_a_duration_that_ends_next_to_the_grid_is_met")
@given(st.floats(0.05, 0.9), st.floats(0.1, 0.4), st.floats(0.5, 9.0))
@settings(max_examples=15, deadline=None)
def test_a_duration_of_any_length_is_met(e: float, step: float, duration: float) -> None:
    problem = galvi.problems.kepler(e)
    run = galvi.integrate(problem, method(8, galvi.Sundman()), step, duration=duration)
    assert run.success and run.t[-1] == duration
    anomaly = duration
    for _ in range(60):
        anomaly -= (anomaly - e * math.sin(anomaly) - duration) / (1.0 - e * math.cos(anomaly))
    place = [math.cos(anomaly) - e, math.sqrt(1.0 - e * e) * math.sin(anomaly)]
    assert np.max(np.abs(run.q[-1] - place)) < 1e-9
    assert np.all(np.diff(run.t) > 0.0) and np.all(np.diff(run.tau) > 0.0)


def test_burrau_ends_where_quadruple_precision_does() -> None:
    run = galvi.integrate(burrau(), method(8, galvi.DynamicalTime()), 0.3, duration=63.0)
    truth = [2.8394339724915002, 8.1128544246959514]  # heyoka, quadruple precision
    assert run.success and np.max(np.abs(run.q[-1, 0] - truth)) < 2e-4, run.q[-1, 0] - truth
    assert run.engine == "clock"


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
def test_sitnikovs_body_stays_on_its_axis_and_where_quadruple_precision_has_it() -> None:
    problem, duration = sitnikov(), 200.0
    run = galvi.integrate(problem, method(8, galvi.DynamicalTime()), 0.3, duration=duration)
    truth = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    assert not np.any(run.q[:, 2, :2])
    assert np.max(np.abs(run.q[-1] - truth)) < 1e-10


def test_a_function_that_cannot_be_traced_runs_as_well() -> None:
    def branches(q: Any) -> float:
        return 1.0 if q[0] > 1e9 else float(1.0 / (1.5 + math.cos(q[0]) * 0.5))

    problem, _, duration, step = CASES["elastic pendulum"]
    slow = galvi.integrate(problem, method(4, galvi.Clock(branches)), step, duration=duration)
    quick = galvi.integrate(problem, method(4, galvi.Clock(upright)), step, duration=duration)
    assert slow.success and np.max(np.abs(slow.q[-1] - quick.q[-1])) < 1e-8


@pytest.mark.slow_cases(but=["system0-damped-gauss"])
@pytest.mark.parametrize(
    ("system", "equation", "kind"),
    [(DAMPED, damped, GAUSS), (DAMPED, damped, LOBATTO), (DRIVEN, driven, GAUSS)],
)
def test_driven_and_damped_systems_have_the_order_of_the_method(
    system: Any, equation: Any, kind: str
) -> None:
    problem = galvi.Problem(system, [1.0, 0.0], [0.0, 0.8], 0.5)
    start = np.concatenate([problem.q0, problem.v0])
    truth = solve_ivp(equation, (0.5, 2.0), start, method="DOP853", rtol=1e-13, atol=1e-14).y[
        :2, -1
    ]
    steps, errors = np.array([0.4, 0.3, 0.2]), []
    for h in steps:
        run = galvi.integrate(problem, method(2, galvi.Sundman(), kind), h, duration=1.5)
        assert run.success and run.t[-1] == 2.0, run.status
        errors.append(np.max(np.abs(run.q[-1] - truth)))
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 3.5 < order < 4.6, (errors, order)
    part = galvi.integrate(problem, method(2, galvi.Sundman(), kind), 0.2, duration=0.7)
    assert np.array_equal(galvi.resume(part, until=2.0).q[-1], run.q[-1])


def test_states_of_a_damped_run_have_the_energy_that_is_left() -> None:
    problem = galvi.Problem(DAMPED, [1.0, 0.0], [0.0, 0.8])
    times = np.array([0.333, 1.7, 2.8])
    run = galvi.integrate(problem, method(6, CIRCLES), 0.2, duration=3.0, save_every=4)
    q, _ = galvi.states_at(run, times)
    tight = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "t_eval": times}
    truth = solve_ivp(damped, (0.0, 3.0), [1.0, 0.0, 0.0, 0.8], **tight).y[:2].T
    assert np.max(np.abs(q - truth)) < 1e-10


def test_states_between_steps_have_momenta_at_their_times() -> None:
    """Of L = e^(0.3 t) (v^2 - q^2) / 2, whose momentum depends on the time; taken at that of
    another stage they were wrong by 5e-3."""

    def growing(q: Any, v: Any, t: Any) -> Any:
        return 0.5 * np.exp(0.3 * t) * (v @ v - q @ q)

    system = galvi.Lagrangian(growing, galvi.Rn(1), explicit_time=True)
    clock = galvi.Clock(lambda q: 1.0 / (1.0 + 0.3 * q[0] * q[0]))
    run = galvi.integrate(galvi.Problem(system, [1.0], [0.2]), method(4, clock), 0.1, 12)
    times = np.array([0.3 * run.t[6] + 0.7 * run.t[7], 0.5 * run.t[-1]])
    q, p = galvi.states_at(run, times)
    w = math.sqrt(1.0 - 0.15**2)
    fall, lag = np.exp(-0.15 * times), 0.35 / w
    assert np.max(np.abs(q[:, 0] - fall * (np.cos(w * times) + lag * np.sin(w * times)))) < 1e-12
    v = fall * ((lag * w - 0.15) * np.cos(w * times) - (w + 0.15 * lag) * np.sin(w * times))
    assert np.max(np.abs(p[:, 0] - np.exp(0.3 * times) * v)) < 1e-12


def test_states_at_grid_points_that_were_not_saved_are_those_of_the_grid() -> None:
    whole = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 40)
    coarse = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 40, save_every=10)
    q, p = galvi.states_at(coarse, whole.t)
    assert np.max(np.abs(q - whole.q)) < 1e-13 and np.max(np.abs(p - whole.p)) < 1e-13


def test_a_sundman_clock_knows_its_gm_in_any_units() -> None:
    """A low orbit in km and s: steps of 0.4 as with G M = 1."""
    gm = 398600.4418
    orbit = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(gm)), [7000.0, 0.0], [0.0, 9.0])
    ends = [
        galvi.integrate(orbit, method(8, clock, GAUSS), step, duration=86400.0)
        for clock, step in ((galvi.Sundman(gm=gm), 0.4), (galvi.Sundman(), 0.4 / math.sqrt(gm)))
    ]
    assert all(run.success and len(run.t) < 120 for run in ends)
    np.testing.assert_allclose(ends[0].q, ends[1].q, rtol=0.0, atol=1e-8)
    assert repr(ends[0].method.clock) == "Sundman(power=1.5, gm=398600.4418)"
    with pytest.raises(ValueError, match="gm must be positive"):
        galvi.Sundman(gm=0.0)

"""Steps in a clock: constant in tau, dt = g(q) dtau, and as variational as those in time."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import solve_ivp

import galvi
from galvi.curves.clock_curves import ClockCurves
from galvi.run.clocked import general
from galvi.run.clocked.loop import Loop
from galvi.run.clocked.run import motion_of
from galvi.run.nystrom_steppers import ROUND_OFF
from references.stored.encounters import sitnikov
from references.stored.planets import STORED_TRUTH

GAUSS, LOBATTO, MORE = "gauss", "lobatto", "more points"


def method(s: int, clock: Any, kind: str = GAUSS) -> galvi.Galerkin:
    rules = {GAUSS: galvi.gauss(s), LOBATTO: galvi.lobatto(s + 1), MORE: galvi.gauss(s + 1)}
    return galvi.Galerkin(galvi.Polynomials(s), rules[kind], clock=clock)


def upright(q: Any) -> Any:
    return 1.0 / (1.5 + np.cos(q[0]) * 0.5)


def facing(R: Any) -> Any:
    return 1.0 / (1.5 + 0.5 * R[2, 2])


def burrau() -> galvi.Problem:
    places = [[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]]
    return galvi.Problem(galvi.NBody([3.0, 4.0, 5.0]), places, np.zeros((3, 2)))


def three_bodies() -> galvi.Problem:
    """A star, a planet and a moon-like companion, in three dimensions."""
    q = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [-2.0, 0.3, 0.0]]
    v = [[0.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.1, -0.6, 0.05]]
    return galvi.Problem(galvi.NBody([1.0, 0.02, 0.05]), q, v)


CASES = {
    "Kepler, Sundman": (galvi.problems.kepler(0.5), galvi.Sundman(), 6.0, 0.4),
    "Kepler, eccentric anomaly": (galvi.problems.kepler(0.5), galvi.Sundman(1.0), 6.0, 0.4),
    "double pendulum": (galvi.problems.elastic_pendulum(), galvi.Clock(upright), 2.0, 0.2),
    "3D pendulum": (galvi.problems.pendulum_3d(), galvi.Clock(facing), 2.0, 0.2),
    "three bodies": (three_bodies(), galvi.DynamicalTime(), 3.0, 0.4),
}
each = pytest.mark.parametrize("case", list(CASES))


def ends(case: str, s: int, kind: str, step: float) -> Any:
    problem, clock, duration, _ = CASES[case]
    run = galvi.integrate(problem, method(s, clock, kind), step, duration=duration)
    assert run.success, run.status
    assert run.t[-1] == problem.t0 + duration
    return run.q[-1]


@pytest.mark.parametrize("kind", [GAUSS, LOBATTO, MORE])
@each
def test_a_run_ends_at_its_time_with_the_order_of_the_method(case: str, kind: str) -> None:
    truth = ends(case, 8, GAUSS, 0.05)
    step = CASES[case][3]
    steps = step / np.array([2.0, 3.0, 4.0])
    errors = [float(np.max(np.abs(ends(case, 2, kind, h) - truth))) for h in steps]
    order = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert 3.6 < order < 4.7, (errors, order)


@each
def test_a_run_in_a_clock_is_the_motion_that_steps_in_time_find(case: str) -> None:
    problem, _clock, duration, _ = CASES[case]
    plain = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem, plain, duration / 400, 400)
    assert np.max(np.abs(ends(case, 8, GAUSS, 0.1) - run.q[-1])) < 1e-11


@pytest.mark.parametrize("kind", [GAUSS, LOBATTO, MORE])
@each
def test_a_step_is_symplectic_in_the_extended_phase_space(case: str, kind: str) -> None:
    problem, clock, _, step = CASES[case]
    assert galvi.symplecticity_defect(problem, method(2, clock, kind), step) < 1e-10


def test_a_clock_without_the_slope_of_g_is_not_symplectic(monkeypatch: pytest.MonkeyPatch) -> None:
    def fixed(problem: galvi.Problem, clock: Any, energy: float) -> galvi.Problem:
        base, rate = general.lagrangian_of(problem.system, problem), clock.rate(problem)
        known = base.builtin.slopes

        def slopes(q: Any, u: Any) -> Any:
            g, both = rate(q), None
            both = np.array(known(q, u / g))
            both[q.size :] *= g
            return both

        def L(q: Any, u: Any) -> Any:
            g = rate(q)
            return g * (base.function(q, u / g) + energy)

        found = galvi.Lagrangian(L, base.group, slopes, check=False)
        return galvi.Problem(found, problem.q0, rate(problem.q0) * problem.v0)

    problem, clock, _, step = CASES["double pendulum"]
    assert galvi.symplecticity_defect(problem, method(2, clock), step) < 1e-10
    monkeypatch.setattr(general, "in_clock", fixed)
    assert galvi.symplecticity_defect(problem, method(2, clock), step) > 1e-6


def test_momenta_are_kept_to_round_off_where_g_is_invariant() -> None:
    run = galvi.integrate(three_bodies(), method(4, galvi.DynamicalTime()), 0.4, duration=40.0)
    p = run.p.sum(axis=1)
    turning = np.cross(run.q, run.p).sum(axis=1)
    assert np.max(np.abs(p - p[0])) < 1e-14
    assert np.max(np.abs(turning - turning[0])) < 1e-14
    assert np.max(np.abs(galvi.energy(run) - galvi.energy(run)[0])) > 1e-12  # coarse, and not kept


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


def test_states_at_are_those_of_a_run_in_time_too() -> None:
    problem = galvi.problems.kepler(0.3)
    run = galvi.integrate(problem, method(6, None), 0.2, 20, save_every=3)
    q, p = galvi.states_at(run, 2.35)
    fine = galvi.integrate(problem, method(8, None), 2.35 / 40, 40)
    assert np.max(np.abs(q - fine.q[-1])) < 1e-10 and np.max(np.abs(p - fine.p[-1])) < 1e-10
    with pytest.raises(ValueError, match="inside the run"):
        galvi.states_at(run, 4.1)


@each
def test_a_continued_run_has_the_bits_of_one_long_run(case: str) -> None:
    problem, clock, duration, step = CASES[case]
    whole = galvi.integrate(problem, method(4, clock), step, duration=duration)
    part = galvi.integrate(problem, method(4, clock), step, duration=0.4 * duration)
    rest = galvi.resume(part, until=duration)
    assert rest.t[0] == part.t[-1] and rest.t[-1] == duration
    n = len(rest.q) - 1
    assert np.array_equal(rest.q[1:], whole.q[-n:]) and np.array_equal(rest.p[1:], whole.p[-n:])
    assert np.array_equal(rest.tau[1:], whole.tau[-n:])
    again = galvi.resume(galvi.resume(part, 2), 2)
    assert np.array_equal(again.q[-1], galvi.resume(part, 4).q[-1])


@pytest.mark.parametrize("save_every", [1, 5])
def test_a_saved_run_is_the_same_run(tmp_path: Path, save_every: int) -> None:
    problem, clock, duration, step = CASES["Kepler, Sundman"]
    run = galvi.integrate(problem, method(6, clock), step, duration=duration, save_every=save_every)
    times = np.linspace(0.0, duration, 17)
    galvi.save(run, tmp_path / "run.npz")
    for same in (galvi.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))):
        assert same.status == run.status and same.engine == run.engine
        assert np.array_equal(same.tau, run.tau) and np.array_equal(same(times), run(times))
        more = galvi.resume(same, duration=1.0)
        assert np.array_equal(more.q, galvi.resume(run, duration=1.0).q)
    every = galvi.integrate(problem, method(6, clock), step, duration=duration)
    assert np.array_equal(every.q[:-1][::save_every], run.q[:-1])
    assert np.max(np.abs(every(times) - run(times))) < 1e-14


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


@pytest.mark.skipif(not galvi.FAST, reason="massless bodies need galvi.fast")
def test_sitnikovs_body_stays_on_its_axis_and_where_quadruple_precision_has_it() -> None:
    problem, duration = sitnikov(), 200.0
    run = galvi.integrate(problem, method(8, galvi.DynamicalTime()), 0.3, duration=duration)
    truth = STORED_TRUTH.run(problem, duration, {"samples": 1}).q[-1]
    assert not np.any(run.q[:, 2, :2])
    assert np.max(np.abs(run.q[-1] - truth)) < 1e-10


def test_a_collision_ends_the_run_and_names_the_bodies() -> None:
    head_on = galvi.Problem(
        galvi.NBody([1.0, 1.0]), [[1.0, 0.0], [-1.0, 0.0]], np.zeros((2, 2)),
        parameters={"bodies": ["Castor", "Pollux"]},
    )  # fmt: skip
    run = galvi.integrate(head_on, method(8, galvi.DynamicalTime()), 0.3, duration=63.0)
    assert not run.success and "Castor and Pollux collide" in run.status
    assert abs(run.t[-1] - math.pi / math.sqrt(2.0)) < 1e-12 and np.isfinite(run.q).all()


def test_a_pair_that_sets_the_steps_of_all_is_named() -> None:
    q = [[0.0, 0.0], [30.0, 0.0], [30.01, 0.0]]
    v = [[0.0, 0.0], [0.0, 0.18], [0.0, 0.18 + math.sqrt(2e-3 / 0.01)]]
    problem = galvi.Problem(galvi.NBody([1.0, 1e-3, 1e-3]), q, v)
    run = galvi.integrate(problem, method(6, galvi.DynamicalTime()), 0.4, 100)
    assert "Bodies 1 and 2 set the steps of all" in run.status


def test_a_duration_within_a_step_is_one_shortened_step() -> None:
    run = galvi.integrate(burrau(), method(8, galvi.DynamicalTime()), 0.3, duration=1e-3)
    assert run.success and run.counts["steps"] == 0 and run.t[-1] == 1e-3
    long = galvi.integrate(galvi.problems.kepler(0.5), method(8, galvi.Sundman()), 1e5, 3)
    assert not long.success and "units of the clock" in long.status


def test_steps_bound_a_duration_and_say_so() -> None:
    run = galvi.integrate(burrau(), method(6, galvi.DynamicalTime()), 0.3, 20, duration=63.0)
    assert not run.success and "the bound of 20 steps" in run.status and len(run.t) == 21
    assert galvi.resume(run, until=63.0).t[-1] == 63.0


def test_a_step_whose_time_does_not_grow_is_said() -> None:
    run = galvi.integrate(galvi.problems.kepler(0.9), method(2, galvi.Sundman()), 1.0, 8)
    assert isinstance(run.curves, ClockCurves)
    first = int(run.curves.steps_backwards()[0]) + 1  # its polynomial dips between two stages
    assert f"The time does not grow along step {first}" in run.status
    fine = galvi.integrate(galvi.problems.kepler(0.9), method(8, galvi.Sundman()), 0.3, 40)
    assert isinstance(fine.curves, ClockCurves) and not fine.curves.steps_backwards().size


def test_a_function_that_cannot_be_traced_runs_as_well() -> None:
    def branches(q: Any) -> float:
        return 1.0 if q[0] > 1e9 else float(1.0 / (1.5 + math.cos(q[0]) * 0.5))

    problem, _, duration, step = CASES["double pendulum"]
    slow = galvi.integrate(problem, method(4, galvi.Clock(branches)), step, duration=duration)
    quick = galvi.integrate(problem, method(4, galvi.Clock(upright)), step, duration=duration)
    assert slow.success and np.max(np.abs(slow.q[-1] - quick.q[-1])) < 1e-8


def pulsing(q: Any, t: Any) -> Any:
    return -(1.0 + 0.1 * np.sin(t)) / np.sqrt(q @ q)


def damped(t: float, y: Any) -> Any:
    return np.concatenate([y[2:], -y[:2] / np.linalg.norm(y[:2]) ** 3 - 0.05 * y[2:]])


def driven(t: float, y: Any) -> Any:
    pull = (1.0 + 0.1 * np.sin(t)) / np.linalg.norm(y[:2]) ** 3
    return np.concatenate([y[2:], -pull * y[:2]])


DAMPED = galvi.Canonical(1.0, galvi.CentralForce(1.0), force=lambda q, v: -0.05 * v)
DRIVEN = galvi.Canonical(1.0, pulsing, explicit_time=True)


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


KEPLER, BURRAU = galvi.problems.kepler(0.5), burrau()
DYNAMICAL, CIRCLES = galvi.DynamicalTime(), galvi.Sundman()
FORCED = galvi.Problem(
    galvi.Canonical(1.0, galvi.CentralForce(1.0), force=lambda q, v: -0.1 * v), [1.0, 0.0],
    [0.0, 1.0],
)  # fmt: skip
REFUSED = [
    (lambda: galvi.integrate(KEPLER, method(4, DYNAMICAL), 0.1, 3), "at least two bodies"),
    (lambda: galvi.integrate(BURRAU, method(4, CIRCLES), 0.1, 3), "one particle"),
    (lambda: galvi.integrate(BURRAU, method(4, DYNAMICAL), 7.0, 3), "a revolution is 2 pi"),
    (lambda: galvi.integrate(BURRAU, method(4, DYNAMICAL), 0.1), "received neither"),
    (lambda: galvi.integrate(KEPLER, method(4, galvi.Clock(lambda q: -1.0)), 0.1, 3), "positive"),
    (lambda: galvi.integrate(KEPLER, method(4, galvi.Clock(lambda q: np.inf)), 0.1, 3), "finite"),
    (lambda: galvi.integrate(FORCED, method(4, CIRCLES, MORE), 0.1, 3), "collocate t"),
    (lambda: galvi.step_derivative(KEPLER, method(4, CIRCLES), 0.1), "symplecticity_defect"),
    (lambda: galvi.theory(method(4, CIRCLES), problem=KEPLER, step=0.1), "constant in time"),
    (lambda: galvi.Clock(3), "must be a function"),
    (lambda: galvi.Sundman(0.0), "power"),
    (lambda: method(4, 3), "clock must be a clock"),
    (lambda: method(4, galvi.DynamicalTime), "clock must be a clock"),
    (lambda: galvi.resume(galvi.integrate(KEPLER, method(4, CIRCLES), 0.1, 3), until=0.0), "until"),
]  # fmt: skip


@pytest.mark.parametrize(("call", "words"), REFUSED)
def test_what_a_clock_cannot_do_is_refused_in_words(call: Any, words: str) -> None:
    with pytest.raises((ValueError, TypeError), match=words):
        call()


@pytest.mark.skipif(not galvi.FAST, reason="frames need galvi.fast")
def test_a_frame_and_a_clock_exclude_each_other() -> None:
    with pytest.raises(ValueError, match="exclude each other"):
        galvi.Galerkin(
            galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame(), clock=DYNAMICAL
        )


@pytest.mark.skipif(not galvi.FAST, reason="ensembles need galvi.fast")
def test_members_of_an_ensemble_have_clocks_of_their_own() -> None:
    problem, chosen = three_bodies(), method(6, DYNAMICAL)
    q = problem.q0 + 1e-2 * np.arange(5)[:, None, None] * np.array([0.0, 1.0, -0.5])[:, None]
    found = galvi.integrate_ensemble(problem, q, problem.v0, chosen, 0.4, duration=3.0)
    runs = galvi.integrate_many(
        [problem.with_initial_state(one, problem.v0) for one in q], chosen, 0.4, duration=3.0
    )
    for k, run in enumerate(runs):
        assert np.array_equal(found[0][k], run.q[-1]) and found.success[k]
    assert len({len(run.t) for run in runs}) > 1
    at = galvi.integrate_ensemble(
        problem, q, problem.v0, chosen, 0.4, duration=3.0, keep=galvi.StatesAt([1.0, 2.5])
    )
    assert np.array_equal(at[0][3], galvi.states_at(runs[3], [1.0, 2.5])[0])
    steps = [0.4, 0.3, 0.2, 0.4, 0.4]
    own = galvi.integrate_ensemble(problem, q, problem.v0, chosen, steps, duration=3.0)
    assert np.array_equal(own[0][[0, 3, 4]], found[0][[0, 3, 4]])
    assert not np.array_equal(own[0][1], found[0][1])
    for more, words in (({"folder": "x"}, "folder"), ({"keep": galvi.Extrema()}, "StatesAt")):
        with pytest.raises(ValueError, match=words):
            galvi.integrate_ensemble(problem, q, problem.v0, chosen, 0.4, duration=3.0, **more)


@pytest.mark.skipif(not galvi.FAST, reason="ensembles need galvi.fast")
def test_an_ensemble_without_a_clock_takes_a_duration_too() -> None:
    q = KEPLER.q0 * np.array([[1.0], [1.1]])
    plain = method(6, None)
    one = galvi.integrate_ensemble(KEPLER, q, KEPLER.v0, plain, 0.1, duration=2.0)
    other = galvi.integrate_ensemble(KEPLER, q, KEPLER.v0, plain, 0.1, 20)
    assert np.array_equal(one[0], other[0])
    with pytest.raises(ValueError, match="same number of steps"):
        galvi.integrate_ensemble(KEPLER, q, KEPLER.v0, plain, [0.1, 0.2], duration=2.0)


def test_a_run_that_would_fill_the_memory_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("galvi.run.clocked.loop.free_memory", lambda: 2e5)
    monkeypatch.setattr("galvi.run.clocked.loop.ALWAYS_FREE", 0)
    run = galvi.integrate(burrau(), method(8, DYNAMICAL), 0.3, 10**6)
    assert not run.success and "fills half of the free memory" in run.status
    assert np.isfinite(run.q).all() and len(run.t) < 10_000
    fewer = galvi.integrate(burrau(), method(8, DYNAMICAL), 0.3, 2000, save_every=500)
    assert fewer.success


def test_states_of_a_damped_run_have_the_energy_that_is_left() -> None:
    problem = galvi.Problem(DAMPED, [1.0, 0.0], [0.0, 0.8])
    times = np.array([0.333, 1.7, 2.8])
    run = galvi.integrate(problem, method(6, CIRCLES), 0.2, duration=3.0, save_every=4)
    q, _ = galvi.states_at(run, times)
    tight = {"method": "DOP853", "rtol": 1e-13, "atol": 1e-14, "t_eval": times}
    truth = solve_ivp(damped, (0.0, 3.0), [1.0, 0.0, 0.0, 0.8], **tight).y[:2].T
    assert np.max(np.abs(q - truth)) < 1e-10


def test_states_at_grid_points_that_were_not_saved_are_those_of_the_grid() -> None:
    whole = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 40)
    coarse = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 40, save_every=10)
    q, p = galvi.states_at(coarse, whole.t)
    assert np.max(np.abs(q - whole.q)) < 1e-13 and np.max(np.abs(p - whole.p)) < 1e-13


@pytest.mark.parametrize("more", [{"save_every": 10}, {"save_every": 100, "duration": 90.0}])
def test_a_run_whose_last_steps_are_not_saved_keeps_its_end(more: Any) -> None:
    run = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 7, **more)
    every = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 7)
    assert np.array_equal(run.q, every.q[[0, -1]])
    rest = galvi.resume(run, 3)
    assert np.array_equal(rest.q[-1], galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 10).q[-1])


def test_a_duration_that_ends_next_to_the_grid_is_met() -> None:
    grid = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 7)
    for d in (grid.t[-1], np.nextafter(grid.t[-1], 9.0), np.nextafter(grid.t[-1], 0.0)):
        run = galvi.integrate(KEPLER, method(4, CIRCLES), 0.3, 7, duration=d)
        assert run.success and run.t[-1] == d, run.status
        assert np.max(np.abs(run.q[-1] - grid.q[-1])) < 1e-14


def test_a_step_that_is_shortened_at_once_is_judged() -> None:
    problem = galvi.problems.kepler(0.9)
    g = 0.1**1.5
    run = galvi.integrate(problem, method(1, CIRCLES), 1.5, duration=0.99 * g * 1.5)
    change = np.ptp(galvi.energy(run)) / abs(galvi.energy(run)[0])
    assert run.counts["steps"] == 0 and change > 0.01
    assert not run.success or "energy changed" in run.status


def test_a_clock_that_is_not_positive_at_a_stage_ends_the_run_before_that_step() -> None:
    chosen = method(6, CIRCLES)
    sound = motion_of(KEPLER, chosen, "auto", ROUND_OFF)

    def advance(state: Any, h: float, n: int, time: Any, keep: bool) -> Any:
        found = sound.advance(state, h, n, time, keep)
        rates = found.taken.rates.copy()
        rates[max(0, 5 - state.first) :, 2] = -1.0  # from step 6 on
        return found._replace(taken=found.taken._replace(rates=rates))

    start = replace(sound.at(KEPLER.q0, KEPLER.v0, 0.0), save_every=1)
    loop = Loop(KEPLER, chosen, 0.2, replace(sound, advance=advance), start, None)
    while not loop.over:
        loop.call(4)
    whole = galvi.integrate(KEPLER, chosen, 0.2, 5)
    assert loop.done == 5 and "not positive at a stage of step 6" in loop.reason
    assert loop.last is not None and np.array_equal(loop.last.q[0], whole.q[-1])


def test_a_wrong_gradient_of_a_clock_is_refused() -> None:
    def branches(q: Any) -> float:
        return 1.0 if q[0] > 1e9 else float((q @ q) ** 0.75)

    wrong = galvi.Clock(branches, lambda q: np.ones(2))
    with pytest.raises(ValueError, match="gradient must be dg/dq"):
        galvi.integrate(KEPLER, method(4, wrong), 0.1, 3)
    right = galvi.Clock(branches, lambda q: 1.5 * (q @ q) ** -0.25 * q)
    run = galvi.integrate(KEPLER, method(4, right), 0.1, 10)
    same = galvi.integrate(KEPLER, method(4, CIRCLES), 0.1, 10)
    assert np.max(np.abs(run.q - same.q)) < 1e-12


def test_runs_backwards_and_from_rest_have_no_false_remarks() -> None:
    back = galvi.integrate(KEPLER, method(6, CIRCLES), -0.2, 10)
    assert back.status == "Completed."

    def branches(q: Any) -> float:
        return 1.0 if q[0] > 1e9 else float((q @ q) ** 0.75)

    rest = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(1.0)), [1.0, 0.2], [0.0, 0.0])
    run = galvi.integrate(rest, method(6, galvi.Clock(branches)), 0.2, 5)
    same = galvi.integrate(rest, method(6, CIRCLES), 0.2, 5)
    assert run.success and np.max(np.abs(run.q - same.q)) < 1e-12

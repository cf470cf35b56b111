"""Runs with a clock: resumed, saved, ended early, exported, and as members of ensembles."""

from __future__ import annotations

import math
import pickle
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.curves.clock_curves import ClockCurves
from galvi.run.clocked.stepper import ClockStepper
from galvi.run.engines import motion_in_clock
from galvi.run.request import ROUND_OFF, RunRequest
from references.stored.encounters import sitnikov
from tests.properties.clock_problems import (
    BURRAU,
    CASES,
    DYNAMICAL,
    KEPLER,
    SUNDMAN,
    method,
    three_bodies,
    traced_clock,
    untraced_clock,
)

in_lanes = pytest.mark.skipif(not galvi.FAST, reason="needs the engine of lanes")


@pytest.mark.parametrize("case", ["Kepler, Sundman", "3D pendulum", "three bodies"])
def test_a_continued_run_has_the_bits_of_one_long_run(case: str) -> None:
    problem, clock, duration, step = CASES[case]
    uncut, part = (
        galvi.integrate(problem, method(4, clock), step, duration=fraction * duration)
        for fraction in (1.0, 0.4)
    )
    resumed = galvi.resume(part, until=duration)
    assert resumed.t[0] == part.t[-1] and resumed.t[-1] == duration
    n = len(resumed.q) - 1
    for name in ("q", "p", "tau"):
        assert np.array_equal(getattr(resumed, name)[1:], getattr(uncut, name)[-n:])
    resumed_twice = galvi.resume(galvi.resume(part, 2), 2)
    assert np.array_equal(resumed_twice.q[-1], galvi.resume(part, 4).q[-1])


def test_a_saved_run_is_the_same_run(tmp_path: Path) -> None:
    problem, clock, duration, step = CASES["Kepler, Sundman"]
    full, run = (
        galvi.integrate(problem, method(6, clock), step, duration=duration, save_every=k)
        for k in (1, 5)
    )
    times = np.linspace(0.0, duration, 17)
    galvi.save(run, tmp_path / "run.npz")
    for restored in (galvi.load(tmp_path / "run.npz"), pickle.loads(pickle.dumps(run))):
        assert restored.status == run.status and restored.engine == run.engine
        assert np.array_equal(restored.tau, run.tau) and np.array_equal(restored(times), run(times))
        resumed = galvi.resume(restored, duration=1.0)
        assert np.array_equal(resumed.q, galvi.resume(run, duration=1.0).q)
    assert np.array_equal(full.q[:-1][::5], run.q[:-1])
    assert np.max(np.abs(full(times) - run(times))) < 1e-14


def test_a_run_becomes_an_ode_result_with_its_own_times() -> None:
    problem, clock, duration, step = CASES["Kepler, eccentric anomaly"]
    run = galvi.integrate(problem, method(4, clock), step, duration=duration)
    solution = run.to_scipy()
    assert solution.success and np.array_equal(solution.t, run.t)
    assert np.max(np.abs(solution.sol(2.2)[:2] - run(2.2))) < 1e-14


def test_the_end_of_a_run_becomes_a_simulation() -> None:
    pytest.importorskip("rebound")
    run = galvi.integrate(sitnikov(), method(6, DYNAMICAL), 0.3, duration=3.0)
    sim = run.to_rebound()
    assert sim.t == 3.0
    assert np.array_equal([body.xyz for body in sim.particles], run.q[-1])


def test_a_collision_ends_the_run_and_names_the_bodies() -> None:
    head_on = galvi.Problem(
        galvi.NBody([1.0, 1.0]),
        [[1.0, 0.0], [-1.0, 0.0]],
        np.zeros((2, 2)),
        parameters={"bodies": ["Castor", "Pollux"]},
    )
    run = galvi.integrate(head_on, method(8, DYNAMICAL), 0.3, duration=63.0)
    assert not run.success and "Castor and Pollux collide" in run.status
    # free fall of two bodies: (pi / 2) sqrt(d^3 / (2 M)) with distance and total mass 2
    assert abs(run.t[-1] - math.pi / math.sqrt(2.0)) < 1e-12 and np.isfinite(run.q).all()


def test_a_pair_that_sets_the_steps_of_all_is_named() -> None:
    q = [[0.0, 0.0], [30.0, 0.0], [30.01, 0.0]]
    v = [[0.0, 0.0], [0.0, 0.18], [0.0, 0.18 + math.sqrt(2e-3 / 0.01)]]
    problem = galvi.Problem(galvi.NBody([1.0, 1e-3, 1e-3]), q, v)
    run = galvi.integrate(problem, method(6, DYNAMICAL), 0.4, 100)
    assert "Bodies 1 and 2 set the steps of all" in run.status


def test_a_duration_within_a_step_is_one_shortened_step() -> None:
    run = galvi.integrate(BURRAU, method(8, DYNAMICAL), 0.3, duration=1e-3)
    assert run.success and run.t[-1] == 1e-3
    assert run.counts["steps"] == 0  # a shortened step is not counted


def test_steps_bound_a_duration_and_say_so() -> None:
    run = galvi.integrate(BURRAU, method(6, DYNAMICAL), 0.3, 20, duration=63.0)
    assert run.outcome.end is galvi.End.STEP_LIMIT and len(run.t) == run.failed_step == 21
    assert galvi.resume(run, until=63.0).t[-1] == 63.0


def test_a_step_whose_time_does_not_grow_is_reported() -> None:
    run = galvi.integrate(galvi.problems.kepler(0.9), method(2, SUNDMAN), 1.0, 8)
    assert isinstance(run.curves, ClockCurves)
    first = run.t[run.curves.steps_backwards()[0]]  # t(tau) dips between two stages
    assert f"The time does not grow along the step from t = {first:.10g}" in run.outcome.notes[0]
    fine = galvi.integrate(galvi.problems.kepler(0.9), method(8, SUNDMAN), 0.3, 40)
    assert isinstance(fine.curves, ClockCurves) and not fine.curves.steps_backwards().size


@pytest.mark.slow_cases(but=["1e+100-traced_clock", "-1e+300-traced_clock"])
@pytest.mark.parametrize("clock", [traced_clock, untraced_clock])
@pytest.mark.parametrize("step", [3.0, -5.0, 1e3, 1e100, -1e300])
def test_steps_that_are_far_too_long_fail_with_a_status_and_no_warning(
    clock: Any, step: float
) -> None:
    clock_method = method(2, galvi.Clock(clock))
    for length in ({"steps": 5}, {"duration": 1.3 * abs(step)}):
        run = galvi.integrate(galvi.problems.free_body_se3(), clock_method, step, **length)
        assert not run.success and run.failed_step == 1
        assert "units of the clock" in run.outcome.notes[0]
        assert np.isfinite(run.q).all() and np.isfinite(galvi.energy(run)).all()


@in_lanes
def test_members_of_an_ensemble_have_clocks_of_their_own() -> None:
    problem, clock_method = three_bodies(), method(6, DYNAMICAL)
    q = problem.q0 + 1e-2 * np.arange(5)[:, None, None] * np.array([0.0, 1.0, -0.5])[:, None]
    ends = galvi.integrate_ensemble(problem, q, problem.v0, clock_method, 0.4, duration=3.0)
    runs = galvi.integrate_many(
        [problem.with_initial_state(start, problem.v0) for start in q],
        clock_method,
        0.4,
        duration=3.0,
    )
    for k, run in enumerate(runs):
        assert np.array_equal(ends[0][k], run.q[-1]) and ends.success[k]
    assert len({len(run.t) for run in runs}) > 1
    states = galvi.integrate_ensemble(
        problem, q, problem.v0, clock_method, 0.4, duration=3.0, keep=galvi.StatesAt([1.0, 2.5])
    )
    assert np.array_equal(states[0][3], galvi.states_at(runs[3], [1.0, 2.5])[0])
    steps = [0.4, 0.3, 0.2, 0.4, 0.4]
    by_steps = galvi.integrate_ensemble(problem, q, problem.v0, clock_method, steps, duration=3.0)
    assert np.array_equal(by_steps[0][[0, 3, 4]], ends[0][[0, 3, 4]])
    assert not np.array_equal(by_steps[0][1], ends[0][1])


@in_lanes
def test_an_ensemble_without_a_clock_takes_a_duration_too() -> None:
    q, without_clock = KEPLER.q0 * np.array([[1.0], [1.1]]), method(6, None)
    by_duration = galvi.integrate_ensemble(KEPLER, q, KEPLER.v0, without_clock, 0.1, duration=2.0)
    assert np.array_equal(
        by_duration[0], galvi.integrate_ensemble(KEPLER, q, KEPLER.v0, without_clock, 0.1, 20)[0]
    )


@pytest.mark.slow(beside="test_steps_bound_a_duration_and_say_so")
def test_a_run_that_would_fill_the_memory_ends_and_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("galvi.run.clocked.stepper.free_memory", lambda: 2e5)
    monkeypatch.setattr("galvi.run.clocked.stepper.ALWAYS_FREE", 0)
    run = galvi.integrate(BURRAU, method(8, DYNAMICAL), 0.3, 10**6)
    assert not run.success and "fills half of the free memory" in run.status
    assert np.isfinite(run.q).all() and len(run.t) < 10_000
    sparse = galvi.integrate(BURRAU, method(8, DYNAMICAL), 0.3, 2000, save_every=500)
    assert sparse.success


def test_a_run_whose_last_steps_are_not_saved_keeps_its_end() -> None:
    run = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 7, save_every=100, duration=90.0)
    full = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 7)
    assert np.array_equal(run.q, full.q[[0, -1]])
    resumed = galvi.resume(run, 3)
    assert np.array_equal(resumed.q[-1], galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 10).q[-1])


def test_a_duration_that_ends_next_to_the_grid_is_met() -> None:
    grid = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 7)
    for d in (grid.t[-1], np.nextafter(grid.t[-1], 9.0), np.nextafter(grid.t[-1], 0.0)):
        run = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 7, duration=d)
        assert run.success and run.t[-1] == d, run.status
        assert np.max(np.abs(run.q[-1] - grid.q[-1])) < 1e-14


def test_a_curve_is_recomputed_up_to_an_end_at_a_checkpoint(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.setattr("galvi.run.loop.STEPS_BETWEEN_STATES", 4)
    grid = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, 8)
    end = float(grid.t[-1])
    run = galvi.integrate(KEPLER, method(4, SUNDMAN), 0.3, duration=end, save_every=8)
    assert run.again is not None and [checkpoint.first for checkpoint in run.again.checkpoints] == [
        0,
        4,
        8,
    ]
    times = np.array([0.0, 0.4 * end, grid.t[4], end])
    assert np.array_equal(run(times), grid(times)) and np.array_equal(run(end), grid.q[-1])


@pytest.mark.parametrize(("ulps", "met"), [(40, True), (100, False)])
def test_a_missed_end_time_is_reported_only_beyond_the_tolerance(ulps: int, met: bool) -> None:
    """Planted: the times of steps are multiples of a grain, and the requested time lies between
    two of them."""
    grain = ulps * math.ulp(1.0)
    clock_method = method(4, SUNDMAN)
    motion = motion_in_clock(KEPLER, clock_method, "auto", ROUND_OFF)

    def advance(*arguments: Any) -> Any:
        advanced = motion.advance(*arguments)
        times = np.zeros_like(advanced.steps.t)
        times[:, 0] = grain * np.round(advanced.steps.t.sum(axis=1) / grain)
        return advanced._replace(steps=advanced.steps._replace(t=times))

    start = motion.at(KEPLER.q0, KEPLER.v0, KEPLER.t0)
    time = grain * (round(0.3 / grain) + 0.5)
    request = RunRequest(KEPLER, clock_method, 1.0, None, start, time)
    stepper = ClockStepper(request, replace(motion, advance=advance))
    stepper.begin()
    end, _ = stepper.to_time()
    assert (end is not None) == met and bool(stepper.failure_reason) != met


@pytest.mark.slow(beside="test_a_duration_within_a_step_is_one_shortened_step")
def test_a_step_that_is_shortened_at_once_is_assessed() -> None:
    problem = galvi.problems.kepler(0.9)
    step, g = 1.5, 0.1**1.5  # g = dt/dtau = r^1.5 at the pericentre, r = 1 - e
    run = galvi.integrate(problem, method(1, SUNDMAN), step, duration=0.99 * g * step)
    energy_change = np.ptp(galvi.energy(run)) / abs(galvi.energy(run)[0])
    assert run.counts["steps"] == 0 and energy_change > 0.01
    assert not run.success or "energy changed" in run.status


def test_a_clock_that_is_not_positive_at_a_stage_ends_the_run_before_that_step() -> None:
    clock_method = method(2, galvi.Clock(lambda q: q[0] - 0.3))
    short, run = (galvi.integrate(KEPLER, clock_method, 5.0, steps) for steps in (3, 8))
    assert run.failed_step == 4 and "not positive at a stage of the step" in run.status
    assert short.success and np.array_equal(run.q[:4], short.q)


@pytest.mark.parametrize("force", [None, lambda q, v: -0.05 * v])
def test_counts_do_not_depend_on_the_batches(force: Any, monkeypatch: pytest.MonkeyPatch) -> None:
    """Steps that overshoot the requested time are repeated, but counted once."""
    problem = galvi.Problem(
        galvi.Canonical(1.0, galvi.CentralForce(1.0), force=force), KEPLER.q0, KEPLER.v0
    )
    counts = []
    for seconds in (0.0, 1e-3, 1e9):  # of a batch
        monkeypatch.setattr("galvi.run.batches.BATCH_SECONDS", seconds)
        counts.append(galvi.integrate(problem, method(3, SUNDMAN), 0.2, duration=2.0).counts)
    assert counts[0] == counts[1] == counts[2]


def branching_clock(q: Any) -> float:
    return 1.0 if q[0] > 1e9 else float((q @ q) ** 0.75)


@pytest.mark.parametrize(
    ("v0", "gradient"), [(KEPLER.v0, lambda q: 1.5 * (q @ q) ** -0.25 * q), ([0.0, 0.0], None)]
)
def test_an_untraceable_clock_gives_the_run_of_a_traceable_one(v0: Any, gradient: Any) -> None:
    """A start at rest does not cause a false warning about the energy either."""
    problem = KEPLER.with_initial_state([1.0, 0.2], v0)
    untraced_run, traced_run = (
        galvi.integrate(problem, method(6, clock), 0.2, 5)
        for clock in (galvi.Clock(branching_clock, gradient), SUNDMAN)
    )
    assert (
        untraced_run.status == "Completed."
        and np.max(np.abs(untraced_run.q - traced_run.q)) < 1e-12
    )

"""Events during a run: they end it, change its state, and are saved with it."""

from __future__ import annotations

import math
import pickle
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import galvi
from galvi.events import run as events_in_runs
from galvi.events import search

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
BALL = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([-1.0])), [1.0], [0.0])
ORBIT = galvi.problems.kepler(0.5)
IN_CLOCK = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.Sundman())
FALL = math.sqrt(2.0)  # the time of the first bounce


def height(q: Any, v: Any, t: Any) -> Any:
    return q[0]


BOUNCE = galvi.Event(height, -1, action=lambda q, v, t: (q, -v), name="bounce")
GROUND = galvi.Event(height, -1, terminal=True, name="ground")


def ball(t: Any) -> Any:
    """The height at time t of a ball that falls from 1 and bounces without loss."""
    time_from_top = (t + FALL) % (2.0 * FALL) - FALL
    return 1.0 - 0.5 * time_from_top**2


@pytest.mark.slow_cases("0.3")
@pytest.mark.parametrize("step", [0.3, -0.3])
def test_a_ball_bounces_as_in_closed_form(step: float) -> None:
    run = galvi.integrate(BALL, EIGHT, step, 600, events=BOUNCE)
    assert run.outcome.end is galvi.End.COMPLETED
    assert np.allclose(run.t, np.arange(601) * step, rtol=1e-13)  # the grid is unchanged
    expected = FALL * (1.0 + 2.0 * np.arange(len(run.events)))
    assert len(run.events) == 64 and np.max(np.abs(np.abs(run.events.t) - expected)) < 1e-11
    assert np.max(np.abs(run.q[:, 0] - ball(np.abs(run.t)))) < 1e-11
    between = 0.5 * (run.t[1:] + run.t[:-1])
    assert np.max(np.abs(run(between)[:, 0] - ball(np.abs(between)))) < 1e-11
    assert np.max(np.abs(galvi.states_at(run, between)[0][:, 0] - ball(np.abs(between)))) < 1e-11
    crossings = galvi.find_events(run, galvi.Event(lambda q, v, t: q[0] - 0.5))
    assert abs(len(crossings) - 128) <= 1


def test_a_terminal_event_ends_the_run_and_resume_goes_on_from_the_grid() -> None:
    run = galvi.integrate(BALL, EIGHT, 0.3, 1000, events=[GROUND])
    assert run.success and run.outcome.end is galvi.End.STOPPED_BY_EVENT
    assert run.outcome.event == "ground" and abs(run.outcome.time - math.sqrt(2.0)) < 1e-12
    assert abs(run.t[-1] - FALL) < 1e-14 and abs(run.q[-1, 0]) < 1e-14 and len(run) == 6
    uncut = galvi.integrate(BALL, EIGHT, 0.3, 20)
    resumed = galvi.resume(run, 10)
    assert resumed.t[0] == run.t[-1] and np.array_equal(resumed.q[1:], uncut.q[5:15])
    assert np.array_equal(resumed.t[1:], uncut.t[5:15]) and len(resumed.events) == 0
    assert np.allclose(run(run.t), run.q, atol=1e-14)


def test_times_and_the_end_have_the_order_of_the_steps_and_not_of_the_curve() -> None:
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
    problem, steps, errors = galvi.problems.harmonic_oscillator(), np.array([0.5, 0.4, 0.3]), []
    crossing_time = 2.0 * math.pi - math.acos(0.3)
    for h in steps:
        stop = galvi.Event(lambda q, v, crossing_time: q[0] - 0.3, 1, terminal=True)
        run = galvi.integrate(problem, method, h, 100, events=stop)
        assert run.t[-1] == run.events.t[0]
        errors.append(abs(run.t[-1] - crossing_time) + abs(run.p[-1, 0] - math.sin(math.acos(0.3))))
    assert 5.3 < np.polyfit(np.log(steps), np.log(errors), 1)[0] < 6.7


def test_in_a_clock_an_action_resets_the_energy() -> None:
    event = galvi.Event(lambda q, v, t: q[1], -1, action=lambda q, v, t: (q, 0.9 * v))
    run = galvi.integrate(ORBIT, IN_CLOCK, 0.3, duration=9.0, events=event, save_every=7)
    assert run.success and len(run.events) >= 1
    t0, q, v = run.events.t[0], run.events.q[0], 0.9 * run.events.v[0]
    assert abs(t0 - math.pi) < 1e-12 and run.t[-1] == 9.0
    assert np.all(np.diff(run.t) > 0.0) and np.all(np.diff(run.tau) > 0.0)
    continued = galvi.integrate(galvi.Problem(ORBIT.system, q, v), IN_CLOCK, 0.3, duration=1.0)
    states = galvi.states_at(run, t0 + 1.0)
    assert np.max(np.abs(states[0] - continued.q[-1])) < 1e-11
    assert np.max(np.abs(states[1] - continued.p[-1])) < 1e-11


def test_a_terminal_event_in_a_clock_leaves_the_grid_alone() -> None:
    event = galvi.Event(lambda q, v, t: q[1], terminal=True)
    run = galvi.integrate(ORBIT, IN_CLOCK, 0.5, duration=20.0, events=event)
    assert abs(run.t[-1] - math.pi) < 1e-13
    resumed = galvi.resume(run, until=12.0, events=())
    uncut = galvi.integrate(ORBIT, IN_CLOCK, 0.5, duration=12.0)
    assert np.array_equal(resumed.q[1:], uncut.q[len(run) - 1 :])


@pytest.mark.parametrize("events", [None, [], np.array([])], ids=("None", "list", "array"))
@pytest.mark.parametrize("method", [EIGHT, IN_CLOCK], ids=("steps", "clock"))
def test_no_events_are_none_of_any_kind(events: Any, method: Any) -> None:
    run = galvi.integrate(ORBIT, method, 0.1, 2, duration=None, events=events)
    runs = galvi.integrate_many([ORBIT], method, 0.1, 2, events=events)
    for trajectory in (run, galvi.resume(run, 2, events=events), *runs):
        assert trajectory.success and trajectory.events is None


def test_an_action_on_a_driven_system_leads_to_the_run_from_there() -> None:
    driven = galvi.Canonical(
        1.0, lambda q, t: 0.5 * q[0] ** 2 - q[0] * np.sin(t), explicit_time=True
    )
    event = galvi.Event(lambda q, v, t: q[0], action=lambda q, v, t: (q, 0.5 * v))
    problem = galvi.Problem(driven, [1.0], [0.0])
    run = galvi.integrate(problem, EIGHT, 0.2, 60, events=event)
    t, q, v = (getattr(run.events, name)[0] for name in "tqv")
    gap = 0.5 * (run.events.t[1] - t)
    after = galvi.integrate(galvi.Problem(driven, q, 0.5 * v, t), EIGHT, gap / 40, 40)
    assert np.max(np.abs(galvi.states_at(run, t + gap)[0] - after.q[-1])) < 1e-9


def test_found_events_are_kept(tmp_path: Path) -> None:
    for event in (galvi.Event(height, name="zero"), BOUNCE, GROUND):
        run = galvi.integrate(BALL, EIGHT, 0.3, 20, events=event)
        galvi.save(run, tmp_path / "run.npz")
        loaded = galvi.load(tmp_path / "run.npz", problem=BALL)
        assert np.array_equal(loaded.events.t, run.events.t) and loaded.status == run.status
        assert loaded.events.name == run.events.name
        with pytest.raises(ValueError, match="Give its events again"):
            galvi.resume(loaded, 5)
        from_file, from_run = galvi.resume(loaded, 5, events=event), galvi.resume(run, 5)
        assert np.array_equal(from_file.q, from_run.q) and np.array_equal(
            from_file.events.t, from_run.events.t
        )
    crossing = galvi.integrate(
        ORBIT, EIGHT, 0.1, 50, events=galvi.events.plane_crossing((0.0, 1.0))
    )
    assert np.array_equal(pickle.loads(pickle.dumps(crossing)).events.t, crossing.events.t)


def test_a_run_resumed_after_actions_is_one_long_run() -> None:
    uncut = galvi.integrate(BALL, EIGHT, 0.3, 40, events=BOUNCE)
    part = galvi.integrate(BALL, EIGHT, 0.3, 17, events=BOUNCE)
    resumed = galvi.resume(part, 23)
    assert np.array_equal(resumed.q, uncut.q[17:]) and np.array_equal(resumed.t, uncut.t[17:])
    count = len(part.events)
    assert np.array_equal(resumed.events.t, uncut.events.t[count:])


def test_a_thinned_run_that_an_event_ends_has_its_rows_and_its_curve() -> None:
    stop = galvi.Event(lambda q, v, t: q[1], terminal=True)
    thinned = galvi.integrate(ORBIT, EIGHT, 0.1, 43, save_every=10, events=stop)
    assert len(thinned) == 5 and abs(thinned.t[-1] - math.pi) < 1e-12
    assert np.max(np.abs(thinned(thinned.t[:-1]) - thinned.q[:-1])) < 1e-13


def test_events_behind_an_action_are_counted_once(monkeypatch: pytest.MonkeyPatch) -> None:
    half = galvi.Event(lambda q, v, t: q[0] - 0.5, name="half")
    unbounded = galvi.integrate(BALL, EIGHT, 0.3, 200, events=[BOUNCE, half])
    for module in (events_in_runs, search):
        monkeypatch.setattr(module, "MAX_EVENTS", len(unbounded.events))
    bounded = galvi.integrate(BALL, EIGHT, 0.3, 200, events=[BOUNCE, half])
    assert len(bounded.events) == len(unbounded.events) > 60 and bounded.success, bounded.status


def test_several_runs_pass_their_events_on() -> None:
    runs = galvi.integrate_many(
        [ORBIT, ORBIT],
        EIGHT,
        0.1,
        43,
        events=galvi.Event(lambda q, v, t: q[1], terminal=True, name="half"),
    )
    assert all(abs(run.t[-1] - math.pi) < 1e-12 for run in runs)


@pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
def test_an_ensemble_keeps_events(tmp_path: Path) -> None:
    keep = galvi.Events(galvi.events.plane_crossing((0.0, 1.0)), 3)
    v = np.array([1.0, 0.999])[:, None] * ORBIT.v0
    options: Any = {"keep": keep, "folder": tmp_path}
    ends = galvi.integrate_ensemble(ORBIT, ORBIT.q0, v, EIGHT, 0.1, 80, **options)
    rows = np.asarray(ends)
    assert rows.shape == (2, 3, 5) and np.all(rows[:, :, 4] == 2.0)
    assert np.max(np.abs(rows[0, :2, 0] - [math.pi, 2.0 * math.pi])) < 1e-12
    assert np.all(np.isnan(rows[:, 2, :4]))
    reloaded = galvi.integrate_ensemble(ORBIT, ORBIT.q0, v, EIGHT, 0.1, 80, **options)
    assert (
        np.array_equal(np.asarray(reloaded), rows, equal_nan=True) and "1 loaded" in reloaded.files
    )


def test_an_event_that_chatters_ends_the_run() -> None:
    event = galvi.Event(height, -1, action=lambda q, v, t: (q, 0.5 * np.abs(v)), name="dead ball")
    run = galvi.integrate(BALL, EIGHT, 3.0, 20, events=event)
    assert run.outcome.end is galvi.End.STEP_FAILED and run.failed_step is not None
    assert np.all(np.isfinite(run.q)) and len(run.events) > 10

"""Passages of two bodies that a step in a clock does not resolve, and no others, are named."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest

import galvi
from galvi.kernels.forces.passages import UNRESOLVED
from galvi.run.clocked import stepper
from references.rebound.ias15 import IAS15
from references.stored import encounters
from tests.properties.clock_problems import DYNAMICAL, method

pytestmark = pytest.mark.skipif(not galvi.FAST, reason="the general kernel alone has none")
DURATION = 6.0


def passage(number: int) -> galvi.Problem:
    """Two light bodies about a star that pass each other at t = 3 within half a Hill radius."""
    rng = np.random.Generator(np.random.Philox(number))
    masses = np.array([1.0, *10.0 ** rng.uniform(-5.5, -3.0, 2)])
    masses[2] *= number % 2
    r, angle, angle_of_second = (
        rng.uniform(0.8, 1.5),
        rng.uniform(0.0, 2.0 * np.pi),
        rng.uniform(-1.0, 1.0),
    )
    meeting_point, direction = r * rotation(angle) @ [1.0, 0.0], rotation(angle) @ [0.0, 1.0]
    first = rng.uniform(0.8, 1.1) / np.sqrt(r) * direction
    second = rng.uniform(0.7, 1.2) * rotation(angle_of_second) @ first
    hill = r * ((masses[1] + masses[2]) / 3.0) ** (1.0 / 3.0)
    separation = (
        hill * rng.uniform(0.02, 0.5) * rotation(rng.uniform(0.0, 2.0 * np.pi)) @ [1.0, 0.0]
    )
    encounter = galvi.Problem(
        galvi.NBody(masses),
        [[0.0, 0.0], meeting_point, meeting_point + separation],
        [[0.0, 0.0], first, second],
    )
    back = IAS15.run(encounter, -0.5 * DURATION, {"samples": 1})
    return galvi.Problem(encounter.system, back.q[-1], back.v[-1])


def rotation(angle: float) -> Any:
    return np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])


@pytest.mark.parametrize("number", range(8))
def test_a_run_that_is_wrong_after_a_passage_says_so(number: int) -> None:
    problem = passage(number)
    truth = IAS15.run(problem, DURATION, {"samples": 1}).q[-1]
    for step in (0.6, 0.4, 0.3, 0.2, 0.1, 0.05):
        run = galvi.integrate(problem, EIGHT, step, duration=DURATION)
        error = float(np.max(np.abs(run.q[-1] - truth)))
        warned = not run.success or run.status.startswith("Completed, but")
        assert warned or error < 1e-3, (step, error)
        assert step > 0.1 or (not warned and error < 1e-4), (step, error, run.status)


CLOSE_STATE = (  # two planets of 1e-5 that pass at 2e-3
    [[7.2283e-06, -1.89857e-05], [0.6974469761, 0.5594905041], [-1.42027244, 1.3390793551]],
    [[7.0939e-06, 2.6277e-06], [-0.7732756731, 0.4940799962], [0.06388694, -0.7568476381]],
)
CLOSE, EIGHT = galvi.Problem(galvi.NBody([1.0, 1e-5, 1e-5]), *CLOSE_STATE), method(8, DYNAMICAL)


@pytest.fixture(scope="module")
def uncut() -> galvi.Trajectory:
    return galvi.integrate(CLOSE, EIGHT, 0.3, duration=DURATION)


def test_the_bodies_the_distance_and_the_error_are_named(
    uncut: galvi.Trajectory, monkeypatch: pytest.MonkeyPatch
) -> None:
    assert "bodies 1 and 2 passed at a distance of about 2.1e-03 near t = 2.9" in uncut.status
    assert "error of about 3e-03 in their relative velocity" in uncut.status
    half = galvi.integrate(CLOSE, EIGHT, 0.3, duration=2.5)
    assert (
        galvi.resume(half, until=DURATION).status == uncut.status
    )  # the passage is kept in the checkpoint
    # Planted: only steps that contain the closest approach are examined.
    monkeypatch.setattr(stepper, "compiled_note_states", lambda: lambda *arguments: None)
    assert galvi.integrate(CLOSE, EIGHT, 0.3, duration=DURATION).status == "Completed."


RIGHT = {
    "Burrau": (encounters.burrau(), 60.0),
    "a binary meets a star": (encounters.binary_meets_star(), 20.0),
    "sixteen stars": (encounters.sixteen_stars(), 3.0),
    "Kozai": (encounters.kozai_triple(), 6000.0),
    "Sitnikov": (encounters.sitnikov(), 200.0),
    "HD 80606": (encounters.hd_80606(), 628.0),
    "third body": (encounters.third_body(1e-3), 20.0),
}


@pytest.mark.slow_cases("Kozai")
@pytest.mark.parametrize("name", RIGHT)
def test_a_run_that_resolves_its_passages_says_nothing(name: str) -> None:
    problem, duration = RIGHT[name]
    run = galvi.integrate(problem, EIGHT, 0.6, duration=duration)
    assert run.success and "passed at" not in run.status
    assert run.checkpoint.passage[0] < 0.1 * UNRESOLVED


@pytest.mark.parametrize(
    ("time", "options"),
    [
        (3.2, {"action": lambda q, v, t: (q, v)}),
        (5.5, {"action": lambda q, v, t: (q, v)}),
        (3.2, {"terminal": True}),
        (3.2, {}),
    ],
    ids=["an action", "a late action", "an end", "watched"],
)
def test_a_passage_is_named_in_a_run_with_events_too(time: float, options: Any) -> None:
    event = galvi.Event(lambda q, v, t: t - time, **options)
    run = galvi.integrate(CLOSE, EIGHT, 0.3, duration=DURATION, events=[event])
    assert run.success and "bodies 1 and 2 passed at a distance of about 2.1e-03" in run.status


def test_a_passage_in_the_last_shortened_step_is_named(uncut: galvi.Trajectory) -> None:
    step = int(np.argmin(np.abs(uncut.t - uncut.checkpoint.passage[4])))  # ends at the passage
    end = uncut.t[step] - 0.02 * (uncut.t[step] - uncut.t[step - 1])
    short = galvi.integrate(CLOSE, EIGHT, 0.3, duration=end)
    assert len(short.t) == step + 1 and "passed at a distance of about" in short.status


@pytest.mark.parametrize("step", [0.3, -0.3])
def test_a_passage_at_the_start_is_the_same_in_transformed_time(
    step: float, uncut: galvi.Trajectory
) -> None:
    """The state in transformed time has momenta, that of lanes has velocities."""
    step_index = int(np.argmin(np.abs(uncut.t - uncut.checkpoint.passage[4])))
    at_passage = CLOSE.moved(uncut.q[step_index], uncut.v[step_index], float(uncut.t[step_index]))
    lanes, newton = (
        galvi.integrate(at_passage, EIGHT, step, 1, solver=solver).checkpoint.passage
        for solver in ("auto", "newton")
    )
    assert lanes[0] > 0.0 and np.allclose(lanes, newton, rtol=1e-6)


@pytest.mark.parametrize("mass", [1e-3, 0.0])
def test_a_fall_with_actions_ends_in_a_sentence(mass: float) -> None:
    """The last step has no length, since time stands still where the bodies collide."""
    fall = galvi.Problem(galvi.NBody([1.0, mass]), [[0, 0], [1, 0]], [[0, 0], [0, 0]])
    half = galvi.Event(lambda q, v, t: q[1, 0] - q[0, 0] - 0.5, action=lambda q, v, t: (q, v))
    run = galvi.integrate(fall, EIGHT, 1.5, duration=3.0, events=[half])
    assert not run.success and "time stands still: bodies 0 and 1 collide" in run.status
    assert len(run.events) == 1 and np.isfinite(run.q).all()


@pytest.mark.parametrize(("s", "step"), [(1, 0.3), (2, 1.0), (4, 3.0), (8, 0.6)])
def test_steps_that_are_too_long_for_a_massless_body_are_said(s: int, step: float) -> None:
    """On a circle, where the error does not show in the energy of the massless body."""
    circle = galvi.Problem(galvi.NBody([1.0, 0.0]), [[0, 0], [1, 0]], [[0, 0], [0, 1]])
    run = galvi.integrate(circle, method(s, DYNAMICAL), step, duration=60.0)
    error = float(np.max(np.abs(run.q[-1, 1] - [np.cos(60.0), np.sin(60.0)])))
    warned = "a step changes the energy of the massless body 1" in run.status
    assert warned == (error > 1e-3) and (warned or error < 1e-12)


def test_that_is_seen_at_several_states() -> None:
    """The run starts at the pericentre; at its end the steps are short enough."""
    eccentric = galvi.Problem(galvi.NBody([1.0, 0.0]), [[0, 0], [1, 0]], [[0, 0], [0, 1.9**0.5]])
    run = galvi.integrate(eccentric, method(1, DYNAMICAL), 0.2, 25)
    assert "massless body 1" in run.status

"""How a run ended is a value; the sentence is written in one place."""

from __future__ import annotations

import copy
import pickle
import signal
from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi import End, Outcome

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
IN_CLOCK = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), clock=galvi.DynamicalTime())
KEPLER = galvi.problems.kepler(0.6)
AT_REST = galvi.Problem(galvi.NBody([1.0, 1.0]), [[0.0, 0.0], [1.0, 0.0]], np.zeros((2, 2)))
ORBITING = replace(AT_REST, v0=[[0.0, -0.5], [0.0, 0.5]])
HEAD_ON = galvi.Problem(galvi.NBody([1.0, 1.0]), [[1.0, 0, 0], [-1.0, 0, 0]], np.zeros((2, 3)))
STONE = galvi.Problem(galvi.Canonical(1.0, galvi.UniformField([0.0, -1.0])), [0.0, 1.0], [1.0, 0.0])


def height(q, v, t):
    return q[1]


def spring(q):
    return 0.5 * q[0] ** 2


def wrong_gradient(q):
    return -q


WRONG = galvi.Problem(galvi.Canonical(1.0, spring, wrong_gradient, check=False), [1.0], [0.0])
GROUND = galvi.Event(height, terminal=True, name="ground")
FAR_APART = galvi.Event(lambda q, v, t: q[1, 1] - 5.0, terminal=True)

SENTENCES = {
    Outcome(): "Completed.",
    Outcome(notes=("One note.", "Another.")): "Completed. One note. Another.",
    Outcome(End.DOUBTFUL, reason="the energy changed", remedy="Use a smaller step"): (
        "Completed, but the energy changed. Use a smaller step."
    ),
    Outcome(End.RUINED, 3, reason="the energy changed", steps=9, remedy="Use a smaller step"): (
        "Ruined from step 3 of 9 on: the energy changed. Use a smaller step."
    ),
    Outcome(End.RUINED, 3, 1.5, "the energy changed", event="ground"): (
        "Ruined from step 3 on: the energy changed. Ended by the event ground, at t = 1.5."
    ),
    Outcome(End.STOPPED_BY_EVENT, time=1.5, event="ground"): (
        "Ended by the event ground, at t = 1.5."
    ),
    Outcome(End.STOPPED_BY_EVENT, None, 1.5, "the energy changed", event="ground"): (
        "Ended by the event ground, at t = 1.5, but the energy changed."
    ),
    Outcome(End.STEP_FAILED, 3, 0.2, "bodies collide", ("A note.",), 9, "Merge them"): (
        "Stopped at step 3 of 9, from t = 0.2: bodies collide. Merge them. A note."
    ),
    Outcome(End.STEP_FAILED, 3): "Stopped at step 3.",
    Outcome(End.STEP_FAILED, 3, sentence="It broke."): "It broke.",
    Outcome(End.STEP_LIMIT, 10, 0.2, "the bound was reached", steps=9): (
        "Stopped after 9 steps, at t = 0.2: the bound was reached."
    ),
    Outcome(End.INTERRUPTED, 3, 0.2, steps=9): (
        "Interrupted at step 3 of 9, from t = 0.2; what was computed is kept."
    ),
}


@pytest.mark.parametrize("outcome", SENTENCES, ids=SENTENCES.values())
def test_the_sentence_of_an_outcome(outcome):
    assert str(outcome) == SENTENCES[outcome]
    assert Outcome.from_json(outcome.to_json()) == outcome
    expected_success = outcome.end in (End.COMPLETED, End.DOUBTFUL, End.STOPPED_BY_EVENT)
    assert outcome.success == expected_success and outcome.failed_step == (
        None if expected_success else outcome.step
    )
    assert outcome.in_doubt == (expected_success and "but" in SENTENCES[outcome])


def interrupted_run():
    """A run that Ctrl-C ends."""
    calls = []

    def attraction(q):
        calls.append(q)
        if len(calls) == 100:
            signal.raise_signal(signal.SIGINT)
        return q if q[0] < 9.0 else q * np.nan  # a branch, which keeps it from being traced

    system = galvi.Canonical(1.0, spring, attraction, check=False)
    return galvi.integrate(galvi.Problem(system, [1.0], [0.0]), EIGHT, 0.1, 50_000)


RUNS = {
    End.COMPLETED: (lambda: galvi.integrate(KEPLER, EIGHT, 0.1, 50), "Completed."),
    End.DOUBTFUL: (
        lambda: galvi.integrate(
            KEPLER, galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1)), 0.1, 60
        ),
        "Completed, but the energy changed by ",
    ),
    End.RUINED: (lambda: galvi.integrate(WRONG, EIGHT, 0.1, 60), "Ruined from step 1 of 60 on: "),
    End.STOPPED_BY_EVENT: (
        lambda: galvi.integrate(STONE, EIGHT, 0.3, 100, events=GROUND),
        "Ended by the event ground, at t = 1.414213562.",
    ),
    End.STEP_FAILED: (
        lambda: galvi.integrate(AT_REST, EIGHT, 0.1, 60),
        "Stopped at step 8 of 60, from t = 0.7: bodies 0 and 1 collide. ",
    ),
    End.STEP_LIMIT: (
        lambda: galvi.integrate(ORBITING, IN_CLOCK, 0.5, 3, duration=20.0),
        "Stopped after 3 steps, at t = ",
    ),
    End.INTERRUPTED: (interrupted_run, "Interrupted at step "),
}


@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("end", End)
def test_runs_end_in_every_way_and_carry_it_along(tmp_path, end):
    run, sentence = RUNS[end][0](), RUNS[end][1]
    outcome = run.outcome
    assert outcome.end is end and run.status == str(outcome)
    assert run.status.startswith(sentence), run.status
    assert (run.success, run.failed_step) == (outcome.success, outcome.failed_step)
    galvi.save(run, tmp_path / "run.npz")
    restored = galvi.load(tmp_path / "run.npz", run.problem)
    copies = [restored, replace(run), replace(run, t=run.t), copy.deepcopy(run.ending)]
    if end is not End.INTERRUPTED:  # whose functions cannot be pickled
        copies.append(pickle.loads(pickle.dumps(run)))
    for restored_run in copies:
        assert restored_run.outcome == outcome and restored_run.outcome.end is end


def test_two_outcomes_that_differ_in_a_field_are_told_apart():
    """Planted: an outcome that was saved without one of its fields."""
    full = Outcome(End.STEP_FAILED, 3, 0.2, "bodies collide", ("A note.",), 9, "Merge", "e", "s")
    for name in vars(full):
        facts = {key: value for key, value in full.to_json().items() if key != name}
        assert Outcome.from_json({"end": "COMPLETED", "notes": [], **facts}) != full


@pytest.mark.parametrize(("method", "step"), [(EIGHT, 0.01), (IN_CLOCK, 0.05)])
def test_a_block_of_a_longer_run_has_the_numbers_of_the_run(method, step):
    """A run that an event may end is done in blocks. Its outcome counts steps of the whole run."""
    plain, watched = (
        galvi.integrate(AT_REST, method, step, 500, events=events) for events in ((), FAR_APART)
    )
    assert plain.outcome.end is End.STEP_FAILED and plain.failed_step > 64
    assert watched.outcome == plain.outcome


def test_a_run_in_blocks_says_at_which_of_all_steps_it_was_ruined():
    plain, watched = (
        galvi.integrate(HEAD_ON, EIGHT, 0.01, 700, save_every=7, events=events)
        for events in ((), FAR_APART)
    )
    assert watched.outcome.end is plain.outcome.end is End.RUINED and watched.outcome.steps == 700
    assert abs(watched.failed_step - plain.failed_step) <= 7 and watched.failed_step > 100
    assert np.array_equal(watched.q, plain.q) and np.array_equal(watched.t, plain.t)
    assert (watched.counts, watched.engine) == (plain.counts, plain.engine)


def test_a_method_of_somebody_else_says_why_it_failed():
    run = galvi.integrate(KEPLER, EIGHT, 0.1, 5)
    failed = galvi.Trajectory(
        KEPLER,
        run.t,
        run.q,
        run.p,
        success=False,
        status="It broke.",
        failed_step=3,
        counts={"steps": 2},
    )
    assert failed.outcome == Outcome(End.STEP_FAILED, 3, sentence="It broke.")
    assert (failed.success, failed.status, failed.failed_step) == (False, "It broke.", 3)
    assert replace(failed, counts={}).outcome == failed.outcome
    bare = galvi.Trajectory(KEPLER, run.t, run.q, run.p)
    assert bare.outcome == Outcome() and bare.checkpoint is None
    late = replace(run, success=False, status="Tired.")
    assert not late.success and late.status == "Tired." and late.checkpoint is run.checkpoint

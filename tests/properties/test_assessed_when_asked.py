"""The outcome of a run is assessed once, when it is first needed: by a query of it, a copy, a save
or `resume`; that of a run with Python functions before `integrate` returns. A run whose energy
cannot be assessed keeps its states and says why."""

import pickle
import signal
import time
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest
from numba import njit
from scipy.spatial.transform import Rotation

import galvi
from galvi.run import loop
from galvi.run.interruption import Interrupted, defer_interrupts
from tests.properties.lagrangians import opaque

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.6)
STEPS = 40


@pytest.fixture
def assessed_steps(monkeypatch):
    """The list of steps done at each assessment of a run."""
    steps, assess_run = [], loop.assess_run

    def counted(engine, run, work):
        steps.append(work.steps_done)
        time.sleep(0.005)  # in which another thread may ask
        return assess_run(engine, run, work)

    monkeypatch.setattr(loop, "assess_run", counted)
    return steps


def queries(tmp_path):
    """Name -> function of a run that needs its outcome."""
    return {
        "outcome": lambda run: run.outcome,
        "success": lambda run: run.success,
        "status": lambda run: run.status,
        "failed step": lambda run: run.failed_step,
        "checkpoint": lambda run: run.checkpoint,
        "repr": repr,
        "pickle": pickle.dumps,
        "replace": lambda run: replace(run, t=run.t),
        "save": lambda run: galvi.save(run, tmp_path / "run.npz"),
        "resume": lambda run: galvi.resume(run, 1).q,
        "SciPy": lambda run: run.to_scipy(),
        "threads": lambda run: {*ThreadPoolExecutor(4).map(lambda _: run.status, range(16))},
    }


@pytest.mark.parametrize("name", queries(None))
def test_a_run_is_assessed_once_when_it_is_first_asked(assessed_steps, tmp_path, name):
    run = galvi.integrate(KEPLER, EIGHT, 0.1, 50)
    run(0.3), run.v, run.to_frame(), galvi.energy(run), run.counts, run.interrupted
    assert not assessed_steps
    queries(tmp_path)[name](run)
    queries(tmp_path)[name](run)
    assert assessed_steps == [50]
    assert run.success and run.status == "Completed." and run.checkpoint.first == 50


NUMBERS = {"k": 1.0}


@pytest.mark.parametrize("solver", ["auto", "newton"])
@pytest.mark.parametrize("system_type", ["potential", "Lagrangian"])
def test_a_status_does_not_change_with_what_a_function_refers_to(monkeypatch, system_type, solver):
    """Python functions are evaluated at once, since later they may return other values."""
    if system_type == "potential":
        system = galvi.Canonical(
            1.0, lambda q: 0.5 * NUMBERS["k"] * q[0] ** 2, lambda q: NUMBERS["k"] * q
        )
        problem = galvi.Problem(system, [1.0], [0.0])
    else:
        lagrangian_system = galvi.Lagrangian(
            lambda q, v: 0.5 * v[0] ** 2 - 0.5 * NUMBERS["k"] * q[0] ** 2, galvi.Rn(1)
        )
        problem = galvi.Problem(lagrangian_system, [1.0], [0.0])
    run = galvi.integrate(problem, EIGHT, 0.5, 40, solver=solver)
    monkeypatch.setitem(NUMBERS, "k", 4.0)
    assert run.status == "Completed." and run.success


def test_ctrl_c_during_an_assessment_leaves_it_to_the_next_query(monkeypatch):
    run, assess_run = galvi.integrate(KEPLER, EIGHT, 0.1, 50), loop.assess_run

    def interrupted(*arguments):
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "assess_run", interrupted)
    with pytest.raises(KeyboardInterrupt):
        print(run.success)
    monkeypatch.setattr(loop, "assess_run", assess_run)
    assert run.success


class Planted:
    """A function of q, or of q and v, that calls ``action`` from call number ``at`` on, counted
    from 1, and wherever ``beyond(q)`` holds."""

    def __init__(self, function, action, at=None, beyond=None):
        self.function, self.action, self.at, self.beyond = function, action, at, beyond
        self.calls = 0

    def __call__(self, q, *v):
        self.calls += 1
        if (self.at is not None and self.calls >= self.at) or (self.beyond and self.beyond(q)):
            self.action()
        return self.function(q, *v)


def raising(error):
    def action():
        raise error

    return action


def spring(q):
    """|q|^2 / 2."""
    return 0.5 * q[0] ** 2


@njit
def spring_gradient(q):
    """The gradient of ``spring``, compiled: no step calls a Python function."""
    return q.copy()


def canonical(planted):
    return galvi.Problem(galvi.Canonical(1.0, planted, spring_gradient, check=False), [1.0], [0.0])


def rigid_body(planted):
    attitude = Rotation.from_rotvec([1.0, 0.0, 0.0]).as_matrix()
    system = galvi.RigidBody(
        [1.0, 2.0, 2.5], planted, lambda R: np.diag([0.0, 0.0, 2.0]), check=False
    )
    return galvi.Problem(system, attitude, [0.1, 0.2, 0.3])


def lagrangian(planted):
    system = galvi.Lagrangian(
        planted, galvi.Rn(1), lambda q, v: np.concatenate([v, -q]), check=False
    )
    return galvi.Problem(system, [1.0], [0.0])


FUNCTION_OF_PROBLEM = {
    canonical: spring,
    rigid_body: lambda R: 2.0 * R[2, 2],
    lagrangian: lambda q, v: 0.5 * (v @ v - q @ q),
}


def planted_problem(make_problem, action, at=None):
    """A problem whose steps do not call the planted function, which is also returned."""
    planted = Planted(FUNCTION_OF_PROBLEM[make_problem], action, at)
    return make_problem(planted), planted


def counted_calls(make_problem):
    """The number of calls before the assessment of a run, the number of all calls, and a run whose
    planted function does nothing."""
    problem, planted = planted_problem(make_problem, lambda: None)
    undisturbed = galvi.integrate(problem, FOUR, 0.1, STEPS)
    assert undisturbed.status == "Completed."
    total = planted.calls
    assert galvi.integrate(problem, FOUR, 0.1, STEPS).success
    calls_of_second_run = planted.calls - total  # of its assessment alone: steps make none
    return total - calls_of_second_run, total, undisturbed


ERRORS = [KeyError(7), RuntimeError("outside\nthe table"), TypeError("no float"), OSError()]


@pytest.mark.parametrize(
    ("make_problem", "error"), [*zip([*FUNCTION_OF_PROBLEM, canonical], ERRORS, strict=True)]
)
def test_an_exception_in_the_assessment_is_named_and_loses_nothing(make_problem, error):
    before, total, undisturbed = counted_calls(make_problem)
    for call_number in sorted({before + 1, before + 2, (before + total) // 2, total}):
        problem, planted = planted_problem(make_problem, raising(error), call_number)
        run = galvi.integrate(problem, FOUR, 0.1, STEPS)
        assert run.success and planted.calls >= call_number
        assert run.failed_step is None and not run.interrupted
        assert np.array_equal(run.q, undisturbed.q) and np.array_equal(run.p, undisturbed.p)
        assert run.outcome.end is galvi.End.DOUBTFUL
        reason = " ".join(str(error).split())
        assert run.outcome.reason.endswith(
            f"it raised {type(error).__name__}{': ' * bool(reason)}{reason}"
        )


def test_steps_before_the_potential_fails_are_still_assessed():
    """The wrong force drives q from 1 to cosh 4, and the potential is a table that ends at 5."""
    planted = Planted(spring, raising(KeyError("off")), beyond=lambda q: abs(q[0]) > 5.0)
    right, wrong = (
        galvi.integrate(galvi.Problem(system, [1.0], [0.0]), FOUR, 0.1, STEPS)
        for system in (
            galvi.Canonical(1.0, planted, lambda q, sign=sign: sign * q, check=False)
            for sign in (1.0, -1.0)
        )
    )
    first = int(np.flatnonzero(np.abs(wrong.q[:, 0]) > 5.0)[0])
    assert right.outcome.end is galvi.End.COMPLETED
    assert wrong.outcome.end is galvi.End.RUINED and wrong.failed_step < first
    assert np.all(np.isfinite(wrong.q))
    (note,) = wrong.outcome.notes
    assert f"t = {0.1 * first:.10g}, where it raised KeyError: 'off'" in note


def test_a_run_that_stops_after_it_was_ruined_and_could_not_be_assessed_says_all():
    """The force has the wrong sign and becomes NaN for q >= 9; the energy is unknown for q > 3."""
    planted = Planted(spring, raising(LookupError("end")), beyond=lambda q: q[0] > 3.0)
    system = galvi.Canonical(1.0, planted, lambda q: -q if q[0] < 9.0 else q * np.nan, check=False)
    run = galvi.integrate(galvi.Problem(system, [1.0], [0.5]), FOUR, 0.1, STEPS)
    assert run.outcome.end is galvi.End.STEP_FAILED
    assert run.outcome.notes[0].startswith("It was ruined from t = ")
    assert "ts energy could not be assessed at t = " in run.outcome.notes[-1]
    assert run.failed_step == run.counts["steps"] + 1  # the first without a state
    with pytest.raises(ValueError, match="a run that failed cannot be resumed"):
        galvi.resume(run, 1)


@pytest.mark.parametrize("make_problem", FUNCTION_OF_PROBLEM)
@pytest.mark.parametrize("interrupt", ["raised", "pressed"])
@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_during_an_assessment_raises_with_the_run_which_can_be_asked_again(
    make_problem, interrupt
):
    action = raising(KeyboardInterrupt()) if interrupt == "raised" else press
    before, total, undisturbed = counted_calls(make_problem)
    for call_number in sorted({before + 1, (before + total) // 2, total}):
        problem, planted = planted_problem(make_problem, action, call_number)
        with pytest.raises(Interrupted) as caught:
            galvi.integrate(problem, FOUR, 0.1, STEPS)
        run = caught.value.run
        assert planted.calls == call_number  # the assessment ends at once
        assert np.array_equal(run.q, undisturbed.q) and np.array_equal(run.p, undisturbed.p)
        planted.at = None
        assert run.status == "Completed." and galvi.resume(run, 3).success
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.parametrize("last", [True, False])
@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_at_the_last_step_or_at_one_that_fails_raises_with_the_run(last):
    evaluations_beyond = []

    def gradient(q):
        if abs(q[0]) > 5.0:
            if not evaluations_beyond:
                press()
            evaluations_beyond.append(True)
            return q if last else q * np.nan
        return -q

    system = galvi.Canonical(1.0, spring, gradient, check=False)
    problem = galvi.Problem(system, [1.0], [0.0])
    free = galvi.integrate(
        replace(problem, system=galvi.Canonical(1.0, spring, opaque(lambda q: -q), check=False)),
        FOUR,
        0.1,
        40,
    )
    steps = int(np.flatnonzero(free.q[:, 0] > 5.0)[0])
    with pytest.raises(Interrupted) as caught:
        galvi.integrate(problem, FOUR, 0.1, steps)
    run = caught.value.run
    assert np.array_equal(run.q[: steps - 1], free.q[: steps - 1])
    assert run.counts["steps"] == (steps if last else steps - 1)
    assert np.isfinite(run.q[-1, 0]) == last


def press():
    """Raises SIGINT, as Ctrl-C does."""
    signal.raise_signal(signal.SIGINT)


@pytest.mark.usefixtures("interruptible")
def test_ctrl_c_that_nobody_asked_about_is_raised_at_the_end():
    with pytest.raises(KeyboardInterrupt), defer_interrupts():
        press()
    with defer_interrupts() as pressed:
        press()
        assert pressed()
    with pytest.raises(KeyboardInterrupt), defer_interrupts() as pressed:
        assert not pressed()
        press()
    with pytest.raises(KeyboardInterrupt), defer_interrupts():
        press()
        press()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.usefixtures("interruptible")
def test_finished_runs_of_an_ensemble_survive_ctrl_c():
    """Ctrl-C is pressed during the last gradient evaluation of the last step."""
    planted = Planted(lambda q: q.copy(), lambda: None)
    system = galvi.Canonical(1.0, spring, opaque(planted), check=False)
    problem = galvi.Problem(system, [1.0], [0.0])
    uninterrupted = galvi.integrate_many([problem, problem], FOUR, 0.1, 3)
    calls_of_first = planted.calls
    galvi.integrate_many([problem, problem], FOUR, 0.1, 3)
    calls_per_ensemble = planted.calls - calls_of_first
    planted.at, planted.action = planted.calls + calls_per_ensemble, press
    with pytest.raises(Interrupted) as caught:
        galvi.integrate_many([problem, problem], FOUR, 0.1, 3)
    assert planted.calls == planted.at
    for run, expected in zip(caught.value.run, uninterrupted, strict=True):
        assert np.array_equal(run.q, expected.q) and run.status == "Completed."


@pytest.mark.parametrize(
    "potential",
    [
        galvi.CentralForce(2.0),
        galvi.CosinePotential(1.5),
        galvi.LinearSpring(3.0),
        galvi.SpringChain(0.3, 0.2),
        galvi.UniformField([1.0, 2.0, 3.0]),
        galvi.UniformGravity(2.0, [0.1, 0.2, 0.3]),
    ],
    ids=lambda potential: type(potential).__name__,
)
def test_potential_energies_of_a_batch_equal_those_of_single_states(potential):
    shape = (3, 3) if isinstance(potential, galvi.UniformGravity) else (3,)
    states = np.random.default_rng(0).normal(size=(7, *shape))
    states[3] = np.nan
    body = galvi.RigidBody([1.0, 2.0, 2.5], potential)
    system = body if len(shape) == 2 else galvi.Canonical(1.0, potential)
    energies = system.potential_energy(states, np.zeros(7))
    expected = [potential(q) if np.isfinite(q).all() else np.nan for q in states]
    assert np.allclose(energies, expected, rtol=1e-14, atol=1e-14, equal_nan=True)

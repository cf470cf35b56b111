"""In a clock with forces the energy is assessed against that which the clock integrates along."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.outcome import End
from galvi.run.clocked.stepper import ClockStepper

KEPLER = galvi.problems.kepler(0.3)
NEAR_ORIGIN = galvi.Clock(lambda q: 1.0 / (1.0 + q @ q), lambda q: -2.0 * q / (1.0 + q @ q) ** 2)


def gauss(points, clock):
    """Gauss collocation with ``points`` stages in a clock."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), clock=clock)


def drag(q, v):
    return -0.05 * v


def pull(gradient_factor=1.0):
    """V = |q|^4 / 4 with drag, and a gradient that is ``gradient_factor`` times the right one."""
    return galvi.Canonical(
        1.0,
        lambda q: 0.25 * (q @ q) ** 2,
        lambda q: gradient_factor * (q @ q) * q,
        force=drag,
        check=False,
    )


def swing(gradient_factor=1.0):
    """A spring driven in time, and a gradient that is ``gradient_factor`` times the right one."""
    return galvi.Canonical(
        1.0,
        lambda q, t: 0.5 * (q @ q) - np.cos(t) * q[0],
        lambda q, t: gradient_factor * (q - np.cos(t) * np.array([1.0, 0.0])),
        explicit_time=True,
        check=False,
    )


def problem_of(system):
    return galvi.Problem(system, [1.0, 0.5], [0.3, 0.4])


RIGHT = {
    "Kepler with drag": (
        galvi.Problem(
            galvi.Canonical(1.0, galvi.CentralForce(1.0), force=drag), KEPLER.q0, KEPLER.v0
        ),
        galvi.Sundman(),
    ),
    "bodies with drag": (
        galvi.Problem(
            galvi.NBody([1.0, 1e-3], forces=galvi.Drag([0, 1e-3])),
            [[0.0, 0.0], [1.0, 0.1]],
            [[0.0, 0.0], [0.1, 0.95]],
        ),
        galvi.DynamicalTime(),
    ),
    "drag": (problem_of(pull()), NEAR_ORIGIN),
    "driven": (problem_of(swing()), NEAR_ORIGIN),
    "pushed from rest": (
        galvi.Problem(
            galvi.Canonical(1.0, lambda q: 0.0 * q[0], force=lambda q, v: np.array([1.0, 0.1])),
            [1.0, 0.5],
            [0.0, 0.0],
        ),
        NEAR_ORIGIN,
    ),
}


@pytest.mark.slow_cases(but=["drag"])
@pytest.mark.parametrize("name", RIGHT)
def test_right_runs_are_called_good_and_have_an_energy(name):
    """Measured: errors up to 3e-3 of the energy's measure with degree 2, 2e-4 with degree 3."""
    problem, clock = RIGHT[name]
    run = galvi.integrate(problem, gauss(4, clock), 1.0, 6)
    assert run.status == "Completed." and run.checkpoint.energies.size == 4


@pytest.mark.parametrize(("make_system", "gradient_factor"), [(pull, 1.03), (swing, 1.03)])
def test_a_wrong_gradient_is_found(make_system, gradient_factor):
    """A gradient 3 % too large is named, and one of the wrong sign ruins the run."""
    doubtful = galvi.integrate(
        problem_of(make_system(gradient_factor)), gauss(4, NEAR_ORIGIN), 0.3, 20
    )
    assert doubtful.outcome.end is End.DOUBTFUL
    assert "the energy and the work of the forces differ by 0.0" in doubtful.outcome.reason
    ruined = galvi.integrate(problem_of(make_system(-1.0)), gauss(4, NEAR_ORIGIN), 0.3, 10)
    assert ruined.outcome.end is End.RUINED
    assert ruined.failed_step <= 3 and np.all(np.isfinite(ruined.q))


@pytest.mark.parametrize("size", [0.0, 0.02, 1.5])
def test_one_ruined_state_is_seen_wherever_it_is(size, monkeypatch):
    """Planted: from step 5 of 8 on the clock's energy is off by ``size`` times T at the start."""
    record = ClockStepper._record

    def shifted(loop, steps, keep):
        numbers = loop.steps_done + 1 + np.arange(len(steps.t))
        off = size * 0.5 * (KEPLER.v0 @ KEPLER.v0) * (numbers >= 5)
        record(loop, steps._replace(energy=steps.energy + off), keep)

    monkeypatch.setattr(ClockStepper, "_record", shifted)
    problem, clock = RIGHT["Kepler with drag"]
    run = galvi.integrate(problem, gauss(4, clock), 0.2, 8)
    if size == 0.0:
        assert run.status == "Completed."
    else:
        assert f"differ by {size:.2g} times the largest energy" in run.outcome.reason
        assert run.outcome.end is (End.DOUBTFUL if size < 1.0 else End.RUINED)
        assert run.failed_step == (None if size < 1.0 else 5)


@pytest.mark.parametrize(("step", "ruined_step"), [(1.0, None), (2.0, 3)])
def test_a_step_that_is_too_large_is_named(step, ruined_step):
    """The energy is off by 0.05 and by 1.1 times its measure."""
    run = galvi.integrate(problem_of(pull()), gauss(1, NEAR_ORIGIN), step, 6)
    assert "the energy and the work of the forces differ by" in run.outcome.reason
    assert run.failed_step == ruined_step


def test_a_resumed_run_is_assessed_as_one_long_run():
    problem = problem_of(pull(1.1))
    long, part = (galvi.integrate(problem, gauss(3, NEAR_ORIGIN), 0.3, steps) for steps in (12, 7))
    resumed = galvi.resume(part, 5)
    assert np.array_equal(resumed.checkpoint.energies, long.checkpoint.energies)
    assert resumed.status == long.status


def pull_up_to(radius):
    """`pull` with a gradient of the wrong sign, which is NaN from ``radius`` on."""

    def gradient(q):
        return -(q @ q) * q if q @ q < radius * radius else np.full(2, np.nan)

    system = galvi.Canonical(1.0, lambda q: 0.25 * (q @ q) ** 2, gradient, force=drag, check=False)
    return problem_of(system)


@pytest.mark.parametrize("end", [End.STEP_LIMIT, End.STEP_FAILED])
def test_a_run_that_stops_early_says_that_it_was_ruined_before(end):
    """It stops at the limit of its steps, and at a step that fails."""
    ruined = galvi.integrate(problem_of(pull(-1.0)), gauss(4, NEAR_ORIGIN), 0.3, 10)
    assert ruined.outcome.end is End.RUINED
    if end is End.STEP_LIMIT:
        run = galvi.integrate(problem_of(pull(-1.0)), gauss(4, NEAR_ORIGIN), 0.3, 10, duration=1e3)
    else:
        radius = float(np.max(np.linalg.norm(ruined.q, axis=1)))
        run = galvi.integrate(pull_up_to(radius), gauss(4, NEAR_ORIGIN), 0.3, 20)
    assert run.outcome.end is end
    t = ruined.t[ruined.failed_step]
    assert f"It was ruined from t = {t:.10g} on: the energy and the work" in run.status


def test_what_a_lagrangian_raises_after_the_run_is_said():
    """L raises at the end of the last step, where no step evaluates it."""
    end: list[float] = []

    def checked(q):
        if end and abs(q[0] - end[0]) < 1e-12:
            raise RuntimeError("out of the table")
        return q

    def L(q, v):
        return 0.5 * (v @ v) - 0.5 * (checked(q) @ q)

    def slopes(q, v):
        return np.concatenate([v, -checked(q)])

    spring = problem_of(galvi.Lagrangian(L, galvi.Rn(2), slopes))
    right = galvi.integrate(spring, gauss(3, NEAR_ORIGIN), 0.3, 5)
    assert right.status == "Completed."
    end.append(float(right.q[-1, 0]))
    run = galvi.integrate(spring, gauss(3, NEAR_ORIGIN), 0.3, 5)
    assert run.outcome.end is End.DOUBTFUL and np.max(np.abs(run.q - right.q)) < 1e-14
    assert "could not be assessed at t = " in run.status and "out of the table" in run.status

"""In a clock with forces the energy is assessed against that which the clock integrates along."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.outcome import End
from galvi.run.clocked.stepper import ClockStepper

KEPLER = galvi.problems.kepler(0.3)
NEAR = galvi.Clock(lambda q: 1.0 / (1.0 + q @ q), lambda q: -2.0 * q / (1.0 + q @ q) ** 2)


def gauss(points, clock):
    """Collocation in a clock."""
    return galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points), clock=clock)


def drag(q, v):
    return -0.05 * v


def pull(slope=1.0):
    """V = |q|^4 / 4 with drag, and ``slope`` times its gradient."""
    return galvi.Canonical(
        1.0, lambda q: 0.25 * (q @ q) ** 2, lambda q: slope * (q @ q) * q, force=drag, check=False
    )


def swing(slope=1.0):
    """A spring that a field drives in time, and ``slope`` times its gradient."""
    return galvi.Canonical(
        1.0,
        lambda q, t: 0.5 * (q @ q) - np.cos(t) * q[0],
        lambda q, t: slope * (q - np.cos(t) * np.array([1.0, 0.0])),
        explicit_time=True,
        check=False,
    )


def started(system):
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
    "drag": (started(pull()), NEAR),
    "driven": (started(swing()), NEAR),
    "pushed from rest": (
        galvi.Problem(
            galvi.Canonical(1.0, lambda q: 0.0 * q[0], force=lambda q, v: np.array([1.0, 0.1])),
            [1.0, 0.5],
            [0.0, 0.0],
        ),
        NEAR,
    ),
}


@pytest.mark.slow_cases(but=["drag"])
@pytest.mark.parametrize("name", RIGHT)
def test_right_runs_are_called_good_and_have_an_energy(name):
    """Errors were up to 3e-3 of their measure with degree 2, 2e-4 with degree 3."""
    problem, clock = RIGHT[name]
    run = galvi.integrate(problem, gauss(4, clock), 1.0, 6)
    assert run.status == "Completed." and run.checkpoint.energies.size == 4


@pytest.mark.parametrize(("make_system", "slope"), [(pull, 1.03), (swing, 1.03)])
def test_a_wrong_gradient_is_found(make_system, slope):
    """An error of 2 to 5 % of the energy is named, and that of a wrong sign ruins the run."""
    off = galvi.integrate(started(make_system(slope)), gauss(4, NEAR), 0.3, 20)
    assert off.outcome.end is End.DOUBTFUL
    assert "the energy and the work of the forces differ by 0.0" in off.outcome.reason
    lost = galvi.integrate(started(make_system(-1.0)), gauss(4, NEAR), 0.3, 10)
    assert lost.outcome.end is End.RUINED
    assert lost.failed_step <= 3 and np.all(np.isfinite(lost.q))


@pytest.mark.parametrize("size", [0.0, 0.02, 1.5])
def test_one_ruined_state_is_seen_wherever_it_is(size, monkeypatch):
    """Planted: from step 5 of 8 on the clock's energy is off by a share of T at the start."""
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


@pytest.mark.parametrize(("step", "ruined"), [(1.0, None), (2.0, 3)])
def test_a_step_that_is_too_large_is_named(step, ruined):
    """The energy is off by 0.05 and 1.1 of its measure."""
    run = galvi.integrate(started(pull()), gauss(1, NEAR), step, 6)
    assert "the energy and the work of the forces differ by" in run.outcome.reason
    assert run.failed_step == ruined


def test_a_resumed_run_is_assessed_as_one_long_run():
    problem = started(pull(1.1))
    long, part = (galvi.integrate(problem, gauss(3, NEAR), 0.3, steps) for steps in (12, 7))
    resumed = galvi.resume(part, 5)
    assert np.array_equal(resumed.checkpoint.energies, long.checkpoint.energies)
    assert resumed.status == long.status


def pull_up_to(radius):
    """`pull` with a gradient of the wrong sign, which is not a number from a distance on."""

    def gradient(q):
        return -(q @ q) * q if q @ q < radius * radius else np.full(2, np.nan)

    system = galvi.Canonical(1.0, lambda q: 0.25 * (q @ q) ** 2, gradient, force=drag, check=False)
    return started(system)


@pytest.mark.parametrize("end", [End.STEP_LIMIT, End.STEP_FAILED])
def test_a_run_that_stops_early_says_that_it_was_ruined_before(end):
    """By the bound of its steps before a time, and by a step that fails."""
    lost = galvi.integrate(started(pull(-1.0)), gauss(4, NEAR), 0.3, 10)
    assert lost.outcome.end is End.RUINED
    if end is End.STEP_LIMIT:
        run = galvi.integrate(started(pull(-1.0)), gauss(4, NEAR), 0.3, 10, duration=1e3)
    else:
        radius = float(np.max(np.linalg.norm(lost.q, axis=1)))
        run = galvi.integrate(pull_up_to(radius), gauss(4, NEAR), 0.3, 20)
    assert run.outcome.end is end
    t = lost.t[lost.failed_step]
    assert f"It was ruined from t = {t:.10g} on: the energy and the work" in run.status


def test_what_a_lagrangian_raises_after_the_run_is_said():
    """At the end of the last step alone, where no step asks for L."""
    end: list[float] = []

    def checked(q):
        if end and abs(q[0] - end[0]) < 1e-12:
            raise RuntimeError("out of the table")
        return q

    def L(q, v):
        return 0.5 * (v @ v) - 0.5 * (checked(q) @ q)

    def slopes(q, v):
        return np.concatenate([v, -checked(q)])

    spring = started(galvi.Lagrangian(L, galvi.Rn(2), slopes))
    right = galvi.integrate(spring, gauss(3, NEAR), 0.3, 5)
    assert right.status == "Completed."
    end.append(float(right.q[-1, 0]))
    run = galvi.integrate(spring, gauss(3, NEAR), 0.3, 5)
    assert run.outcome.end is End.DOUBTFUL and np.max(np.abs(run.q - right.q)) < 1e-14
    assert "could not be assessed at t = " in run.status and "out of the table" in run.status

"""A step that is too large for a body without mass is said to be, and others are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.run import loop
from galvi.run.point_masses import massless
from galvi.trajectory import COMPLETED

PERIOD = 2.0 * np.pi * 2.0**1.5
FRAME = galvi.KeplerFrame()


def comet(e: float) -> galvi.Problem:
    """A star, a planet at 5.2 and a body without mass of semi-major axis 2, at pericentre."""
    q = np.zeros((3, 3))
    v = np.zeros((3, 3))
    q[1, 0], v[1, 1] = 5.2, np.sqrt(1.001 / 5.2)
    q[2, 1], v[2, 0] = -2.0 * (1.0 - e), np.sqrt((1.0 + e) / (1.0 - e) / 2.0)
    return galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0]), q, v)


def method(degree: int, chart: object = None) -> galvi.Galerkin:
    options = {} if chart is None else {"chart": chart}
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), **options)


def watched(monkeypatch: pytest.MonkeyPatch) -> list[massless.MasslessError]:
    """The estimates of the runs that follow."""
    seen: list[massless.MasslessError] = []
    estimate = loop.massless_error

    def noted(*arguments):  # type: ignore[no-untyped-def]
        seen.append(estimate(*arguments))
        return seen[-1]

    monkeypatch.setattr(loop, "massless_error", noted)
    return seen


def binary() -> galvi.Problem:
    """Two equal stars, 3 apart, and a body without mass at half a unit from one of them."""
    q, v = np.zeros((3, 3)), np.zeros((3, 3))
    q[1, 0], v[1, 1] = 3.0, np.sqrt(2.0 / 3.0)
    q[2, 1], v[2, 0] = -0.5, np.sqrt(2.0)
    return galvi.Problem(galvi.NBody([1.0, 1.0, 0.0]), q, v)


@pytest.mark.parametrize("steps", [1, 50, 70_000])
def test_a_step_too_large_for_a_planet_of_a_binary_is_said_to_be(steps: int) -> None:
    """The stars are right to round-off, and so is the energy of the whole."""
    run = galvi.integrate(binary(), method(2, FRAME), 1.0, steps, save_every=steps)
    if steps < 100:
        exact = galvi.integrate(binary(), method(12), 1.0 / 64, 64 * steps, curves=False)
        off = np.linalg.norm(run.q[-1] - exact.q[-1], axis=1)
        assert off[2] > 3e-3 and np.max(off[:2]) < 1e-14
    looked_at = 1 if steps < 100 else 3
    assert run.success and f"an estimate, from {looked_at} of the steps" in run.status, run.status
    assert "a step changes the energy of the massless body 2 by about 0.0" in run.status
    assert "Use a smaller step or a higher degree" in run.status


@pytest.mark.parametrize("chart", [None, FRAME], ids=["inertial", "frame"])
@pytest.mark.parametrize(
    "e, degree, a_turn", [(0.2, 2, 20), (0.2, 6, 4), (0.6, 4, 50), (0.6, 8, 20)]
)
def test_there_is_no_false_alarm(chart, e, degree, a_turn, monkeypatch) -> None:
    seen = watched(monkeypatch)
    run = galvi.integrate(comet(e), method(degree, chart), PERIOD / a_turn, 20 * a_turn)
    assert run.status == COMPLETED
    assert len(seen) == 1 and seen[0].share < massless.COARSE


@pytest.mark.parametrize("solver", ["auto", "newton"])
def test_the_estimate_is_the_energy_that_the_last_step_changes(solver, monkeypatch) -> None:
    """Against the same step in 64 parts."""
    seen, step, coarse = watched(monkeypatch), PERIOD / 12, method(2)
    before = galvi.integrate(comet(0.2), coarse, step, 99, solver=solver)
    run = galvi.integrate(comet(0.2), coarse, step, 100, solver=solver)
    there = galvi.Problem(run.problem.system, before.q[-1], before.v[-1])
    fine = galvi.integrate(there, coarse, step / 64, 64)

    def energy(state: galvi.Trajectory) -> float:
        q, v = state.q[-1], state.v[-1]
        return 0.5 * np.sum((v[2] - v[0]) ** 2) - 1.0 / np.linalg.norm(q[2] - q[0])

    assert before.success and run.success
    true = abs(energy(run) - energy(fine)) / (2.0 * abs(energy(fine)))
    assert 0.3 * true < seen[1].share < 10.0 * true and seen[1].states == 1


def test_a_step_that_was_not_taken_is_not_judged() -> None:
    """From apocentre almost to pericentre, where steps of this length would be too large."""
    q, v = np.array([[0.0, 0.0], [1.9, 0.0]]), np.array([[0.0, 0.0], [0.0, np.sqrt(0.1 / 1.9)]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.0]), q, v)
    run = galvi.integrate(problem, method(8), 0.2, 15)
    fine = galvi.integrate(problem, method(8), 0.01, 300)
    assert np.max(np.abs(run.q[-1] - fine.q[-1])) < 1e-10 and run.status == COMPLETED


def test_a_fast_passage_is_measured_by_its_kinetic_energy() -> None:
    q, v = np.array([[0.0, 0.0], [-26.4, 0.5]]), np.array([[0.0, 0.0], [1000.0, 0.0]])
    problem = galvi.Problem(galvi.NBody([1.0, 0.0]), q, v)
    run = galvi.integrate(problem, method(2), 0.008, 6)
    assert "massless body" not in run.status


def test_ctrl_c_in_the_estimate_keeps_the_run(monkeypatch) -> None:
    def pressed(*arguments):  # type: ignore[no-untyped-def]
        raise KeyboardInterrupt

    monkeypatch.setattr(loop, "massless_error", pressed)
    run = galvi.integrate(comet(0.2), method(6), 0.1, 100)
    with pytest.raises(KeyboardInterrupt):
        print(run.success)
    monkeypatch.undo()
    assert run.success and run.t[-1] == 10.0


def test_a_body_that_a_kernel_moves_wrongly_is_named(monkeypatch) -> None:
    """Planted: whole steps are 1e-2 too fast for one of three bodies without mass."""
    problem = comet(0.2)
    q, v = (np.vstack([x, 1.2 * x[2], 1.5 * x[2]]) for x in (problem.q0, problem.v0))
    problem = galvi.Problem(galvi.NBody([1.0, 1e-3, 0.0, 0.0, 0.0]), q, v / 1.3)
    estimate = loop.massless_error

    def planted(steps_from, states):  # type: ignore[no-untyped-def]
        def wrong(state, n):  # type: ignore[no-untyped-def]
            run = steps_from(state, n)
            if n == 1:
                v = run.v.copy()
                v[:, 3] *= 1.01
                run = replace(run, velocities=v)
            return run

        return estimate(wrong, states)

    sound = galvi.integrate(problem, method(6), 0.1, 100)
    assert sound.status == COMPLETED
    monkeypatch.setattr(loop, "massless_error", planted)
    run = galvi.integrate(problem, method(6), 0.1, 100)
    assert "massless body 3 by about 0.0" in run.status


def test_bodies_with_a_mass_alone_are_not_looked_at(monkeypatch) -> None:
    seen = watched(monkeypatch)
    run = galvi.integrate(galvi.problems.outer_solar_system(), method(6), 200.0, 20)
    assert run.success and not seen

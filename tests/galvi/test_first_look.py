"""The compiled first look at a run's energy says what the full judgement says, or nothing."""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from galvi.run import energy_check

MASS = np.array([[2.0, 0.3], [0.3, 1.0]])


def double(q, v):
    """A Lagrangian whose mass depends on the place."""
    return v[0] ** 2 + 0.5 * v[1] ** 2 + v[0] * v[1] * np.cos(q[0] - q[1]) + 3.0 * np.cos(q[0])


PROBLEMS = {
    "point masses, one massless": galvi.Problem(
        galvi.NBody([1.0, 1e-3, 0.0]),
        [[0.0, 0.0], [1.0, 0.0], [0.0, 1.7]], [[0.0, 0.0], [0.0, 1.0], [-0.8, 0.0]],
    ),
    "unit mass": galvi.problems.kepler(0.3),
    "coupled mass": galvi.Problem(
        galvi.Canonical(MASS, galvi.LinearSpring()), [1.0, 0.2], [0.0, 0.4]
    ),
    "its potential in Python": galvi.Problem(
        galvi.Canonical([1.0, 2.0], lambda q: 0.5 * q @ q), [1.0, 0.2], [0.0, 0.4]
    ),
    "rigid body": galvi.problems.pendulum_3d(),
    "chain": galvi.problems.double_pendulum(),
    "traced": galvi.Problem(galvi.Lagrangian(double, galvi.Rn(2)), [1.0, 0.5], [0.1, 0.0]),
}  # fmt: skip


def looks(monkeypatch, name, points=5, step=0.02):
    """What the first look and the full judgement find of one run, and its status."""
    found = []

    def both(engine, problem, method, seen, *known):
        found.append(first(engine, problem, method, seen, *known))

    def full(*arguments):
        found.append(judged(*arguments))
        return found[-1]

    with monkeypatch.context() as patch:
        first, judged = energy_check._first_look, energy_check._judged
        patch.setattr(energy_check, "_first_look", both)
        patch.setattr(energy_check, "_judged", full)
        method = galvi.Galerkin(galvi.Polynomials(points), galvi.gauss(points))
        run = galvi.integrate(PROBLEMS[name], method, step, 100)
    return *found, run.status


@pytest.mark.parametrize("name", PROBLEMS)
def test_it_agrees_with_the_full_judgement(monkeypatch, name):
    quick, full, status = looks(monkeypatch, name)
    assert status == "Completed." and quick is not None
    assert quick.error == pytest.approx(full.error, abs=1e-12)
    np.testing.assert_allclose(quick.energies, full.energies, rtol=1e-12, atol=1e-12)


@pytest.mark.parametrize("name", PROBLEMS)
def test_it_leaves_what_is_doubtful_to_the_full_judgement(monkeypatch, name):
    """A kinetic energy, or values, that are wrong by 2 %."""
    form, near = energy_check.kinetic_form, energy_check.at_near_velocities
    monkeypatch.setattr(energy_check, "kinetic_form", lambda *given: 1.02 * form(*given))
    monkeypatch.setattr(
        energy_check, "at_near_velocities",
        lambda *given: (lambda p, value, V: (p, 1.02 * value + 0.1, V))(*near(*given)),
    )  # fmt: skip
    quick, full, status = looks(monkeypatch, name)
    assert quick is None and full.error < 1e-3 and status == "Completed."

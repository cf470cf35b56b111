"""Ensembles of trees whose members differ in gravity, masses, damping, stiffness and armature."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.systems.multibody import OF_JOINTS
from galvi.systems.trees.joint import JointDamping
from galvi.tracing import laws_of_systems

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
HINGES = [galvi.Joint("hinge", axis=(0, 1, 0)), galvi.Joint("hinge", axis=(1, 0, 0))]
ARM = galvi.Multibody(
    [
        galvi.Link(HINGES, 1.0, (0.1, 0, -0.5), (0.1, 0.2, 0.15)),
        galvi.Link(
            galvi.Joint("hinge", axis=(0, 1, 0), armature=0.01),
            0.5,
            (0, 0, -0.3),
            (0.05,) * 3,
            parent=0,
            place=(0, 0, -1),
        ),
    ]
)
BALL = galvi.Multibody([galvi.Link(galvi.Joint("ball"), 1.0, (0, 0, -0.5), (0.2, 0.3, 0.4))])
STARTS = {
    "hinges": galvi.Problem(ARM, [0.7, 0.3, -0.4], [0.1, 0.0, 0.5]),
    "a ball": galvi.Problem(BALL, np.eye(3), [0.3, 0.2, 0.1]),
}


def ends(problem: galvi.Problem, parameters: dict[str, np.ndarray]) -> np.ndarray:
    n = len(next(iter(parameters.values())))
    q, v = (np.repeat(x[None], n, axis=0) for x in (problem.q0, problem.v0))
    ensemble = galvi.integrate_ensemble(problem, q, v, EIGHT, 0.02, 20, parameters=parameters)
    assert set(ensemble.status) == {"Completed."}
    separate_arrays = (
        problem.q0.shape != problem.v0.shape
    )  # then the ensemble keeps q and p in arrays of their own
    return np.asarray(ensemble[0] if separate_arrays else np.asarray(ensemble)[:, 0]).reshape(n, -1)


def largest_error(problem: galvi.Problem, parameters: dict[str, np.ndarray]) -> float:
    """The largest difference between the end of a member and that of a single run of its tree."""
    worst = 0.0
    for k, end in enumerate(ends(problem, parameters)):
        system = problem.system.with_numbers(**{name: x[k] for name, x in parameters.items()})
        run = galvi.integrate(galvi.Problem(system, problem.q0, problem.v0), EIGHT, 0.02, 20)
        worst = max(worst, float(np.abs(run.q[-1].ravel() - end).max()))
    return worst


@pytest.mark.slow(beside="test_earth_and_moon")
@pytest.mark.parametrize("name_of_start", STARTS)
def test_members_are_trees_with_their_numbers(name_of_start: str) -> None:
    """Three members, some of whose numbers are 0, except the masses."""
    problem, random = STARTS[name_of_start], np.random.default_rng(3)
    system, parameters = problem.system, {}
    for name in system.varied_names:
        parameters[name] = random.uniform(0.2, 2.0, (3, *system.shape_of(name)))
        if name != "masses":
            parameters[name][random.random(parameters[name].shape) < 0.4] = 0.0
    assert largest_error(problem, parameters) < 1e-12
    assert largest_error(problem, {"masses": parameters["masses"]}) < 1e-12


def test_earth_and_moon() -> None:
    """A pendulum of 1 m from a small angle: its periods are in proportion to 1 / sqrt(g)."""
    bob = galvi.Link(galvi.Joint("hinge", axis=(0, 1, 0)), 1.0, (0, 0, -1), (1e-9,) * 3)
    problem = galvi.Problem(galvi.Multibody([bob]), [1e-4], [0.0])
    angles_at_end = ends(problem, {"gravity": np.array([[0, 0, -9.81], [0, 0, -1.62]])})
    angles = 1e-4 * np.cos(np.sqrt([9.81, 1.62]) * 0.4)
    assert angles_at_end[:, 0] == pytest.approx(angles, rel=1e-7)


@pytest.mark.slow(
    beside="test_joint_forces.py::test_a_planted_drive_that_keeps_its_slope_is_caught"
)
def test_a_parameter_that_is_left_out_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: damping whose law has only the terms that the first member needs."""
    parameters = {"damping": np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.5]])}
    assert largest_error(STARTS["hinges"], parameters) < 1e-13
    lines = "def force(q, v, t, c):\n    return [0.0 * c[0], 0.0 * c[1], 0.0 * c[2]]\n"
    lines_of = laws_of_systems.lines_of
    monkeypatch.setattr(
        laws_of_systems,
        "lines_of",
        lambda law: lines if isinstance(law, JointDamping) else lines_of(law),
    )
    with pytest.raises(AssertionError):
        assert np.ptp(ends(STARTS["hinges"], parameters), axis=0).max() > 1e-3


def test_a_tree_with_other_numbers_is_a_value() -> None:
    numbers = {name: np.array([0.5, 0.0, 0.7]) + k for k, name in enumerate(OF_JOINTS)}
    moon = ARM.with_numbers(gravity=[0, 0, -1.62], masses=[2.0, 1.0], **numbers)
    assert list(moon.gravity) == [0, 0, -1.62] and [x.mass for x in moon.links] == [2.0, 1.0]
    for name, values in numbers.items():
        assert [getattr(joint, name) for joint in moon.tree.joints] == list(values)
    assert np.array_equal(moon.links[0].inertia, ARM.links[0].inertia)
    assert list(replace(ARM, gravity=(0, 0, -1.62)).gravity) == [0, 0, -1.62]
    with pytest.raises(ValueError, match="name must be one of gravity, masses"):
        ARM.with_numbers(length=[1.0])
    with pytest.raises(ValueError, match=r"armature must have shape \(3,\)"):
        ARM.with_numbers(armature=[1.0])

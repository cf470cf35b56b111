"""Members of a tree with other gravity, masses, damping, stiffness and armature."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from galvi.systems.multibody import OF_JOINTS, VARIED
from galvi.systems.trees.joint import JointDamping
from galvi.tracing import laws_of_systems

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
HINGES = [galvi.Joint("hinge", axis=(0, 1, 0)), galvi.Joint("hinge", axis=(1, 0, 0))]
ARM = galvi.Multibody([
    galvi.Link(HINGES, 1.0, (0.1, 0, -0.5), (0.1, 0.2, 0.15)),
    galvi.Link(galvi.Joint("hinge", axis=(0, 1, 0), armature=0.01), 0.5, (0, 0, -0.3), (0.05,) * 3,
               parent=0, place=(0, 0, -1)),
])  # fmt: skip
START = galvi.Problem(ARM, [0.7, 0.3, -0.4], [0.1, 0.0, 0.5])
SIZES = {"gravity": 3, "masses": 2, "damping": 3, "stiffness": 3, "armature": 3}


def by_hand(problem: galvi.Problem, numbers: dict[str, np.ndarray]) -> galvi.Problem:
    """The problem with the numbers written into its links and joints."""
    system, at, links = problem.system, 0, []
    for k, link in enumerate(system.links):
        joints = []
        for joint in link.joints:
            own = {name: numbers[name][at] for name in OF_JOINTS if name in numbers}
            joints.append(replace(joint, **own))
            at += 1
        mass = numbers["masses"][k] if "masses" in numbers else link.mass
        links.append(replace(link, joints=joints, mass=mass))
    system = galvi.Multibody(links, numbers.get("gravity", system.gravity))
    return galvi.Problem(system, problem.q0, problem.v0)


def ends(problem: galvi.Problem, parameters: dict[str, np.ndarray], **more: Any) -> np.ndarray:
    n = len(next(iter(parameters.values())))
    q, v = (np.repeat(x[None], n, axis=0) for x in (problem.q0, problem.v0))
    found = galvi.integrate_ensemble(problem, q, v, EIGHT, 0.02, 20, parameters=parameters, **more)
    assert set(found.status) == {"Completed."}
    several = problem.q0.shape != problem.v0.shape  # then q and p are apart
    return np.asarray(found[0] if several else np.asarray(found)[:, 0]).reshape(n, -1)


def off(problem: galvi.Problem, parameters: dict[str, np.ndarray], **more: Any) -> float:
    """The largest distance of a member's end from that of the tree by itself."""
    every, worst = ends(problem, parameters, **more), 0.0
    for k, end in enumerate(every):
        own = by_hand(problem, {name: values[k] for name, values in parameters.items()})
        run = galvi.integrate(own, EIGHT, 0.02, 20)
        worst = max(worst, float(np.abs(run.q[-1].ravel() - end).max()))
    return worst


def drawn(names: tuple[str, ...], seed: int, sizes: dict[str, int] = SIZES) -> dict[str, Any]:
    """Values of three members, some of them 0; masses above it."""
    random = np.random.default_rng(seed)
    found = {name: random.uniform(0.2, 2.0, (3, sizes[name])) for name in names}
    for name, values in found.items():
        if name != "masses":
            values[random.random(values.shape) < 0.4] = 0.0
    return found


@pytest.mark.slow(beside="test_earth_and_moon")
@settings(max_examples=10)
@given(st.sampled_from([("masses",), VARIED[:-1]]), st.integers(0, 99))  # no actuators
def test_members_are_trees_with_their_numbers(names: tuple[str, ...], seed: int) -> None:
    assert off(START, drawn(names, seed)) < 1e-13  # 5e-16


@pytest.mark.slow(beside="test_earth_and_moon")
def test_members_with_a_ball_joint_are_so_too() -> None:
    body = galvi.Link(galvi.Joint("ball"), 1.0, (0, 0, -0.5), (0.2, 0.3, 0.4))
    problem = galvi.Problem(galvi.Multibody([body]), np.eye(3), [0.3, 0.2, 0.1])
    names = problem.system.varied_names
    sizes = {"gravity": 3, **dict.fromkeys(names[1:], 1)}
    assert off(problem, drawn(names, 3, sizes)) < 1e-12


def test_earth_and_moon() -> None:
    """A pendulum of 1 m from a small angle: its periods are in proportion to 1 / sqrt(g)."""
    ball = galvi.Link(galvi.Joint("hinge", axis=(0, 1, 0)), 1.0, (0, 0, -1), (1e-9,) * 3)
    problem = galvi.Problem(galvi.Multibody([ball]), [1e-4], [0.0])
    places = ends(problem, {"gravity": np.array([[0, 0, -9.81], [0, 0, -1.62]])})
    angles = 1e-4 * np.cos(np.sqrt([9.81, 1.62]) * 0.4)
    assert places[:, 0] == pytest.approx(angles, rel=1e-7)


@pytest.mark.slow(
    beside="test_ensemble_folder.py::test_parameters_with_the_names_of_starts_hide_none"
)
def test_folders_tell_numbers_apart(tmp_path: Any) -> None:
    light, heavy = ({"masses": np.full((2, 2), mass)} for mass in (1.0, 3.0))
    damped = {"damping": np.array([[0.5, 0.5, 0.5], [0.0, 0.0, 0.0]])}
    for parameters in (light, heavy, damped, light):
        found = ends(START, parameters, folder=tmp_path)
        np.testing.assert_array_equal(found, ends(START, parameters))


@pytest.mark.slow(beside="test_controls.py::test_a_planted_drive_that_keeps_its_slope_is_caught")
def test_a_parameter_that_is_left_out_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Planted: damping whose law has only the terms that the first member needs."""
    parameters = {"damping": np.array([[0.0, 0.0, 0.0], [0.5, 0.5, 0.5]])}
    assert off(START, parameters) < 1e-13
    lines = "def force(q, v, t, c):\n    return [0.0 * c[0], 0.0 * c[1], 0.0 * c[2]]\n"
    known = laws_of_systems.lines_of
    monkeypatch.setattr(
        laws_of_systems,
        "lines_of",
        lambda one: lines if isinstance(one, JointDamping) else known(one),
    )
    with pytest.raises(AssertionError):
        assert np.ptp(ends(START, parameters), axis=0).max() > 1e-3


def test_a_tree_with_other_numbers_is_a_value() -> None:
    moon = ARM.with_numbers(gravity=[0, 0, -1.62], masses=[2.0, 1.0])
    assert list(moon.gravity) == [0, 0, -1.62] and [x.mass for x in moon.links] == [2.0, 1.0]
    assert np.array_equal(moon.links[0].inertia, ARM.links[0].inertia)
    assert list(replace(ARM, gravity=(0, 0, -1.62)).gravity) == [0, 0, -1.62]
    with pytest.raises(ValueError, match="name must be one of gravity, masses"):
        ARM.with_numbers(length=[1.0])
    with pytest.raises(ValueError, match=r"armature must have shape \(3,\)"):
        ARM.with_numbers(armature=[1.0])

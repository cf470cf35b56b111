"""Judging a tree of rigid bodies: errors of its joints, of one against its closed form."""

from __future__ import annotations

import math

import numpy as np
import pytest

import galvi
from benchmarks.judging import trees
from benchmarks.judging.judgement import judge
from galvi import Problem
from references.closed_forms.pendulum import PENDULUM

pytest.importorskip("mujoco")


def swing(damping: float = 0.0, **own: object) -> Problem:
    """A ball of 1 kg at 1 m from a hinge, which swings from 2 radians; its moment is 1.01."""
    hinge = galvi.Joint("hinge", axis=(0.0, 1.0, 0.0), damping=damping)
    rod = galvi.Link(hinge, mass=1.0, centre=(0.0, 0.0, -1.0), inertia=(0.01,) * 3, name="rod")
    system = galvi.Multibody([rod])
    q, v = system.from_mujoco([2.0], [0.0])
    return Problem(system, q, v, parameters={"integrator": "RK4", "dt": 0.02, **own})


def test_the_error_of_a_pendulum_is_that_against_the_closed_form() -> None:
    found = judge(swing(), duration=10.0, error=1e-6)
    plain = galvi.Problem(galvi.Canonical(1.01, galvi.CosinePotential(9.81)), [2.0], [0.0])
    exact = PENDULUM.run(plain, found.duration, {"samples": 100})
    mine = trees.INTEGRATORS["rk4"].run(swing(), 10.0, {"step": 0.02, "save_every": 5})
    off = np.abs(mine.q - exact.q).max()
    assert found.own["error"] == pytest.approx(off, rel=1e-4)
    assert found.truth_agreement < 1e-9 and found.own["energy_error"] > 0.0
    assert list(found.parts["joint"]) == ["hinge of rod"]
    assert found.recommended is not None and found.recommended["error"] <= 1e-6
    assert {"MuJoCo RK4", "MuJoCo Euler", "galvi degree 8, Gauss 8"} <= set(
        found.table["integrator"]
    )
    assert len(found.encounters.columns) == 0


def test_a_damped_tree_has_no_energy_error() -> None:
    found = judge(swing(damping=0.1), duration=5.0, own={"integrator": "implicitfast"})
    assert math.isnan(found.own["energy_error"]) and math.isnan(found.own["momentum_error"])
    assert found.own["integrator"] == "MuJoCo implicitfast, dt = 0.02" and found.passed


def test_errors_of_balls_and_free_bodies_are_angles_and_lengths() -> None:
    links = [galvi.Link(galvi.Joint(kind), mass=1.0, inertia=(1.0, 2.0, 2.5))
             for kind in ("ball", "free")]  # fmt: skip
    system = galvi.Multibody(links)
    half = 0.15  # of an angle of 0.3 about x
    one, other = np.zeros((2, 11))
    one[[0, 7]] = 1.0
    other[:2] = math.cos(half), math.sin(half)
    other[4:7], other[7] = (0.0, 0.4, 0.0), -1.0  # the same attitude
    runs = []
    for qpos in (one, other):
        q, v = system.from_mujoco(qpos, np.zeros(9))
        runs.append(galvi.Trajectory(Problem(system, q, v), np.zeros(1), q[None], v[None]))
    assert trees.errors(*runs)[0] == pytest.approx([0.3, 0.4], rel=1e-12)
    assert trees.names(runs[0].problem) == ["ball of link 0", "free of link 1"]


def test_a_start_at_which_nothing_moves_is_refused() -> None:
    still = swing().with_initial_state(*swing().system.from_mujoco([0.0], [0.0]))
    with pytest.raises(ValueError, match="nothing moves from this start"):
        judge(still)


def test_a_run_that_fails_is_told_and_has_no_error() -> None:
    found = judge(swing(), duration=10.0, error=1e-6, own={"integrator": "rk4", "dt": 5.0})
    assert math.isnan(found.own["error"]) or found.own["error"] > 1.0
    assert not found.passed and np.isfinite(found.parts["largest_error"]).all()

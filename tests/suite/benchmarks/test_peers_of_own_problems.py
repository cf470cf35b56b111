"""Which code takes which kind of problem of one's own, and which is its truth."""

import numpy as np
import pytest

import galvi
from benchmarks.work_precision.own_problem import ADAPTIVE, FIXED
from benchmarks.work_precision.truths import TRUTHS
from references import reference
from references.mujoco.accelerations_ivp import MUJOCO_ACCELERATIONS

TEXTBOOK = {"Stormer-Verlet", "Forest-Ruth", "RK4"}
MUJOCO = {f"MuJoCo {name}" for name in ("RK4", "Euler", "implicit", "implicitfast")}
REBOUND = {
    f"REBOUND {name}"
    for name in ("WHFast", "SABA", "MERCURIUS", "TRACE", "leapfrog", "BS", "IAS15")
}


def potential(q):
    return 0.5 * np.log(0.01 + q[0] ** 2 + (q[1] / 0.9) ** 2)


def gradient(q):
    square = 0.01 + q[0] ** 2 + (q[1] / 0.9) ** 2
    return np.array([q[0] / square, q[1] / (0.81 * square)])


def of_potential(given=None, **more):
    return galvi.Problem(galvi.Canonical(1.0, potential, given, **more), [0.8, 0.1], [0.1, 0.5])


def by_hand():
    """Two rods on hinges that are askew."""
    upper = galvi.Joint("hinge", axis=(0.0, 1.0, 0.0), damping=0.1)
    lower = galvi.Joint("hinge", axis=(1.0, 0.0, 0.0))
    links = (
        galvi.Link(upper, 1.0, (0.0, 0.0, -0.3), (0.1, 0.1, 0.02)),
        galvi.Link(lower, 0.5, (0.0, 0.0, -0.2), (0.05, 0.05, 0.01), parent=0, place=(0, 0, -0.6)),
    )
    return galvi.Problem(galvi.Multibody(links), [0.7, 0.4], [0.1, 0.2])


def bodies():
    return galvi.Problem(
        galvi.NBody([1.0, 1e-3, 1e-4]),
        [[0.0, 0.0], [1.0, 0.0], [0.0, 2.0]], [[0.0, 0.0], [0.0, 1.0], [-0.7, 0.0]],
    )  # fmt: skip


# kind: a problem, the codes that take it, the name of its truth
KINDS = {
    "a potential with its gradient": (
        lambda: of_potential(gradient), {"SciPy DOP853", "heyoka, Lagrangians", *TEXTBOOK},
        "heyoka, Lagrangians, quadruple precision",
    ),
    "a potential alone": (
        of_potential, {"SciPy DOP853", "heyoka, Lagrangians", *TEXTBOOK},
        "heyoka, Lagrangians, quadruple precision",
    ),
    "a potential and friction": (
        lambda: of_potential(gradient, force=lambda q, v: -0.1 * v),
        {"SciPy DOP853", "heyoka, Lagrangians"}, "heyoka, Lagrangians, quadruple precision",
    ),
    "point masses": (
        bodies, {"SciPy DOP853", "heyoka", "REBOUND WHFast512", *REBOUND, *TEXTBOOK},
        "heyoka, quadruple precision",
    ),
    "a tree made by hand": (
        by_hand,
        {*MUJOCO, MUJOCO_ACCELERATIONS.name, "SciPy DOP853 on Pinocchio's accelerations"},
        MUJOCO_ACCELERATIONS.name,
    ),
}  # fmt: skip


@pytest.mark.parametrize("kind", KINDS)
def test_each_kind_of_problem_goes_to_the_codes_that_take_it(kind):
    make, expected, truth = KINDS[kind]
    problem = make()
    names = [*FIXED, *ADAPTIVE]
    takers = [name for name in names if reference(name).supports(problem)]
    assert set(takers) == expected and len(takers) == len(set(takers))
    assert next(name for name in TRUTHS if reference(name).supports(problem)) == truth
    assert {reference(name).fixed_step for name in FIXED} == {True}
    assert {reference(name).fixed_step for name in (*ADAPTIVE, *TRUTHS)} == {False}

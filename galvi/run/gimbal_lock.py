"""Three hinges of a body in gimbal lock, where they are nearly two."""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import place
from galvi.problem import Problem
from galvi.systems.lagrangian import CHART
from galvi.systems.multibody import Multibody

LOCKED = "three hinges of one body pass gimbal lock, where steps err whatever their size"
BALL_JOINT = "Use a ball joint in place of the hinges"
MAX_STATES = 512  # states that are examined
STEP_FRACTIONS = np.linspace(0.0, 1.0, 17)  # shares of a step


def is_locked(problem: Problem, states: Callable[[], tuple[Array, Array]], step: float) -> bool:
    """Whether three hinges of a body come nearer to gimbal lock at some of the states than the
    second one turns in a step; MOST_STATES of them are examined.

    Parameters
    ----------
    states
        () -> their configurations and momenta, (n, ...) each; called for a `Multibody` only
    """
    system = problem.system
    if not isinstance(system, Multibody) or not (hinge_triples := list(_hinge_triples(system))):
        return False
    with np.errstate(all="ignore"):
        configurations, momenta = states()
        for k in np.unique(np.linspace(0, len(configurations) - 1, MAX_STATES).astype(np.int64)):
            if np.isfinite(configurations[k]).all() and np.isfinite(momenta[k]).all():
                mass = system.tree.mass(configurations[k])
                v = np.linalg.lstsq(mass, momenta[k], rcond=None)[0]
                if _near_lock(mass, v, step, hinge_triples):
                    return True
    return False


def is_locked_ahead(problem: Problem, q: Array, v: Array, step: float) -> bool:
    """As `is_locked`, at approximate states along one step from (q, v)."""
    system = problem.system
    if not isinstance(system, Multibody) or not (threes := list(_hinge_triples(system))):
        return False
    configurations = (
        place(CHART, system.group, q, fraction * step * v) for fraction in STEP_FRACTIONS
    )
    return any(
        _near_lock(system.tree.mass(configuration), v, step, threes)
        for configuration in configurations
    )


def _near_lock(mass: Array, v: Array, step: float, threes: list[int]) -> bool:
    for k in threes:
        mass_of_triple = mass[k : k + 3, k : k + 3]
        root_masses = np.sqrt(np.diag(mass_of_triple))
        smallest_eigenvalue = float(
            np.linalg.eigvalsh(mass_of_triple / np.outer(root_masses, root_masses))[0]
        )
        # with equal inertias 1 - cos of the angle by which the outer axes are not parallel
        if np.sqrt(2.0 * max(smallest_eigenvalue, 0.0)) < abs(step * v[k + 1]):
            return True
    return False


def _hinge_triples(system: Multibody) -> Iterator[int]:
    """The first velocities of three hinges that follow each other on one link."""
    first = 0
    for link in system.links:
        types = [joint.type for joint in link.joints]
        first_velocities = first + np.cumsum([0, *(joint.dimension for joint in link.joints)])
        for k in range(len(types) - 2):
            if types[k : k + 3] == ["hinge"] * 3:
                yield int(first_velocities[k])
        first = int(first_velocities[-1])

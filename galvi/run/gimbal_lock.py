"""Detects three hinges of a body near gimbal lock, where their axes span only a plane."""

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
MAX_STATES = 512  # largest number of examined states
STEP_FRACTIONS = np.linspace(0.0, 1.0, 17)  # shares of a step


def is_locked(problem: Problem, states: Callable[[], tuple[Array, Array]], step: float) -> bool:
    """Whether three hinges of a body are nearer to gimbal lock at a state than the second one turns
    in a step; at most MAX_STATES states are examined.

    Parameters
    ----------
    states
        () -> configurations and momenta of the run, (n, ...) each; called only where a `Multibody`
        has three hinges in a row on a link
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
    """Whether `is_locked` holds at a configuration reached from q with the constant velocity v
    within one step."""
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
        # With equal inertias this is 1 - cos of the angle between the outer axes.
        if np.sqrt(2.0 * max(smallest_eigenvalue, 0.0)) < abs(step * v[k + 1]):
            return True
    return False


def _hinge_triples(system: Multibody) -> Iterator[int]:
    """The index of the first velocity of each three hinges that follow each other on a link."""
    first = 0
    for link in system.links:
        types = [joint.type for joint in link.joints]
        first_velocities = first + np.cumsum([0, *(joint.dimension for joint in link.joints)])
        for k in range(len(types) - 2):
            if types[k : k + 3] == ["hinge"] * 3:
                yield int(first_velocities[k])
        first = int(first_velocities[-1])

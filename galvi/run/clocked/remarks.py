"""What the status of a run in a clock says of pairs of point masses."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.problem import Problem

COSTLY = 10.0  # times as many steps because of one pair, from which on it is named


def paces(problem: Problem, q: Array) -> tuple[Array, Array, Array]:
    """The pairs i, j of bodies, and G (m_i + m_j) / r^3 of them, (n, pairs), at flat q (n, r)."""
    system: Any = problem.system
    i, j = np.triu_indices(system.masses.size, 1)
    mass = system.G * (system.masses[i] + system.masses[j])
    i, j, mass = i[mass > 0.0], j[mass > 0.0], mass[mass > 0.0]
    places = q.reshape(-1, *problem.q0.shape)
    square = np.sum((places[:, i] - places[:, j]) ** 2, axis=-1)
    with np.errstate(all="ignore"):
        return i, j, mass / square**1.5


def closest_pair(problem: Problem, q: Array) -> tuple[Any, Any]:
    """The names of the bodies that set the clock at q."""
    i, j, pace = paces(problem, q)
    pair, names = int(np.argmax(pace[0])), problem.body_names()
    return names[i[pair]], names[j[pair]]


def costly_pair(problem: Problem, q: Array) -> str:
    """A sentence on the one pair because of which steps are ``COSTLY`` times as many, or none."""
    i, j, pace = paces(problem, q)
    if pace.shape[1] < 2:
        return ""
    pair = int(np.bincount(np.argmax(pace, axis=1)).argmax())
    with np.errstate(all="ignore"):
        whole = np.sqrt(pace.sum(axis=1))
        others = np.sqrt(np.delete(pace, pair, axis=1).sum(axis=1))
    times = 1.0 / float(np.median(others / whole))
    if not times > COSTLY:
        return ""
    names = problem.body_names()
    about = float(f"{times:.1g}")
    return (
        f"Bodies {names[i[pair]]} and {names[j[pair]]} set the steps of all: about {about:g} times "
        f"as many as the others need."
    )

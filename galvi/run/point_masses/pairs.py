"""The pairs of point masses that set the steps of a clock."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.problem import Problem

COSTLY = 10.0  # times as many steps because of one pair, from which on it is named
PACED_STATES, PACED_STRIDE = 32, 8  # samples at which the pair is sought, and the least stride


def paces(problem: Problem, q: Array) -> tuple[Array, Array, Array]:
    """The pairs i, j of bodies, and G (m_i + m_j) / r^3 of them, (pairs, n), at flat q (n, r)."""
    i, j, mass = _pairs(problem.system)
    places = np.ascontiguousarray(q.reshape(-1, *problem.q0.shape).T)  # (dimension, bodies, n)
    gaps = places[:, i] - places[:, j]
    square = (gaps * gaps).sum(axis=0)
    with np.errstate(all="ignore"):
        return i, j, mass / (square * np.sqrt(square))


@lru_cache(maxsize=32)
def _pairs(system: Any) -> tuple[Any, Any, Array]:
    """The pairs i, j of bodies that attract, and G (m_i + m_j), (pairs, 1)."""
    i, j = np.triu_indices(system.masses.size, 1)
    mass = system.G * (system.masses[i] + system.masses[j])
    return i[mass > 0.0], j[mass > 0.0], read_only(mass[mass > 0.0, None])


def closest_pair(problem: Problem, q: Array) -> tuple[Any, Any]:
    """The names of the bodies that set the clock at q."""
    i, j, pace = paces(problem, q)
    pair, names = int(np.argmax(pace[:, 0])), problem.body_names()
    return names[i[pair]], names[j[pair]]


def costly_pair(problem: Problem, q: Array) -> str:
    """A sentence on the one pair because of which steps are ``COSTLY`` times as many, or none."""
    i, j, pace = paces(problem, q[:: max(PACED_STRIDE, -(-len(q) // PACED_STATES))])
    if len(pace) < 2:
        return ""
    pair = int(np.bincount(np.argmax(pace, axis=0)).argmax())
    with np.errstate(all="ignore"):
        remaining_pace = pace[:pair].sum(axis=0) + pace[pair + 1 :].sum(axis=0)
        shares = np.sort(remaining_pace / (remaining_pace + pace[pair]))
        times = 1.0 / np.sqrt(shares[len(shares) // 2])
    if not times > COSTLY:
        return ""
    names = problem.body_names()
    about = float(f"{times:.1g}")
    return (
        f"Bodies {names[i[pair]]} and {names[j[pair]]} set the steps of all: about {about:g} times "
        f"as many as the others need."
    )

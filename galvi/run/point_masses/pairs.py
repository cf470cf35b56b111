"""The pairs of point masses that determine the steps of a clock."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.problem import Problem

COSTLY_RATIO = 10.0  # factor of steps because of one pair, above which it is named
PACED_STATES, PACED_STRIDE = 32, 8  # largest number of examined samples, and their least stride


def pair_rates(problem: Problem, q: Array) -> tuple[Array, Array, Array]:
    """The pairs i, j (pairs,) of bodies, and their G (m_i + m_j) / r^3, (pairs, n), at flat q
    (n, r)."""
    i, j, mass = _pairs(problem.system)
    positions = np.ascontiguousarray(q.reshape(-1, *problem.q0.shape).T)  # (dimension, bodies, n)
    gaps = positions[:, i] - positions[:, j]
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
    """The names of the pair of bodies with the largest G (m_i + m_j) / r^3 at q."""
    i, j, rates = pair_rates(problem, q)
    pair, names = int(np.argmax(rates[:, 0])), problem.body_names()
    return names[i[pair]], names[j[pair]]


def costly_pair(problem: Problem, q: Array) -> str:
    """A sentence on one pair because of which there are more than ``COSTLY_RATIO`` times as many
    steps; "" without one."""
    i, j, rates = pair_rates(problem, q[:: max(PACED_STRIDE, -(-len(q) // PACED_STATES))])
    if len(rates) < 2:
        return ""
    pair = int(np.bincount(np.argmax(rates, axis=0)).argmax())
    with np.errstate(all="ignore"):
        remaining_rates = rates[:pair].sum(axis=0) + rates[pair + 1 :].sum(axis=0)
        shares = np.sort(remaining_rates / (remaining_rates + rates[pair]))
        step_ratio = 1.0 / np.sqrt(shares[len(shares) // 2])
    if not step_ratio > COSTLY_RATIO:
        return ""
    names = problem.body_names()
    rounded_ratio = float(f"{step_ratio:.1g}")
    return (
        f"Bodies {names[i[pair]]} and {names[j[pair]]} set the steps of all: about "
        f"{rounded_ratio:g} times as many as the others need."
    )

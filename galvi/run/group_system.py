"""Selects the kernel for a problem: that of Lie groups, or that of canonical systems.

It also finds the factors of a group that move independently, since no entry of the mass matrix
couples them, directly or through other factors. The round-off of a fast coordinate reaches only the
factors that are coupled to its own.
"""

from __future__ import annotations

from functools import lru_cache
from typing import Any, cast

import numpy as np
import numpy.typing as npt

from galvi.arrays import Array
from galvi.charts.chart import Exponential
from galvi.groups.group import Rn
from galvi.kernels.lie.product import COUPLED, DIMENSION, place
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn, checked_degrees
from galvi.systems.nbody import NBody
from galvi.systems.nbody_on_rn import NBodyOnRn
from galvi.systems.system import GroupSystem
from galvi.systems.traces import traces

STATES_BESIDE_START = 3  # sampled states other than the start
STATE_DISTANCE = 0.5  # largest change of their coordinates from the start
# Entries of a mass matrix above this share of the geometric mean of their masses couple factors.
COUPLING = 1e-9


def group_system(problem: Problem, method: Galerkin | None = None) -> GroupSystem | None:
    """The problem's system on a group; None where the kernel of canonical systems applies.

    The kernel of canonical systems is a Nystrom method: forces do not depend on the velocity and
    all components share one space. Other systems on vector spaces are treated on the group R^d.

    Raises
    ------
    ValueError
        For component degrees whose number is not that of the components, or that the system does
        not allow.
    """
    system: Any = problem.system
    degrees = checked_degrees(method.space, system, problem.v0.size) if method else None
    if hasattr(system, "group"):
        return cast(GroupSystem, system)
    if isinstance(system, Canonical) and (system.force is not None or degrees is not None):
        return CanonicalOnRn(system, Rn(problem.q0.size))
    if isinstance(system, NBody) and system.acting.of_velocity:
        return NBodyOnRn(system, problem.q0.shape[1])
    return None


def coupled_layout(system: Any, problem: Problem) -> npt.NDArray[np.int64]:
    """The layout of the group of a problem's system with one more column: a number that coupled
    factors share. It is 0 for all factors where the system has no mass matrix, or where that raises
    an exception."""
    layout = system.group.layout
    if len(layout) == 1 or not hasattr(system, "mass"):
        extended_layout = np.zeros((len(layout), COUPLED + 1), dtype=np.int64)
        extended_layout[:, :COUPLED] = layout
        return extended_layout
    return _coupled_layout(problem, traces(system))


@lru_cache(maxsize=256)
def _coupled_layout(problem: Problem, system_traces: Any) -> npt.NDArray[np.int64]:
    """`coupled_layout` of a Lagrangian on several factors, cached with its traces."""
    layout = problem.system.group.layout  # type: ignore[attr-defined]
    numbers = np.arange(len(layout))
    factor_of = np.repeat(numbers, layout[:, DIMENSION])
    try:
        masses = _masses(problem, layout)
    except Exception:  # of a user's function at a state that it does not expect
        numbers[:] = 0
        masses = np.zeros((factor_of.size, factor_of.size))
    root_masses = np.sqrt(np.abs(np.diag(masses)))
    with np.errstate(invalid="ignore"):
        coupled = ~np.isfinite(masses) | (masses > COUPLING * np.outer(root_masses, root_masses))
    for i, j in np.argwhere(coupled):
        i_number, j_number = numbers[factor_of[i]], numbers[factor_of[j]]
        numbers[numbers == max(i_number, j_number)] = min(i_number, j_number)
    return np.column_stack([layout, numbers])


def _masses(problem: Problem, layout: Any) -> Array:
    """The largest entries (d, d) of |d2L/dv2| at the start and STATES_BESIDE_START other states;
    infinite where an entry is NaN."""
    system: Any = problem.system
    generator, q, v = np.random.default_rng(0), problem.q0, problem.v0
    chart, largest = Exponential().number, np.zeros((v.size, v.size))
    for k in range(STATES_BESIDE_START + 1):
        sample, velocity = q.ravel().copy(), v
        if k:
            place(
                layout,
                chart,
                q.ravel().copy(),
                generator.uniform(-STATE_DISTANCE, STATE_DISTANCE, v.size),
                sample,
            )
            velocity = v + generator.uniform(-STATE_DISTANCE, STATE_DISTANCE, v.size) * max(
                1.0, float(np.max(np.abs(v)))
            )
        mass = np.abs(system.mass(sample.reshape(q.shape), velocity, problem.t0))
        largest = np.maximum(largest, np.where(np.isnan(mass), np.inf, mass))
    return largest

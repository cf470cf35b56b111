"""Changes of invariants along a run, and the defect of symplecticity of a step."""

from __future__ import annotations

import time
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.measures.errors import largest
from benchmarks.measures.symplectic_form import NUDGE, WEIGHTS, canonical_defect, form_defect
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.systems.lagrangian import momentum_at, velocity_at

CONSERVED_CHANGE = 1e-8  # largest relative change of a conserved component in an accurate motion
MOST_SECONDS = 5.0  # that differencing a step may take
INVARIANTS: Mapping[str, Callable[[Trajectory], Array]] = {
    "energy": galvi.energy,
    "angular momentum": galvi.momentum_map,
    "linear momentum": galvi.linear_momentum,
}
StepMap = Callable[[Problem], tuple[Array, Array]]  # problem -> (q, p) after a step from its start


def invariants(run: Trajectory) -> dict[str, Array]:
    """Values (saved, components) of the invariants that are defined for the system, by name."""
    values = {}
    for name, invariant in INVARIANTS.items():
        try:
            values[name] = np.asarray(invariant(run)).reshape(len(run.t), -1)
        except ValueError:  # not defined for this system
            continue
    return values


def kept_components(motion: Trajectory) -> dict[str, Array]:
    """Whether an accurate motion conserves each component of an invariant, (components,), by
    name."""
    return {
        name: np.max(np.abs(values - values[0]), axis=0)
        <= CONSERVED_CHANGE * _size(motion, name, values)
        for name, values in invariants(motion).items()
    }


def largest_changes(run: Trajectory, conserved: Mapping[str, Array]) -> tuple[float, float]:
    """The largest changes of the energy, and of a component of angular or linear momentum, among
    the `conserved` components, relative to the size of the invariant; NaN where there are none."""
    changes = {"energy": list[float](), "momentum": list[float]()}
    for name, values in invariants(run).items():
        if name in conserved and np.any(conserved[name]):
            change = np.max(np.abs(values - values[0])[:, conserved[name]]) / _size(
                run, name, values
            )
            changes[name.split()[-1]].append(float(change))
    energy, momentum = (max(values, default=np.nan) for values in changes.values())
    return energy, momentum


def _size(run: Trajectory, name: str, values: Array) -> float:
    """Largest norm of the values at any time; 1 where it is 0. For the linear momentum, which is 0
    about the centre of mass, the largest norm of all p."""
    vectors = run.p.reshape(len(run.t), -1) if name == "linear momentum" else values
    return float(np.max(np.linalg.norm(vectors, axis=1))) or 1.0


def map_symplecticity_defect(problem: Problem, step: StepMap) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 for a step (q0, p0) -> (q1, p1), differenced
    with order eight, to about 1e-12; it shares no code with `galvi.symplecticity_defect`.

    NaN where a step fails, where the differences would take more than MOST_SECONDS, and for
    massless bodies, whose momenta are no coordinates.
    """
    system: Any = problem.system
    if getattr(system, "has_massless", False):
        return np.nan
    if not np.all(np.isfinite(step(problem)[1])):  # this first step may compile
        return np.nan
    start = time.perf_counter()
    step(problem)
    if (time.perf_counter() - start) * 16 * problem.v0.size > MOST_SECONDS:
        return np.nan

    def end(q: Array, p: Array) -> tuple[Array, Array]:
        v = np.asarray(velocity_at(system, q, p, problem.t0, problem.v0)).reshape(problem.v0.shape)
        return step(replace(problem, q0=q, v0=v))

    group = getattr(system, "group", None)
    if group is not None and problem.q0.shape != problem.v0.shape:
        return form_defect(end, group, problem.q0, problem.p0)
    return canonical_defect(_derivative(end, problem))


def _derivative(end: Callable[[Array, Array], tuple[Array, Array]], problem: Problem) -> Array:
    """D(q1, p1)/D(q0, p0), (2 d, 2 d), in the coordinates L^T q and L^-1 p.

    M = L L^T is the mass matrix at the start. Differences are taken in q and M^-1 p, and the
    coordinates are in units of their largest entries at the start: otherwise light bodies, whose
    small momenta are large velocities, would hide the other bodies.
    """
    d, start = problem.q0.size, [problem.q0, problem.p0]
    L = _root_of_mass(problem)
    from_p = np.linalg.inv(L @ L.T)
    v = from_p @ problem.p0.ravel()
    lengths = [NUDGE * (largest(x) or 1.0) for x in (problem.q0, v)]
    shifts = [lengths[0] * np.eye(d), lengths[1] * L @ L.T]
    derivative = np.zeros((2 * d, 2 * d))
    for column in range(2 * d):
        part, entry = divmod(column, d)
        for k, weight in enumerate(WEIGHTS, start=1):
            for sign in (1.0, -1.0):
                shifted = [x.copy() for x in start]
                shifted[part] += sign * k * shifts[part][:, entry].reshape(start[part].shape)
                q, p = (x.ravel() for x in end(*shifted))
                derivative[:, column] += sign * weight * np.concatenate([q, from_p @ p])
    derivative /= np.repeat(lengths, d)
    zero, sizes = np.zeros((d, d)), [largest(L.T @ x) or 1.0 for x in (problem.q0.ravel(), v)]
    scaling = np.block([[L.T / sizes[0], zero], [zero, L.T / sizes[1]]])
    return scaling @ derivative @ np.linalg.inv(scaling)


def _root_of_mass(problem: Problem) -> Array:
    """L (d, d) with L L^T = dp/dv at the start; the unit matrix where that is not positive."""
    d, shape = problem.q0.size, problem.v0.shape

    def momentum(v: Array) -> Array:
        return np.ravel(momentum_at(problem.system, problem.q0[None], v[None], [problem.t0]))

    units = np.eye(d).reshape(d, *shape)
    mass = np.stack(
        [0.5 * (momentum(problem.v0 + unit) - momentum(problem.v0 - unit)) for unit in units]
    )
    try:
        return np.linalg.cholesky(0.5 * (mass + mass.T))
    except np.linalg.LinAlgError:
        return np.eye(d)

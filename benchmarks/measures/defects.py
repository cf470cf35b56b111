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
LONGEST = 5.0  # seconds that differencing a step may take
INVARIANTS: Mapping[str, Callable[[Trajectory], Array]] = {
    "energy": galvi.energy,
    "angular momentum": galvi.momentum_map,
    "linear momentum": galvi.linear_momentum,
}
StepMap = Callable[[Problem], tuple[Array, Array]]  # the state (q, p) after a step from its start


def invariants(run: Trajectory) -> dict[str, Array]:
    """Name -> values (saved, components) of the invariants that the system has."""
    values = {}
    for name, of in INVARIANTS.items():
        try:
            values[name] = np.asarray(of(run)).reshape(len(run.t), -1)
        except ValueError:  # not defined for this system
            continue
    return values


def kept_components(motion: Trajectory) -> dict[str, Array]:
    """Name -> (components,) whether an accurate motion conserves the component."""
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
    """Largest norm at a time: of the linear momentum that of all p, as it is 0 about the centre of
    mass; 1 where it is always 0."""
    of = run.p.reshape(len(run.t), -1) if name == "linear momentum" else values
    return float(np.max(np.linalg.norm(of, axis=1))) or 1.0


def map_symplecticity_defect(problem: Problem, step: StepMap) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 for a step (q0, p0) -> (q1, p1), differenced
    with order eight, to about 1e-12; it shares no code with `galvi.symplecticity_defect`.

    NaN where a step fails, where the differences would take more than LONGEST seconds, and for
    massless bodies, whose momenta are no coordinates.
    """
    system: Any = problem.system
    if getattr(system, "has_massless", False):
        return np.nan
    if not np.all(np.isfinite(step(problem)[1])):  # this first step may compile
        return np.nan
    begun = time.perf_counter()
    step(problem)
    if (time.perf_counter() - begun) * 16 * problem.v0.size > LONGEST:
        return np.nan

    def end(q: Array, p: Array) -> tuple[Array, Array]:
        v = np.asarray(velocity_at(system, q, p, problem.t0, problem.v0)).reshape(problem.v0.shape)
        return step(replace(problem, q0=q, v0=v))

    group = getattr(system, "group", None)
    if group is not None and problem.q0.shape != problem.v0.shape:
        return form_defect(end, group, problem.q0, problem.p0)
    return canonical_defect(_derivative(end, problem))


def _derivative(end: Callable[[Array, Array], tuple[Array, Array]], problem: Problem) -> Array:
    """D(q1, p1)/D(q0, p0), (2 d, 2 d), differenced in q and M^-1 p, with M = L L^T the mass at the
    start, and written in the conjugate coordinates L^T q and L^-1 p, in units of their largest
    entries there: else light bodies, whose small momenta are large velocities, hide the rest."""
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
                moved = [x.copy() for x in start]
                moved[part] += sign * k * shifts[part][:, entry].reshape(start[part].shape)
                q, p = (x.ravel() for x in end(*moved))
                derivative[:, column] += sign * weight * np.concatenate([q, from_p @ p])
    derivative /= np.repeat(lengths, d)
    zero, sizes = np.zeros((d, d)), [largest(L.T @ x) or 1.0 for x in (problem.q0.ravel(), v)]
    to = np.block([[L.T / sizes[0], zero], [zero, L.T / sizes[1]]])
    return to @ derivative @ np.linalg.inv(to)


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

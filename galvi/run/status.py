"""Why a run ended, in one sentence with the remedy."""

from __future__ import annotations

from contextlib import suppress
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.charts import CHARTS
from galvi.charts.chart import Chart
from galvi.kernels.nystrom.solve import NOT_FINITE, SOLVED
from galvi.kernels.on_group.advance import LEFT_CHART
from galvi.problem import Problem
from galvi.systems.canonical import Canonical
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody
from galvi.systems.potentials.potential import Potential
from galvi.systems.potentials.uniform_gravity import UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.systems.velocities import velocity_at
from galvi.trajectory import COMPLETED

OFF = 0.1  # change of the energy over |T| + |V| that no usable run has
CLOSE = 0.1  # of the momentum; the energy is then known to a part of the square of this
NEAR_LIMIT = 0.8  # of a chart's limit, from which a step that is not solved is said to leave it
FAR = 1e100  # lengths; squares of larger ones overflow
TRIED = {
    "auto": "neither fixed-point iteration nor Newton's method solved",
    "fixed_point": "fixed-point iteration did not solve",
    "newton": "Newton's method did not solve",
}
SOLVABLE = 0.5  # step / sqrt(r^3 / G(m_i + m_j)) that each stage adds to what can be solved


def ending(
    problem: Problem, code: int, solver: str, stages: int, step: float, done: int, steps: int,
    t: float, state: Array,
) -> str:  # fmt: skip
    """The status of a run that did ``done`` of ``steps`` steps and stands at time t in ``state``.

    code    of the last kernel call
    solver  that the run was allowed
    stages  of the method
    state   (4, d), see galvi.checkpoint
    """
    if done == steps:
        if not _conserves_energy(problem.system):
            return COMPLETED
        return _completed(problem, state[0], state[2])
    where = f"at step {done + 1} of {steps}, from t = {t:g}"
    if code == SOLVED:
        return f"Interrupted {where}; what was computed is kept."
    if isinstance(problem.system, NBody) and problem.system.masses.size > 1:
        with np.errstate(all="ignore"):
            return f"Stopped {where}: {_encounter(problem, problem.system, stages, step, state)}"
    if code == NOT_FINITE:
        return (
            f"Stopped {where}: the force or the state became infinite or NaN. "
            f"Use a smaller step, or keep away from the force's singularity."
        )
    return (
        f"Stopped {where}: {TRIED[solver]} the stage equations. Use a smaller step or a higher "
        f"degree{'' if solver == 'auto' else ', or the solver auto'}."
    )


def ending_on_group(
    problem: Problem, chart: Chart, code: int, solver: str, step: float, done: int, steps: int,
    t: float, q: Array, p: Array, near: Array, turn: float, slopes: bool,
) -> str:  # fmt: skip
    """The status of a run on a group; arguments as for `ending`.

    q, p    where it stands
    near    (d,) about its velocity
    turn    angle, radians, by which the step that failed turns; 0 where nothing turns
    slopes  whether the derivatives of the Lagrangian are known, not differenced
    """
    if done == steps:
        if not _conserves_energy(problem.system):
            return COMPLETED
        return _completed_on_group(problem, q, p, t, near)
    where = f"at step {done + 1} of {steps}, from t = {t:g}"
    if code == SOLVED:
        return f"Interrupted {where}; what was computed is kept."
    if not turn < FAR:
        return (
            f"Stopped {where}: velocities above 1e100 overflow. Use other units, or a smaller step."
        )
    if turn >= NEAR_LIMIT * chart.limit or code == LEFT_CHART:
        limit, name = chart.limit, type(chart).__name__
        farther = max(CHARTS, key=lambda other: other.limit)
        other = "" if farther.limit <= limit else (
            f", or chart=galvi.{type(farther).__name__}(), which ends at {farther.limit / np.pi:g} "
            f"pi"
        )  # fmt: skip
        return (
            f"Stopped {where}: the step turns by {turn:.4g} radians, and the chart {name} ends at "
            f"{limit:.4g}. Use a step of at most {0.5 * abs(step) * limit / turn:.2g}{other}."
        )
    if code == NOT_FINITE:
        return (
            f"Stopped {where}: the force or the state became infinite or NaN, or the equations "
            f"singular. Use a smaller step, or keep away from the force's singularity."
        )
    tried, other = TRIED["newton"], "" if slopes else ", or give the Lagrangian its slopes"
    if solver == "fixed_point":
        tried, other = TRIED[solver], ", or the solver auto"
    return (
        f"Stopped {where}: {tried} the stage equations"
        f"{f' of a step that turns by {turn:.3g} radians' if turn else ''}. "
        f"Use a smaller step or a higher degree{other}."
    )


def _completed(problem: Problem, q: Array, v: Array) -> str:
    """Completed at (q, v), with a word when the energy, which is conserved, says otherwise."""
    change = _change(problem, q, v)
    if change <= OFF:
        return COMPLETED
    if np.isnan(change):
        return (
            "Completed, but no velocity was found that has the momentum at the end: the step is "
            "too large for this motion. Use a smaller step or a higher degree."
        )
    return (
        f"Completed, but the energy changed by {change:.2g} times |T| + |V| at the start: the step "
        f"is too large for this motion. Use a smaller step or a higher degree."
    )


def _change(problem: Problem, q: Array, v: Array, p: Array | None = None) -> float:
    """Of the energy, over |T| + |V| at the start; p as in ``_energy``."""
    with np.errstate(all="ignore"):
        start, end = _energy(problem, problem.q0, problem.v0), _energy(problem, q, v, p)
        size, change = abs(start[0]) + abs(start[1]), abs(sum(end) - sum(start))
    return change / size if size > 0.0 else (0.0 if change == 0.0 else np.inf)


def _completed_on_group(problem: Problem, q: Array, p: Array, t: float, near: Array) -> str:
    """As ``_completed``, at (q, p).

    A Lagrangian's energy p . v - L(q, v) is stationary where v has the momentum p, so that a
    velocity that has nearly that momentum serves.
    """
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        with np.errstate(all="ignore"), suppress(ArithmeticError, ValueError):
            off = np.max(np.abs(system.momentum(near, q, problem.t0) - p))
            if off <= CLOSE * np.max(np.abs(p)) and _change(problem, q, near, p) <= OFF:
                return COMPLETED
    return _completed(problem, q, velocity_at(system, q, p, t, near))


def _conserves_energy(system: Any) -> bool:
    """Whether it does, and its energy is known to round-off and quickly had."""
    if isinstance(system, NBody | FreeBody):
        return True
    if getattr(system, "force", None) is not None:
        return False
    if isinstance(system, Lagrangian):
        return not system.explicit_time and system.potential_calls_per_force == 0
    if isinstance(system, RigidBody):
        return system.gradient is None and isinstance(system.potential, UniformGravity | None)
    return isinstance(system, Canonical) and isinstance(system.potential, Potential)


def _energy(problem: Problem, q: Array, v: Array, p: Array | None = None) -> tuple[float, float]:
    """T and V; of a Lagrangian p . v, where v has the momentum p if that is not given, and -L."""
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        p = system.momentum(v, q, problem.t0) if p is None else p
        return float(p @ v), -system.value(q, v, problem.t0)
    q, v = q.reshape(problem.q0.shape), v.reshape(problem.v0.shape)
    kinetic = 0.5 * float(np.sum(v * system.momentum(v)))
    return kinetic, float(system.potential_energy(q, np.zeros(())))


def _encounter(
    problem: Problem, system: NBody, stages: int, step: float, state: Array
) -> str:  # fmt: skip
    """Which bodies the step failed for: one that is lost, or the pair that sets the pace."""
    q, v = (state[row].reshape(problem.q0.shape) for row in (0, 2))
    masses, G = system.masses, system.G
    names = problem.parameters.get("bodies")
    if not isinstance(names, (tuple, list)) or len(names) != len(masses):
        names = range(len(masses))
    distance = np.max(np.abs(q), axis=1)
    lost = int(np.argmax(distance))
    if abs(step) > FAR or np.max(np.abs(v)) > FAR:
        return "steps and velocities above 1e100 overflow. Use other units, or a smaller step."
    if not distance[lost] < FAR:
        return f"body {names[lost]} is {distance[lost]:.1e} away. Remove it, or stop before then."
    i, j = np.triu_indices(len(masses), 1)
    gap, speed = q[j] - q[i], v[j] - v[i]
    rate = np.sum(speed**2, axis=1)
    nearest = -np.sum(gap * speed, axis=1) / np.where(rate > 0.0, rate, 1.0)
    passing = np.clip(nearest, min(step, 0.0), max(step, 0.0))
    closest = np.linalg.norm(gap + passing[:, None] * speed, axis=1)
    pace = np.sqrt(
        np.minimum(closest, np.linalg.norm(gap, axis=1)) ** 3 / (G * (masses[i] + masses[j]))
    )
    pair = int(np.argmin(pace))
    solvable = SOLVABLE * stages * pace[pair]
    bodies = f"bodies {names[i[pair]]} and {names[j[pair]]}"
    if solvable < 1e-6 * abs(step):
        return f"{bodies} collide. Stop before then, or merge them."
    return (
        f"{bodies} pass at a distance of about {closest[pair]:.1e}, where steps of up to about "
        f"{solvable:.1e} can be solved; received {abs(step):g}. Use a smaller step or a higher "
        f"degree."
    )

"""Why a run ended, in one sentence with the remedy."""

from __future__ import annotations

import numpy as np

from galvi.arrays import Array
from galvi.kernels.solve import NOT_FINITE, SOLVED
from galvi.problem import Problem
from galvi.systems.nbody import NBody
from galvi.trajectory import COMPLETED

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
    state   (4, d), see galvi.continuation
    """
    if done == steps:
        return COMPLETED
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

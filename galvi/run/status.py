"""The status of a run: one sentence saying why it ended, with a remedy."""

from __future__ import annotations

import numpy as np

from galvi.checkpoint import Checkpoint
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.energy_check import USABLE, conserves_energy
from galvi.run.engine import Engine
from galvi.run.run_arrays import RunArrays
from galvi.trajectory import COMPLETED


def final_status(
    engine: Engine, problem: Problem, method: Galerkin, step: float, steps: int,
    start: Checkpoint, work: RunArrays, code: int,
) -> str:  # fmt: skip
    """The status of a run of ``steps`` steps whose last kernel call returned ``code``."""
    done = work.done
    t = problem.t0 + start.first * step + done * step
    if done == steps:
        return _completed(engine, problem, t, work)
    where = f"at step {done + 1} of {steps}, from t = {t:g}"
    if code == SOLVED:
        return f"Interrupted {where}; what was computed is kept."
    return f"Stopped {where}: {engine.failure(problem, method, step, code, start.solver, work)}"


def _completed(engine: Engine, problem: Problem, t: float, work: RunArrays) -> str:
    """COMPLETED, or a warning that a conserved energy has changed too much."""
    if not conserves_energy(problem.system):
        return COMPLETED
    change = engine.energy_change(problem, t, work)
    if change <= USABLE:
        return COMPLETED
    if np.isnan(change):
        return (
            "Completed, but no velocity was found for the momentum at the end: the step is too "
            "large for this motion. Use a smaller step or a higher degree."
        )
    return (
        f"Completed, but the energy changed by {change:.2g} times |T| + |V| at the start: the step "
        f"is too large for this motion. Use a smaller step or a higher degree."
    )

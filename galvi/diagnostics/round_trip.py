"""A check that needs no truth: integrate forwards, then backwards to the start."""

from __future__ import annotations

import numpy as np

from galvi import input_checks
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.trajectory import Trajectory


def round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """Largest component of |q - q0| after ``steps`` steps forwards and as many backwards.

    A symmetric method returns to round-off; others, a `KeplerFrame` whose nodes an orbit places,
    and on groups all but degree 1 with the exponential chart, only to their order. Raises
    ValueError when a run fails, what `galvi.integrate` raises, and KeyboardInterrupt on Ctrl-C.
    """
    step = input_checks.real("step", step)
    there = uninterrupted(integrate(problem, method, step, steps, save_every=steps))
    _check(there)
    end, t = there.q[-1], float(there.t[-1])
    reversed_start = Problem(problem.system, end, there.v[-1], t)
    back = uninterrupted(integrate(reversed_start, method, -step, steps, save_every=steps))
    _check(back)
    return float(np.max(np.abs(back.q[-1] - problem.q0)))


def _check(run: Trajectory) -> None:
    if not run.success:
        raise ValueError(f"both ways must be completed; received a run of which: {run.status}")

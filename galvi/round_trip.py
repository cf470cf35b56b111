"""A check that needs no truth: integrate forwards, then backwards to the start."""

from __future__ import annotations

import numpy as np

from galvi.integrate import integrate
from galvi.method import Galerkin
from galvi.problem import Problem


def round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """Largest component of |q - q0| after ``steps`` steps forwards and as many backwards.

    A symmetric method returns to round-off; others only to their order. NaN when a run fails.
    Raises what `galvi.integrate` raises.
    """
    there = integrate(problem, method, step, steps, save_every=steps)
    if not there.success:
        return float("nan")
    turned = Problem(
        problem.system, there.q[-1], problem.system.velocity(there.p[-1]), float(there.t[-1])
    )
    back = integrate(turned, method, -step, steps, save_every=steps)
    return float(np.max(np.abs(back.q[-1] - problem.q0)))

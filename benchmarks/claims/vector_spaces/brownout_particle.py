"""M's single particle (M 6.2), shared by V23 and V24: two starts, a truth, runs and their errors.

w = v - wind is the relative velocity, and the drag is quadratic in it.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
from scipy.optimize import brentq

import galvi
from benchmarks.claims.kit import Array, MakeMethod, Problem, Trajectory
from references.contender import Contender
from references.newton import external_force
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.euler import SEMI_IMPLICIT_EULER

ERROR, EULER = "error of the place", "semi-implicit Euler"
PIECES = 8  # number of equal parts of the duration; errors are measured at their ends
AWAY, ACROSS = "w away from 0", "w through 0"
STARTS = {  # position [m], velocity [m/s]; ACROSS moves along the axis, where w changes sign once
    AWAY: ((8.5, 0.0, 3.0), (0.0, 1.0, 0.0)),
    ACROSS: ((0.0, 0.0, 14.0), (0.0, 0.0, 0.0)),
}
DURATION = {AWAY: 2.0, ACROSS: 0.8}  # s


@cache
def problem_of(start: str) -> Any:
    """The problem of a particle of 200 micrometres from a start, in m and s."""
    return galvi.problems.brownout(200e-6, *STARTS[start])


def run_of(
    make_method: MakeMethod, start: str, degree: int, size: int, tolerance: float | None = None
) -> Trajectory:
    """A run by polynomials of degree N with N + 1 Gauss points (M 6.1), or by semi-implicit Euler
    for N = 0, with `size` steps in each of the PIECES; the ends of the pieces are saved."""
    problem, h = problem_of(start), DURATION[start] / (PIECES * size)
    if degree == 0:
        setting = {"step": h, "save_every": size}
        return SEMI_IMPLICIT_EULER.run(problem, DURATION[start], setting)
    method = make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))
    steps = PIECES * size
    return galvi.integrate(problem, method, h, steps, save_every=size, tolerance=tolerance)


def error_of(run: Trajectory, start: str) -> float:
    """The largest component of the error of the position [m] at the ends of the pieces."""
    return float(np.max(abs(run.q[1:] - truth(start))))


@cache
def truth(start: str, contender: Contender = DOP853) -> Array:
    """Positions at the ends of the pieces, (PIECES, 3) [m], each a step end of the reference.

    The time at which w is 0, where the drag's second derivative jumps, is a step end, too.

    Parameters
    ----------
    contender
        DOP853 at its tightest tolerance, or Radau, of a different family, to check it
    """
    problem, places = problem_of(start), []
    ends = [DURATION[start] * (k + 1) / PIECES for k in range(PIECES)]
    for t in sorted({*ends, crossing_time()} if start == ACROSS else ends):
        problem = carried(problem, t, contender)
        if t in ends:
            places.append(problem.q0)
    return np.array(places)


def carried(problem: Any, t: float, contender: Contender = DOP853) -> Any:
    """The problem that starts at time t, from the state of the reference at that time."""
    if t == problem.t0:
        return problem
    setting: Any = TIGHT if contender is DOP853 else {"rtol": 1e-12, "atol": 1e-13}
    run = contender.run(problem, t - problem.t0, setting)
    return Problem(problem.system, run.q[-1], problem.system.velocity(run.p[-1]), t)


@cache
def crossing_time() -> float:
    """The time at which w is 0 on the way from ACROSS [s], by a bracketing search on runs.

    An error d of this time changes the truth by a multiple of d^3, the integral of a quadratic
    force over d.
    """
    problem = problem_of(ACROSS)
    along = (lambda t: relative_velocity(carried(problem, t)), 0.0, DURATION[ACROSS])
    return float(brentq(*along, xtol=1e-9))


def relative_velocity(problem: Any) -> float:
    """The vertical w at the start of a motion along the axis, from the drag -k |w| w [m/s]."""
    drag = external_force(problem)(problem.q0, problem.v0, problem.t0)[2]
    return -float(np.sign(drag) * np.sqrt(abs(drag) / problem.system.force.factor))

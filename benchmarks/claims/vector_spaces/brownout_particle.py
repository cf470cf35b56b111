"""M's single particle (M 6.2), shared by V23 and V24: two starts, a truth and the errors."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

import galvi
from benchmarks.checks.claim import MakeMethod
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.contender import Contender
from references.scipy.ivp import DOP853, TIGHT

DIAMETER = 200e-6
PIECES = 8  # equal parts of the duration, at whose ends errors are measured
CHECK: Mapping[str, Any] = {"rtol": 1e-12, "atol": 1e-13}  # for Radau, which checks DOP853
AWAY, ACROSS = "w away from 0", "w through 0"
MOVING = "quartz of 200 micrometres, drag M (14) with C_d = 0.44, gravity, galvi's rotor wind"
METHOD = "Polynomials(N), gauss(N + 1) as in M 6.1"


@dataclass(frozen=True)
class Start:
    """The particle's initial state and the duration of its run.

    w = v - wind is the relative velocity; the drag is quadratic in it.
    """

    words: str
    place: tuple[float, float, float]
    velocity: tuple[float, float, float]
    duration: float

    def problem(self) -> Problem:
        """The problem, in m and s."""
        return galvi.problems.brownout(DIAMETER, self.place, self.velocity)


STARTS: Mapping[str, Start] = {
    AWAY: Start(
        "3 m above the ground, outside the rotor's edge, |w| > 3 m/s",
        (8.5, 0.0, 3.0),
        (0.0, 1.0, 0.0),
        2.0,
    ),
    ACROSS: Start(
        "dropped on the axis: the downwash overtakes it until it falls through the air again",
        (0.0, 0.0, 14.0),
        (0.0, 0.0, 0.0),
        0.8,
    ),
}


def method_of_degree(make_method: MakeMethod, degree: int) -> Any:
    """M 6.1: polynomials of degree N with N + 1 Gauss points."""
    return make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))


@lru_cache(maxsize=4)
def truth(start: str, contender: Contender = DOP853) -> Array:
    """Positions at the ends of the pieces, (PIECES, 3), each a step end of the reference.

    contender  DOP853 at its tightest tolerance, or Radau, of a different family, to check it
    """
    known, setting = STARTS[start], TIGHT if contender is DOP853 else CHECK
    problem, places = known.problem(), []
    for _ in range(PIECES):
        run = contender.run(problem, known.duration / PIECES, setting)
        places.append(run.q[-1])
        v = problem.system.velocity(run.p[-1])
        problem = Problem(problem.system, run.q[-1], v, float(run.t[-1]))
    result: Array = np.array(places)
    result.flags.writeable = False
    return result


def trajectory_error(run: Trajectory, exact: Array) -> float:
    """Largest component of the position error [m] at the ends of the pieces; NaN for a failed run.

    The number of saved states, without the start, must be a multiple of PIECES.
    """
    every = (len(run.t) - 1) // PIECES
    return float(np.max(np.abs(run.q[every::every] - exact)))

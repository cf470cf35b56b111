"""M's single particle (M 6.2), shared by V23 and V24: two starts, a truth and the errors."""

from __future__ import annotations

from functools import lru_cache

from scipy.optimize import brentq

from benchmarks.claims.kit import *
from references.contender import Contender
from references.newton import external_force
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

    crosses  the particle moves along the axis, and the vertical w changes its sign once
    """

    words: str
    place: tuple[float, float, float]
    velocity: tuple[float, float, float]
    duration: float
    crosses: bool = False

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
        crosses=True,
    ),
}


def method_of_degree(make_method: MakeMethod, degree: int) -> Any:
    """M 6.1: polynomials of degree N with N + 1 Gauss points."""
    return make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))


@lru_cache(maxsize=4)
def truth(start: str, contender: Contender = DOP853) -> Array:
    """Positions at the ends of the pieces, (PIECES, 3), each a step end of the reference.

    The moment in which w is 0, where the drag's second derivative jumps, is a step end too.

    contender  DOP853 at its tightest tolerance, or Radau, of a different family, to check it
    """
    known = STARTS[start]
    problem, places = known.problem(), []
    ends = [known.duration * (k + 1) / PIECES for k in range(PIECES)]
    for t in sorted({*ends, *([crossing_time(start)] if known.crosses else [])}):
        problem = carried(problem, t, contender)
        if t in ends:
            places.append(problem.q0)
    result: Array = np.array(places)
    result.flags.writeable = False
    return result


def carried(problem: Problem, t: float, contender: Contender = DOP853) -> Problem:
    """The problem from time t on: its state there by the reference."""
    if t == problem.t0:
        return problem
    setting = TIGHT if contender is DOP853 else CHECK
    run = contender.run(problem, t - problem.t0, setting)
    return Problem(problem.system, run.q[-1], problem.system.velocity(run.p[-1]), t)


@lru_cache(maxsize=1)
def crossing_time(start: str) -> float:
    """When the vertical w of a start that crosses is 0 [s].

    By a bracketing search on runs from the start. An error d of this time changes the truth by a
    multiple of d^3, the integral of a quadratic force over d.
    """
    problem, end = STARTS[start].problem(), STARTS[start].duration
    return float(brentq(lambda t: relative_velocity(carried(problem, t)), 0.0, end, xtol=1e-9))


def relative_velocity(problem: Problem) -> float:
    """The vertical w at the start of a motion along the axis, from the drag -k |w| w [m/s]."""
    drag = external_force(problem)(problem.q0, problem.v0, problem.t0)[2]
    return -float(np.sign(drag) * np.sqrt(abs(drag) / problem.system.force.factor))


def trajectory_error(run: Trajectory, exact: Array) -> float:
    """Largest component of the position error [m] at the ends of the pieces; NaN for a failed run.

    The number of saved states, without the start, must be a multiple of PIECES.
    """
    every = (len(run.t) - 1) // PIECES
    return float(np.max(np.abs(run.q[every::every] - exact)))

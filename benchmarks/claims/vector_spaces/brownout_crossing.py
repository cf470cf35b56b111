"""The error that a step leaves in which the drag's second derivative jumps, derived.

About the moment t* in which w = 0 the relative velocity on the axis is c (t - t*) to first order,
and the drag per mass is -(k / m) |w| w = -(k / m) c |c| (2 x_+^2 - x^2), with x = t - t* and
x_+ = max(x, 0). A rule of N + 1 Gauss points integrates x^2 exactly, but x_+^2 with the error
h^3 e(theta), theta the place of t* in its step of length h:

    e(theta) = sum_j b_j (c_j - theta)_+^2 - (1 - theta)^3 / 3.

So the velocity after this step is wrong by -2 (k / m) c |c| e(theta) h^3, whatever N is, and the
height at the end T by that times S = dz(T) / dv(t*). Other errors of this step are of order h^4:
its place, by h times the velocity's error. Away from it the method has its own order 2 N.
"""

from __future__ import annotations

from functools import lru_cache

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.brownout_particle import (
    STARTS,
    carried,
    crossing_time,
    relative_velocity,
)
from benchmarks.measures.independent_space import gauss_points

APART = 1e-4  # s, and m/s: of central differences, whose error is of its square


@dataclass(frozen=True)
class Crossing:
    """time  t* [s];  strength  -2 (k / m) c |c| S [m / s^3], of an error e(theta) h^3."""

    time: float
    strength: float

    def height_error(self, h: float, degree: int) -> float:
        """The derived error of the height at the end, for steps h from t = 0 [m]."""
        return self.strength * h**3 * rule_error(self.time / h % 1.0, degree + 1)

    def largest(self, h: float, degree: int) -> float:
        """Its largest absolute value over all places of t* in a step [m]."""
        places = np.linspace(0.0, 1.0, 2001)
        return float(
            abs(self.strength) * h**3 * max(abs(rule_error(x, degree + 1)) for x in places)
        )


@lru_cache(maxsize=1)
def crossing(start: str) -> Crossing:
    """The crossing of a start, its numbers by central differences of the reference's runs."""
    known, time = STARTS[start], crossing_time(start)
    problem = known.problem()
    system: Any = problem.system
    before, after = (relative_velocity(carried(problem, time + d)) for d in (-APART, APART))
    rate = (after - before) / (2.0 * APART)
    there = carried(problem, time)
    low, high = (
        carried(replace(there, v0=there.v0 + np.array([0.0, 0.0, d])), known.duration).q0[2]
        for d in (-APART, APART)
    )
    sensitivity = (high - low) / (2.0 * APART)
    per_mass = system.force.factor / float(system.mass)
    return Crossing(time, -2.0 * per_mass * rate * abs(rate) * sensitivity)


def rule_error(theta: float, points: int) -> float:
    """e(theta) of Gauss's rule with so many points on [0, 1]."""
    t, b = gauss_points(points)
    return float(b @ np.maximum(t - theta, 0.0) ** 2 - (1.0 - theta) ** 3 / 3.0)

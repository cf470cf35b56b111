"""The derived error of a step in which the second derivative of the drag jumps.

Near the time t* at which w = 0, the relative velocity on the axis is c (t - t*) to first order,
and the drag per mass is -(k / m) |w| w = -(k / m) c |c| (2 x_+^2 - x^2), with x = t - t* and
x_+ = max(x, 0). A rule of N + 1 Gauss points integrates x^2 exactly, but x_+^2 with the error
h^3 e(theta), where theta is the fraction of its step of length h at which t* lies:

    e(theta) = sum_j b_j (c_j - theta)_+^2 - (1 - theta)^3 / 3.

The velocity after this step is therefore wrong by -2 (k / m) c |c| e(theta) h^3 for any N, and the
height at the end T by that times S = dz(T) / dv(t*). Other errors of this step are of order h^4,
such as that of the position, h times the velocity's. Other steps have the method's order 2 N.
"""

from __future__ import annotations

from dataclasses import replace
from functools import cache

import numpy as np

from benchmarks.claims.vector_spaces.brownout_particle import (
    ACROSS,
    DURATION,
    carried,
    crossing_time,
    problem_of,
    relative_velocity,
)
from benchmarks.measures.independent_space import gauss_points

DIFFERENCE_STEP = 1e-4  # s, and m/s; of central differences, whose error is of its square


def kink_error(h: float, degree: int, theta: float) -> float:
    """The derived error of the height at the end [m], for a step size h [s] and t* at the fraction
    theta of its step."""
    return strength() * h**3 * rule_error(theta, degree + 1)


@cache
def strength() -> float:
    """-2 (k / m) c |c| S, by central differences of the reference's runs [m / s^3]."""
    time, start = crossing_time(), problem_of(ACROSS)
    before, after = (
        relative_velocity(carried(start, time + d)) for d in (-DIFFERENCE_STEP, DIFFERENCE_STEP)
    )
    crossing, system = carried(start, time), start.system
    low, high = (
        carried(replace(crossing, v0=crossing.v0 + np.array([0.0, 0.0, d])), DURATION[ACROSS]).q0[2]
        for d in (-DIFFERENCE_STEP, DIFFERENCE_STEP)
    )
    rate, sensitivity = (
        (after - before) / (2.0 * DIFFERENCE_STEP),
        (high - low) / (2.0 * DIFFERENCE_STEP),
    )
    return float(-2.0 * system.force.factor / system.mass * rate * abs(rate) * sensitivity)


def rule_error(theta: float, points: int) -> float:
    """e(theta) of Gauss's rule with `points` points on [0, 1]."""
    t, b = gauss_points(points)
    return float(b @ np.maximum(t - theta, 0.0) ** 2 - (1.0 - theta) ** 3 / 3.0)

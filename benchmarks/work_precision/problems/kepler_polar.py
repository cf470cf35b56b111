"""Work-precision on the Kepler problem in polar coordinates."""

from __future__ import annotations

import math

import numpy as np

import galvi
from benchmarks.work_precision.problem import EPS, Truth, WorkPrecisionProblem
from benchmarks.work_precision.problems.coordinates import on_coordinates
from references.closed_forms.kepler import KEPLER
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853

DURATION = 20.0  # more than three revolutions
STEPS = {4: (40, 56, 80, 112), 6: (28, 40, 56, 80), 8: (24, 28, 40, 56), 12: (24, 28)}


def kepler_polar(quick: bool) -> WorkPrecisionProblem:
    """An orbit of eccentricity 0.3 in r and phi.

    In a longer run phi grows, and with it the error that a tolerance allows.
    """
    problem = galvi.problems.kepler_polar()

    def truth() -> Truth:
        orbit = galvi.problems.kepler(problem.parameters["eccentricity"])
        x, y = KEPLER.run(orbit, DURATION, {"samples": 1}).q[-1].tolist()
        # The mean anomaly, the time here, is within half a turn of the angle.
        turns = round((DURATION - math.atan2(y, x)) / math.tau)
        end = np.array([math.hypot(x, y), math.atan2(y, x) + turns * math.tau])
        return Truth(end, 2.0 * EPS * float(end.max()), KEPLER.name)

    return on_coordinates(problem, DURATION, quick, STEPS, LAGRANGIAN_DOP853, truth, net_time=True)

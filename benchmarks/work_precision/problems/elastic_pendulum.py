"""Work-precision on the elastic pendulum."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.coordinates import on_coordinates
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853

STEPS = {4: (35, 50, 100), 6: (25, 35, 50, 70), 8: (20, 25, 35, 50), 12: (20, 25)}


def elastic_pendulum(quick: bool) -> WorkPrecisionProblem:
    """A mass on a spring in polar coordinates, some seven oscillations of the spring."""
    return on_coordinates(
        galvi.problems.elastic_pendulum(), 5.0, quick, STEPS, LAGRANGIAN_DOP853, repeated_run=True
    )

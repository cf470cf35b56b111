"""Work-precision on the Henon-Heiles system."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.coordinates import on_coordinates
from references.scipy.ivp import DOP853

STEPS = {4: (14, 20, 40), 6: (7, 10, 14, 20), 8: (7, 10, 14, 20), 12: (5, 7, 10)}


def henon_heiles(quick: bool) -> WorkPrecisionProblem:
    """A star in an axisymmetric galaxy, some three revolutions."""
    return on_coordinates(
        galvi.problems.henon_heiles(), 20.0, quick, STEPS, DOP853, repeated_run=True
    )

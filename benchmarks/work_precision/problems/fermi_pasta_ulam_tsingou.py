"""Work-precision on the chain of Fermi, Pasta, Ulam and Tsingou."""

from __future__ import annotations

import galvi
from benchmarks.work_precision.problem import WorkPrecisionProblem
from benchmarks.work_precision.problems.coordinates import on_coordinates
from references.scipy.ivp import DOP853

STEPS = {4: (7, 10, 14), 6: (5, 7, 10), 8: (5, 7), 12: (4, 5)}


def fermi_pasta_ulam_tsingou(quick: bool) -> WorkPrecisionProblem:
    """15 masses on nonlinear springs, some six periods of the fastest mode."""
    return on_coordinates(
        galvi.problems.fermi_pasta_ulam_tsingou(), 20.0, quick, STEPS, DOP853, repeated_run=True
    )

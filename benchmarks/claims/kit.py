"""Names of the suite that many claims use: tables, fits, refinements and planted faults."""

from pandas import DataFrame

from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.checks.faults import (
    ORACLES,
    OTHER_TRUTH,
    Fault,
    always,
    faulty,
    fewer,
    heavier,
    of_motion,
    of_table,
    reversed_clock,
    scaled,
    times,
    with_arguments,
)
from benchmarks.measures.refinement import (
    CAYLEY,
    ENDS_AND_CURVE,
    Case,
    at_fixed_time,
    collocation,
    method_of,
    method_on_group,
    refine,
    refine_at_end,
    with_fixed_number,
)
from benchmarks.statistics import convergence_fits, readings
from benchmarks.statistics.convergence_fits import Fit, algebraic
from benchmarks.statistics.estimate import Estimate, Measurement, estimate
from benchmarks.store.tables import failure, history, number, pick, row, rows, series, table_of
from galvi import Problem, Trajectory
from galvi.arrays import Array

__all__ = [
    "CAYLEY",
    "ENDS_AND_CURVE",
    "ORACLES",
    "OTHER_TRUTH",
    "Array",
    "Case",
    "DataFrame",
    "Estimate",
    "Fault",
    "Fit",
    "MakeMethod",
    "Measurement",
    "Problem",
    "Report",
    "Trajectory",
    "algebraic",
    "always",
    "at_fixed_time",
    "collocation",
    "convergence_fits",
    "estimate",
    "failure",
    "faulty",
    "fewer",
    "heavier",
    "history",
    "method_of",
    "method_on_group",
    "number",
    "of_motion",
    "of_table",
    "pick",
    "readings",
    "refine",
    "refine_at_end",
    "reversed_clock",
    "row",
    "rows",
    "scaled",
    "series",
    "table_of",
    "times",
    "with_arguments",
    "with_fixed_number",
]

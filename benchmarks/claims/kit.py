"""The names that files of claims share, for `from benchmarks.claims.kit import *`.

Bounds, rows, tidy frames, statistics, galvi. A test finds names that nothing defines.
"""

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from typing import Any

import numpy as np
from pandas import DataFrame

import galvi
from benchmarks.checks.bounds import (
    ATTAINED,
    CONTRADICTED,
    EXCEEDS,
    FINDING,
    HOLDS,
    NOT_REPRODUCED,
    NOT_RUN,
    ORDER_RESOLUTION,
    Above,
    AtLeast,
    AtMost,
    Base,
    Below,
    Bound,
    Exactly,
    Finding,
    Near,
    Order,
    Reported,
    Within,
)
from benchmarks.checks.claim import (
    AGREEMENT,
    Check,
    Claim,
    MakeMethod,
    Report,
    Row,
    check,
    judged,
    scalars,
)
from benchmarks.checks.faults import (
    ORACLES,
    OTHER_TRUTH,
    Fault,
    always,
    fewer,
    given,
    heavier,
    of_motion,
    of_table,
    reversed_clock,
    scaled,
    some,
    times,
)
from benchmarks.checks.series_bounds import Geometric, NoGrowth
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
from benchmarks.store.frames import failure, frame, history, number, pick, row, rows, series
from galvi import Problem, Trajectory
from galvi.arrays import Array

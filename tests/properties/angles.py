"""Charts with sizes |xi| of every decade up to the largest of a step, for the tests of charts."""

import numpy as np
import pytest

import galvi
from galvi.charts import CHARTS
from galvi.kernels.lie.charts import exponential

CAYLEY, EXPONENTIAL, RODRIGUES = galvi.Cayley(), galvi.Exponential(), galvi.ModifiedRodrigues()
DECADES = [10.0**k for k in range(-12, 1)]
SERIES_SWITCH = np.sqrt(exponential.LARGEST_SERIES_U)
# |xi| up to the largest of a step, and on both sides of the switch from the series to the formula.
SIZES = {
    CAYLEY: [*DECADES, 2.0, 20.0, CAYLEY.farthest],
    RODRIGUES: [*DECADES, 2.0, 4.0, 40.0, RODRIGUES.farthest],
    EXPONENTIAL: [
        *DECADES,
        2.0,
        np.pi,
        5.0,
        EXPONENTIAL.farthest,
        *(SERIES_SWITCH * (1.0 + side * 10.0**k) for k in (-15, -8, -3) for side in (-1, 1)),
    ],
}
CHARTS_AND_SIZES = [
    (chart, size) for chart in CHARTS for size in SIZES.get(chart, [*DECADES, 2.0, chart.farthest])
]
each_size = pytest.mark.parametrize(("chart", "size"), CHARTS_AND_SIZES, ids=str)

"""Functions of charts of rotations, called by the number of the chart.

For their definitions see galvi.kernels.lie.charts.
"""

from __future__ import annotations

from galvi.kernels.lie import charts
from galvi.kernels.lie.dispatch import by_number, modules_of

CHARTS = modules_of(charts)

rotation_radial = by_number("rotation", CHARTS)
tangent_radial = by_number("tangent", CHARTS)
inverse_radial = by_number("inverse", CHARTS)
translation_radial = by_number("translation", CHARTS)
half_turn = by_number("half_turn", CHARTS)
from_quaternion = by_number("from_quaternion", CHARTS)
angle_of = by_number("angle", CHARTS)
coordinate_of = by_number("coordinate", CHARTS)
REACHES = tuple(chart.REACH_IN_LANES for chart in CHARTS)

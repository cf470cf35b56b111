"""Ticks of logarithmic axes, and labels of errors with their units."""

from __future__ import annotations

import math
from typing import Any

from matplotlib.axes import Axes
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullLocator

from benchmarks.work_precision.problem import ANGLE, ATTITUDE, COORDINATES, MOTION, POSITION
from reports.tables.number_format import MINUS, SUPERSCRIPT

MAX_READABLE_DECADES = 3.0  # decades of an axis, below which its ticks are round numbers
USABLE_TICK_SPACE = 0.7  # of the ticks that matplotlib finds room for: these have longer labels


def set_decade_ticks(axis: Axis) -> None:
    """Put as many ticks on an axis as fit, each a power of ten, and no minor ticks."""
    axis.set_major_locator(LogLocator())
    axis.set_minor_locator(NullLocator())
    axis.set_major_formatter(power_of_ten)


def power_of_ten(x: float, _: Any = None) -> str:
    """The label of a tick: 10⁻⁸ for a power of ten, else its digits.

    matplotlib's own formatter writes mathematics, and parsing it takes half of a figure's time.
    """
    exponent = math.log10(abs(x)) if x else 0.5
    if exponent != round(exponent):
        return f"{x:g}"
    return f"{MINUS if x < 0.0 else ''}10{str(round(exponent)).translate(SUPERSCRIPT)}"


def set_readable_ticks(axis: Axis) -> None:
    """Put ticks at 1, 2 and 5, or at 1 and 3, of each decade, with their digits, if the axis spans
    fewer than MAX_READABLE_DECADES decades and they fit; else at powers of ten."""
    low, high = sorted(axis.get_view_interval())
    span = math.log10(high / low)
    set_decade_ticks(axis)
    for subs in ((1.0, 3.0), (1.0, 2.0, 5.0)):
        if (
            span < MAX_READABLE_DECADES
            and span * len(subs) + 1.0 < USABLE_TICK_SPACE * axis.get_tick_space()
        ):
            axis.set_major_locator(LogLocator(subs=subs, numticks=20))
            axis.set_major_formatter("{x:g}")


def choose_ticks(axes: Axes) -> None:
    """Set the ticks of logarithmic axes that have the default ones: `set_readable_ticks` on x,
    `set_decade_ticks` on y."""
    for axis, ticks in ((axes.xaxis, set_readable_ticks), (axes.yaxis, set_decade_ticks)):
        if axis.get_scale() == "log" and axis.isDefault_majloc:
            ticks(axis)


ERROR_TEXTS = {
    POSITION: "error of the position at the end",
    ATTITUDE: "error of the attitude at the end, largest entry of $R - R_{true}$",
    ANGLE: "error of the angles at the end",
    COORDINATES: "error of the coordinates at the end",
    MOTION: "error of attitude and place at the end",
}
UNIT_OF_QUANTITY = {ANGLE: "rad", ATTITUDE: "1"}
UNIT_OF_PROBLEM = {  # beginning of a problem's name -> unit of its errors
    "outer solar system": "au",
    "solar system": "au",
    "kepler e=0.6": "semi-major axis",
    "kepler e=0.3 in polar": "semi-major axis, rad",
    "HD 80606": "au",
    "Kozai-Lidov": "au",
    "brownout": "m",
    "skew arm": "rad",
    "floating arm": "1, m, rad",
    "free body on SE(3)": "1, unit of length",
    "elastic pendulum": "unit of length, rad",
}


def error_label(problem: str, quantity: str) -> str:
    """The label of an axis of errors, such as "error of the position at the end [au]".

    The unit is that of the quantity or, if it has none, of the problem; 1 if neither has one.
    """
    units = (unit for beginning, unit in UNIT_OF_PROBLEM.items() if problem.startswith(beginning))
    unit = UNIT_OF_QUANTITY.get(quantity) or next(units, "1")
    return f"{ERROR_TEXTS.get(quantity, f'error of the {quantity} at the end')} [{unit}]"

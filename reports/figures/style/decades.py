"""Axes: ticks of logarithmic ones, labels with units, and the exception of no data."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import (
    LogLocator,
    MaxNLocator,
    NullFormatter,
    NullLocator,
    StrMethodFormatter,
)

from benchmarks.work_precision.problem import ANGLE, ATTITUDE, COORDINATES, MOTION, POSITION
from reports.tables.number_format import MINUS, SUPERSCRIPT


class Thirds(LogLocator):
    """Ticks at 1 and 3 of each decade."""


def decades(axis: Axis) -> None:
    """At most nine ticks, each a power of ten, and no minor ticks."""
    axis.set_major_locator(LogLocator(base=10.0, numticks=9))
    axis.set_minor_locator(NullLocator())
    powers(axis)


def powers(axis: Axis) -> None:
    """Powers of ten are written without the mathematics of matplotlib's own formatter, whose
    parsing takes half of the time of a figure; other ticks in digits."""
    axis.set_major_formatter(_power)


def _power(x: float, _: Any = None) -> str:
    exponent = math.log10(abs(x)) if x else 0.5
    if exponent != round(exponent):
        return f"{x:g}"
    return f"{MINUS if x < 0.0 else ''}10{str(round(exponent)).translate(SUPERSCRIPT)}"


def round_numbers(axis: Axis) -> None:
    """Ticks at 1, 2 and 5 of each decade, written out: for axes of a few decades."""
    axis.set_major_locator(LogLocator(base=10.0, subs=(1.0, 2.0, 5.0), numticks=20))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def readable(axis: Axis) -> None:
    """Round numbers where the axis spans less than three decades, powers of ten where more."""
    low, high = sorted(axis.get_view_interval())
    (round_numbers if high < 1000.0 * low else decades)(axis)


def fewer(axis: Axis) -> bool:
    """One step fewer ticks; False where there are no fewer."""
    low, high = sorted(axis.get_view_interval())
    locator = axis.get_major_locator()
    shown = int(np.sum((axis.get_majorticklocs() >= low) & (axis.get_majorticklocs() <= high)))
    if shown <= 2:
        return False
    if isinstance(locator, LogLocator):
        written_out = isinstance(axis.get_major_formatter(), StrMethodFormatter)
        if written_out and not isinstance(locator, Thirds):
            axis.set_major_locator(Thirds(base=10.0, subs=(1.0, 3.0), numticks=20))
        elif written_out:
            axis.set_major_locator(LogLocator(base=10.0, numticks=9))
        else:
            axis.set_major_locator(LogLocator(base=10.0, numticks=shown - 1))
    elif isinstance(locator, MaxNLocator):
        locator.set_params(nbins=max(1, shown - 2))
    else:
        return False
    return True


WORDS = {
    POSITION: "error of the position at the end",
    ATTITUDE: "error of the attitude at the end, largest entry of $R - R_{true}$",
    ANGLE: "error of the angles at the end",
    COORDINATES: "error of the coordinates at the end",
    MOTION: "error of attitude and place at the end",
}
DIMENSIONLESS = "1"
OF_QUANTITY = {ANGLE: "rad", ATTITUDE: DIMENSIONLESS}
OF_PROBLEM = {  # where a problem's name begins so
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
    """E.g. "error of the position at the end [au]"; [1] where lengths have no unit."""
    known = next((unit for name, unit in OF_PROBLEM.items() if problem.startswith(name)), None)
    unit = OF_QUANTITY.get(quantity) or known or DIMENSIONLESS
    return f"{WORDS.get(quantity, f'error of the {quantity} at the end')} [{unit}]"

"""Readable ticks for logarithmic axes."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from matplotlib.axis import Axis
from matplotlib.ticker import LogLocator, NullFormatter, NullLocator, StrMethodFormatter

from reports.tables.number_format import MINUS, SUPERSCRIPT

ROOM = 2.9  # inches of an axis that holds the round numbers of three decades


def decades(axis: Axis, most: int = 9) -> None:
    """At most `most` ticks, each a power of ten, and no minor ticks."""
    axis.set_major_locator(LogLocator(base=10.0, numticks=most))
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


def whole_decades(axis: Axis) -> None:
    """Widen a logarithmic axis to powers of ten, so that it has two ticks at least."""
    low, high = sorted(axis.get_view_interval())
    limits = 10.0 ** np.floor(np.log10(low)), 10.0 ** np.ceil(np.log10(high))
    axis.axes.set(**{f"{axis.axis_name}lim": limits})


def round_numbers(axis: Axis) -> None:
    """Ticks at 1, 2 and 5 of each decade, written out: for axes of a few decades."""
    axis.set_major_locator(LogLocator(base=10.0, subs=(1.0, 2.0, 5.0), numticks=20))
    axis.set_major_formatter(StrMethodFormatter("{x:g}"))
    axis.set_minor_locator(NullLocator())
    axis.set_minor_formatter(NullFormatter())


def readable(axis: Axis) -> None:
    """Round numbers where the axis spans less than three decades, powers of ten where more."""
    low, high = sorted(axis.get_view_interval())
    inches = axis.axes.get_position().width * axis.axes.figure.get_figwidth()
    few = high < (1000.0 if inches > ROOM else 30.0) * low
    (round_numbers if few else decades)(axis)

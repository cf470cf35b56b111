"""A figure for a paper: exactly as wide as a column or a page, with its fonts embedded."""

from __future__ import annotations

import re
import textwrap

import matplotlib
import matplotlib.style
import pandas as pd

from reports.figures.moving import hide_all_but_last
from reports.figures.picture import STYLE, drawn, saved
from reports.results.figure import Figure

WIDTHS = {"column": 3.3, "page": 6.9}  # inches
EMBEDDED = {"pdf.fonttype": 42, "svg.fonttype": "path", "savefig.dpi": 300}
SMALL = {
    "font.size": 7.0, "axes.titlesize": 7.5, "axes.labelsize": 7.0, "xtick.labelsize": 6.5,
    "ytick.labelsize": 6.5, "legend.fontsize": 6.5, "lines.markersize": 3.0, "lines.linewidth": 1.1,
}  # fmt: skip
ROUNDS = 6  # in which the canvas is fitted to the width of what is drawn
CLOSE = 0.01  # inches
LETTERS = 46  # of a label that fits beside an axis of three inches
UNBROKEN = "\u00a0"
LEAST, TALLEST = 1.6, 1.1  # of a canvas: inches wide; height over width of the result


def sized(figure: Figure, frame: pd.DataFrame, form: str, width: float) -> bytes:
    """The file of a figure whose drawing, labels outside the axes included, is `width` inches wide.

    form  pdf, svg or png
    """
    with matplotlib.style.context([STYLE, EMBEDDED, SMALL if width < 5.0 else {}]):
        ratio = min(figure.size[1] / figure.size[0], TALLEST)
        panels = len(figure.options.get("panels", ())) if width < 5.0 else 1
        least = 0.62 * max(1, panels) if width < 5.0 else 0.0
        across, high = width, max(ratio, least) * width
        for _ in range(ROUNDS):
            canvas = drawn(figure, frame, (across, high))
            for axes in canvas.axes:
                letters = max(20, int(LETTERS * high / max(1, panels) / 3.0))
                axes.set_ylabel(_filled(axes.get_ylabel(), letters))
            canvas.draw_without_rendering()
            pad = 2.0 * matplotlib.rcParams["savefig.pad_inches"]
            wide = canvas.get_tightbbox().width + pad
            if abs(wide - width) < CLOSE:
                break
            across = max(LEAST, across + width - wide)
        hide_all_but_last(canvas)
        return saved(canvas, form)


def _filled(label: str, letters: int) -> str:
    """The label in lines of so many letters, without a break within mathematics."""
    whole = re.sub(r"\$[^$]*\$", lambda found: found[0].replace(" ", UNBROKEN), label)
    return textwrap.fill(whole, letters).replace(UNBROKEN, " ")

"""A figure for a paper: exactly as wide as a column or a page, with its fonts embedded."""

from __future__ import annotations

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


def sized(figure: Figure, frame: pd.DataFrame, form: str, width: float) -> bytes:
    """The file of a figure that is `width` inches wide.

    form  pdf, svg or png
    """
    with matplotlib.style.context([STYLE, EMBEDDED, SMALL if width < 3.6 else {}]):
        canvas = drawn(figure, frame, width)
        hide_all_but_last(canvas)
        return saved(canvas, form)

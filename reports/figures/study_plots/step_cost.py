"""Time per step of each method."""

from __future__ import annotations

import pandas as pd
from matplotlib import rcParams
from matplotlib.axes import Axes

from benchmarks.work_precision.labels import label_of
from reports.figures.style.identities import blue
from reports.figures.style.layout import UNBROKEN, wrapped
from reports.figures.style.no_data import NoData

LINE = 1.3  # distance of two lines of text, in font sizes
LETTER = 0.56  # width of a letter, likewise
MARGINS = 0.6  # inches above and below the rows


def step_cost(axes: Axes, frame: pd.DataFrame) -> None:
    """Microseconds per step as dots, each below its method."""
    rows = frame[frame["seconds_per_step"] > 0]
    if rows.empty:
        raise NoData("no method has a time for a step.")
    size = float(rcParams["xtick.labelsize"]) / 72.0
    letters = int((axes.figure.get_figwidth() - 0.3) / (LETTER * size))
    line, guides = 0.0, []  # counted downwards
    for _, row in rows.iterrows():
        name = f"{label_of(row['problem']).title}: {row['method']}, h ={UNBROKEN}{row['step']:.3g}"
        text = wrapped(name, letters)
        axes.text(0.01, -line, text, transform=axes.get_yaxis_transform(), va="top",
                  fontsize=72.0 * size)  # fmt: skip
        line += text.count("\n") + 1.2
        axes.plot(1e6 * row["seconds_per_step"], -line, "o", markersize=5, color=blue(8))
        guides.append(-line)
        line += 1.0
    axes.set(xscale="log", xlabel="time for one step [µs]", ylim=(-line, 0.3))
    axes.set_yticks(guides, [""] * len(guides))
    axes.tick_params(axis="y", length=0.0)
    axes.figure.set_figheight(LINE * size * line + MARGINS)

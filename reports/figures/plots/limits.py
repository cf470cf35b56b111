"""Error of one step against its rotation angle, up to the limit of each chart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.store.frames import pick
from reports.figures.style.decades import decades
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import NoData, legend

LEAST, TOP = 1e-17, 10.0  # where an error of 0 is drawn, and the end of the axis
DASHES = ((0, (4, 2)), (0, (1, 1.5)), (0, (5, 1.5, 1, 1.5)))
ABOVE = 1.03  # of the crosses of the first chart, relative to the height of the axes


def limits(
    axes: Axes, frame: pd.DataFrame, *, quantity: str, charts: Mapping[str, tuple[float, str]]
) -> None:
    """For each chart (a study), the error against the rotation angle; crosses where runs failed.

    charts  study -> (limit in radians, label of the limit)
    """
    axes.set_yscale("log")
    for k, study in enumerate(charts):
        rows = pick(frame, study=study, quantity=quantity).sort_values("step")
        turn, error = rows["step"].to_numpy(float), rows["value"].to_numpy(float)
        if not np.any(np.isfinite(error)):
            raise NoData(f"{study}: no step was done.")
        color, ended = COLOURS[k], ~np.isfinite(error)
        axes.plot(turn, np.maximum(error, LEAST), MARKERS[k] + "-", color=color, linewidth=0.8,
                  label=study)  # fmt: skip
        if np.any(ended):
            height = ABOVE + 0.035 * k
            axes.plot(turn[ended], np.full(ended.sum(), height), "x", color=color, markersize=3.5,
                      transform=axes.get_xaxis_transform(), clip_on=False)  # fmt: skip
            failed = Line2D([], [], color=GUIDE, marker="x", linestyle="none")
            legend(axes, [failed], ["failed"])
    for (limit, words), dash in zip(dict.fromkeys(charts.values()), DASHES, strict=False):
        axes.axvline(limit, color=GUIDE, linestyle=dash, linewidth=1.1, label=words)
    axes.set(xlabel="rotation angle of one step [rad]", ylabel="error of the attitude [1]")
    axes.set_ylim(LEAST, TOP)
    decades(axes.yaxis)
    legend(axes)

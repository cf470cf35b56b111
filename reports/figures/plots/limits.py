"""Error of one step against its rotation angle, up to the limit of each chart."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.decades import decades
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import COLOURS, GUIDE, MARKERS, darker

LEAST, TOP = 1e-17, 10.0  # where an error of 0 is drawn, and the end of the axis
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
            axes.annotate("failed", (turn[ended][0], height), xytext=(-5, 0), ha="right",
                          va="center", fontsize=7, xycoords=axes.get_xaxis_transform(),
                          textcoords="offset points", color=darker(color))  # fmt: skip
    for limit, words in dict.fromkeys(charts.values()):
        axes.axvline(limit, color=GUIDE, linestyle=(0, (4, 2)), linewidth=1.1)
        axes.annotate(
            words, (limit, 0.0), xycoords=("data", "axes fraction"), xytext=(3, 3),
            textcoords="offset points", color=darker(GUIDE), fontsize=8,
        )  # fmt: skip
    axes.set(xlabel="rotation angle of one step [rad]", ylabel="error of the attitude [1]")
    axes.set_ylim(LEAST, TOP)
    decades(axes.yaxis)
    axes.legend(title="chart", loc="upper left", bbox_to_anchor=(0.02, 0.95))

"""Errors of rotations, momenta and energies in long runs: RMS against steps, both logarithmic."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.statistics.growth import rms
from benchmarks.studies.so3_drift import QUANTITIES, ensembles
from reports.figures.style.decades import decades
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import GUIDE, looks


def so3_drift_growth(axes: Axes, frame: pd.DataFrame) -> None:
    """A panel for each quantity, with a guide that grows as the square root of the steps."""
    found = [one for one in ensembles(frame) if np.all(np.isfinite(one[3]))]
    if not found:
        raise NoData("no ensemble of runs is complete.")
    styles = looks(ensemble["contender"] for ensemble, _, _, _ in found)
    grid = axes.get_subplotspec().subgridspec(1, len(QUANTITIES), wspace=0.3)
    axes.set_axis_off()
    for column, (name, text) in enumerate(QUANTITIES.items()):
        one = axes.figure.add_subplot(grid[column])
        one.set(xscale="log", yscale="log", xlabel="steps", title=text)
        lowest, first, last = np.inf, np.inf, 0.0
        for ensemble, quantity, done, errors in found:
            if quantity != name:
                continue
            one.plot(done, rms(errors), markersize=3.0, **styles[ensemble["contender"]])
            first, last = min(first, done[0]), max(last, done[-1])
            lowest = min(lowest, float(np.min(rms(errors) / np.sqrt(done))))
        ends = np.array([first, last])
        one.plot(ends, 0.5 * lowest * np.sqrt(ends), color=GUIDE, linestyle=(0, (5, 3)),
                 linewidth=1.0)  # fmt: skip
        decades(one.xaxis, 5)
        decades(one.yaxis, 6)
        one.title.set_fontsize(9)
    handles = [Line2D([], [], label=name, **style) for name, style in styles.items()]
    handles.append(Line2D([], [], label="square root of the steps", color=GUIDE, linestyle="--"))
    axes.legend(handles=handles, loc="upper center", bbox_to_anchor=(0.5, -0.12), ncols=2)

"""The error of the step of a statistic against its cost, beside the errors of sampling."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.applications.brownout.step_errors import OF_STEP, SAMPLING, WORK, sampling_error
from benchmarks.store.frames import pick
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import NoData, legend

GRAINS = {1e4: "error of 10,000 grains", 1e6: "error of a million grains"}
DASHES = ((0, (5, 3)), (0, (1, 2)))


def sampling(axes: Axes, frame: pd.DataFrame, *, quantity: str, degrees: Mapping[int, str]) -> None:
    """A line for each degree, of the errors of the step that were solved, over the evaluations; an
    error below its standard error is an arrow at their sum, an upper limit."""
    drawn = False
    for k, (degree, label) in enumerate(degrees.items()):
        rows = pick(frame, study=quantity, quantity=OF_STEP, n=degree + 1).sort_values("steps")
        others = (pick(frame, study=study, quantity=name, n=degree + 1).set_index("steps")["value"]
                  for study, name in ((WORK, WORK), (quantity, f"{SAMPLING} of it")))  # fmt: skip
        work, own = (one.reindex(rows["steps"]).to_numpy(float) for one in others)
        error = np.abs(rows["value"].to_numpy(float))
        known = np.isfinite(error) & np.isfinite(work) & (error > 0.0)
        if not np.any(known):
            continue
        drawn = True
        seen, color = known & ~(error < own), COLOURS[k]
        limit = known & (error < own)
        axes.errorbar(work[seen], error[seen], yerr=own[seen], label=label, color=color,
                      marker=MARKERS[k], linewidth=1.0)  # fmt: skip
        if np.any(limit):
            top = error[limit] + own[limit]
            axes.errorbar(work[limit], top, yerr=0.4 * top, uplims=True, color=color,
                          marker=MARKERS[k], mfc="white", linestyle="none")  # fmt: skip
    if not drawn:
        raise NoData("no run of the cloud was solved.")
    for (grains, text), dash in zip(GRAINS.items(), DASHES, strict=True):
        level = sampling_error(frame, quantity, grains)
        if level > 0.0:
            axes.axhline(level, color=GUIDE, linestyle=dash, linewidth=1.0, label=text)
    axes.set(xscale="log", yscale="log", xlabel="evaluations of the wind for a grain",
             ylabel=f"error of the {quantity}")  # fmt: skip
    decades(axes.yaxis)
    readable(axes.xaxis)
    legend(axes)

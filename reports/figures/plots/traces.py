"""Errors of several contenders as lines, against the step or another quantity."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.decades import decades, readable
from reports.figures.style.identities import MARKERS, line_color
from reports.figures.style.layout import Label, NoData, label_ends, legend

STEP = "step"  # column of the x axis unless it is another quantity of the same runs


def traces(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantity: str,
    against: str,
    labels: Mapping[str, str],
    xlabel: str,
    ylabel: str,
    between: tuple[str, ...] = (),
) -> None:
    """A line for each study in ``labels``, labelled at its smallest step, on the right, or, against
    another quantity, in a legend.

    quantity  errors; runs that failed have none
    against   "step", or a quantity, paired by the number of steps
    between   quantities of the same runs, from which to which there is a bar; none where empty
    """
    ends: list[Label] = []
    falling = against == STEP
    for k, (study, text) in enumerate(labels.items()):
        x, error = _line(frame, study, quantity, against)
        if not x.size:
            continue
        color = line_color(study, k)
        axes.plot(x, error, color=color, marker=MARKERS[k], markersize=4.0, linewidth=1.0,
                  label=text)  # fmt: skip
        ends_of_bars = [_line(frame, study, quantity, name) for name in between]
        if len({bar.size for bar, _ in ends_of_bars}) == 1:
            (low, at), (high, _) = ends_of_bars
            axes.hlines(at, low, high, color=color, linewidth=0.9, alpha=0.8)
        last = int(np.argmin(x))
        ends.append(Label(float(x[last]), float(error[last]), text, color, MARKERS[k]))
    if not ends:
        raise NoData(f"no run has a finite {quantity}.")
    axes.set(xscale="log", yscale="log", xlabel=xlabel, ylabel=ylabel)
    decades(axes.yaxis)
    axes.autoscale_view()
    if falling:
        axes.invert_xaxis()
    readable(axes.xaxis)
    if falling:
        label_ends(axes, ends)
    else:
        legend(axes)


def _line(
    frame: pd.DataFrame, study: str, quantity: str, against: str
) -> tuple[np.ndarray, np.ndarray]:
    """Positive pairs, by number of steps."""
    rows = pick(frame, study=study, quantity=quantity).sort_values("steps")
    error, x = rows["value"].to_numpy(float), rows[STEP].to_numpy(float)
    if against != STEP:
        others = pick(frame, study=study, quantity=against).set_index("steps")["value"]
        x = others.reindex(rows["steps"]).to_numpy(float)
    known = (error > 0.0) & (x > 0.0)
    return x[known], error[known]

"""Departures from the invariant sets of the exact motion against time, one panel for each."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.decades import decades
from reports.figures.style.identities import line_color
from reports.figures.style.layout import Label, label_ends, panels
from reports.figures.style.no_data import NoData

SMALLEST = 1e-17  # drawn in place of 0


def departures(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantities: Sequence[str],
    labels: Mapping[str, str],
    xlabel: str = "time $t$",
) -> None:
    """A line for each study in `labels`, labelled at its end, in a panel for each quantity; both
    axes logarithmic, times from the second sample on."""
    for one, quantity in zip(panels(axes, len(quantities), least=3.0), quantities, strict=True):
        one.set(xscale="log", yscale="log", xlabel=xlabel, title=quantity)
        ends = []
        for k, (study, text) in enumerate(labels.items()):
            rows = pick(frame, study=study, quantity=quantity).sort_values("t")
            t, away = rows["t"].to_numpy(float), rows["value"].to_numpy(float)
            seen = (t > 0.0) & np.isfinite(away)
            if not np.any(seen):
                raise NoData(f"{study}: no step has a finite {quantity}.")
            t, away, color = t[seen], np.maximum(away[seen], SMALLEST), line_color(study, k)
            one.plot(t, away, color=color, linewidth=1.0)
            ends.append(Label(away[-1], text, color))
        decades(one.xaxis)
        decades(one.yaxis)
        label_ends(one, ends)

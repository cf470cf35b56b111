"""Energy error against time, and its change in each step against the step's rotation angle."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.decades import decades
from reports.figures.style.identities import COLOURS, GUIDE, MARKERS
from reports.figures.style.layout import Label, NoData, label_ends, legend, panels

LEAST = 1e-17  # where an error of exactly 0 is drawn
AHEAD = 1.02  # factor on the range of angles, to show the limit


def jumps(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    quantity: str,
    runs: Mapping[str, str],
    steps: Mapping[str, str],
    turn: str,
    change: str,
    limit: tuple[float, str],
) -> None:
    """First panel: |quantity| of each study in ``runs``, labelled; a cross where one ends early.
    Second: for each study in ``steps``, ``change`` against ``turn`` at the same times. A label ends
    with the chart, which has one colour in both.

    limit  an angle to mark, and its label
    """
    left, right = panels(axes, 2, least=3.0)
    colours = {text.split()[0]: COLOURS[k] for k, text in enumerate(steps.values())}
    _histories(left, frame, quantity, runs, colours)
    widest = limit[0]
    for k, (study, text) in enumerate(steps.items()):
        found = _pairs(frame, study, turn, change)
        if found.empty:
            raise NoData(f"{study}: no step was done.")
        widest = max(widest, float(found[turn].max()))
        style = {"color": COLOURS[k], "marker": MARKERS[k], "markersize": 3.5}
        right.plot(found[turn], np.maximum(found[change], LEAST), linestyle="none", label=text,
                   **style)  # fmt: skip
    right.axvline(limit[0], color=GUIDE, linestyle=(0, (4, 2)), linewidth=1.1, label=limit[1])
    right.set(yscale="log", xlabel="rotation angle of the step [rad]", ylabel=change)
    right.set_xlim(0.0, AHEAD * widest)
    decades(right.yaxis)
    legend(right)


def _histories(
    axes: Axes, frame: pd.DataFrame, quantity: str, runs: Mapping[str, str],
    colours: Mapping[str, str],
) -> None:  # fmt: skip
    ends = []
    for study, text in runs.items():
        rows = pick(frame, study=study, quantity=quantity).sort_values("t")
        rows = rows[rows["value"].notna()]
        if rows.empty:
            raise NoData(f"{study}: no step has a finite {quantity}.")
        t, error = rows["t"].to_numpy(float), rows["value"].abs().to_numpy(float)
        color = next((c for chart, c in colours.items() if chart in text), GUIDE)
        error = np.maximum(error, LEAST)
        axes.plot(t, error, ".-", color=color, linewidth=0.6, markersize=3.0)
        if rows["status"].iloc[-1]:
            axes.plot(t[-1], error[-1], "X", color=color, markersize=7)
        ends.append(Label(float(t[-1]), float(error[-1]), text, color))
    axes.set(yscale="log", xlabel="time $t$", ylabel=f"relative {quantity}")
    decades(axes.yaxis)
    label_ends(axes, ends)


def _pairs(frame: pd.DataFrame, study: str, turn: str, change: str) -> pd.DataFrame:
    rows = pick(frame, study=study)
    if rows.empty:
        return pd.DataFrame({turn: [], change: []})
    wide = rows.pivot(index=["label", "t"], columns="quantity", values="value")
    return wide.dropna(subset=[turn, change])

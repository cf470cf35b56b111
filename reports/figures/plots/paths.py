"""Paths of the same bodies by several methods, one panel each."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.store.frames import pick
from reports.figures.style.layout import legend
from reports.figures.style.layout import panels as side_by_side
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import COLOURS, GUIDE, SUN


@dataclass(frozen=True)
class Panel:
    """Title; the study of its paths, followed by its continuations; half the width of the panel."""

    title: str
    studies: tuple[str, ...]
    half: float


def paths(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    panels: Sequence[Panel],
    bodies: Sequence[str],
    unit: str = "au",
) -> None:
    """Each body's positions as a line in its colour; the centre as a disc.

    A path with a continuation ends in a cross; continuations are thin.
    """
    places = side_by_side(axes, len(panels))
    for one, panel in zip(places, panels, strict=True):
        for k, body in enumerate(bodies):
            color, parts = COLOURS[k % len(COLOURS)], [_path(frame, s, body) for s in panel.studies]
            if not parts[0][0].size:
                raise NoData(f"{panel.title}: the positions of {body} are not known.")
            for rank, (x, y) in enumerate(parts):
                one.plot(x, y, color=color, linewidth=0.5 if rank else 0.7,
                         alpha=0.5 if rank else 0.9, zorder=2 - rank)  # fmt: skip
            if len(parts) > 1:
                one.plot(*(z[-1] for z in parts[0]), "X", color=color, markersize=6, zorder=3,
                         markeredgecolor="white", markeredgewidth=0.5)  # fmt: skip
        one.plot(0.0, 0.0, "o", color=SUN, markeredgecolor="#222222", markeredgewidth=0.5,
                 markersize=5)  # fmt: skip
        one.set(xlabel=f"$x$ [{unit}]", aspect="equal", title=panel.title)
        one.set(xlim=(-panel.half, panel.half), ylim=(-panel.half, panel.half))
        one.set_ylabel(f"$y$ [{unit}]")
    lines = [Line2D([], [], color=COLOURS[k % len(COLOURS)]) for k, _ in enumerate(bodies)]
    names = list(bodies)
    if any(len(panel.studies) > 1 for panel in panels):
        lines.append(Line2D([], [], color=GUIDE, marker="X", linestyle="none", markersize=6))
        names.append("the solver stops")
    legend(one, lines, names)


def _path(frame: pd.DataFrame, study: str, body: str) -> tuple[np.ndarray, np.ndarray]:
    rows = pick(frame, study=study, quantity="position", label=body).sort_values("t")
    rows = rows[np.isfinite(rows["x"]) & np.isfinite(rows["y"])]
    return rows["x"].to_numpy(float), rows["y"].to_numpy(float)

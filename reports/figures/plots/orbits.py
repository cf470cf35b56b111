"""Orbits projected on the x-y plane: curves, and the ends of the steps."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from reports.figures.style.layout import legend
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import COLOURS, SUN


def orbits(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    curve: str,
    ends: str,
    bodies: tuple[str, ...],
    centre: str,
    unit: str = "au",
) -> None:
    """The Galerkin curve of each body as a line, its step ends as dots, the centre as a disc.

    curve, ends  quantities of the frame with the body's name in `label`, its position in `x`, `y`
    """
    for k, body in enumerate(bodies):
        color = COLOURS[k % len(COLOURS)]
        x, y = _places(frame, curve, body)
        if not np.any(np.isfinite(y)):
            raise NoData(f"the positions of {body} are not known.")
        axes.plot(x, y, color=color, linewidth=0.7, alpha=0.6)
        axes.plot(*_places(frame, ends, body), ".", color=color, markersize=4.0, label=body)
    axes.plot(
        *(np.nanmean(part) for part in _places(frame, ends, centre)),
        "o",
        color=SUN,
        markeredgecolor="#222222",
        markeredgewidth=0.5,
        markersize=6,
    )
    axes.set(xlabel=f"$x$ [{unit}]", ylabel=f"$y$ [{unit}]", aspect="equal")
    axes.margins(0.06)
    legend(axes)


def _places(frame: pd.DataFrame, quantity: str, body: str) -> tuple[np.ndarray, np.ndarray]:
    rows = frame[(frame["quantity"] == quantity) & (frame["label"] == body)].sort_values("t")
    return rows["x"].to_numpy(float), rows["y"].to_numpy(float)

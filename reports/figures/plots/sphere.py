"""Paths of a body's axis on the sphere, in space: curves, and the ends of the steps."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.store.frames import pick
from reports.figures.style.layout import panels as side_by_side
from reports.figures.style.no_data import NoData
from reports.figures.style.palette import BAND, COLOURS, GUIDE

VIEW = {"elev": 18.0, "azim": -55.0}


def sphere(
    axes: Axes, frame: pd.DataFrame, *, panels: Mapping[str, str], curve: str, ends: str
) -> None:
    """One sphere for each study in ``panels`` (study -> title); z points down.

    curve, ends  quantities with points x, y, z on the unit sphere
    """
    places = side_by_side(axes, len(panels), projection="3d")
    for one, (study, title) in zip(places, panels.items(), strict=True):
        along, stops = (_places(frame, study, quantity) for quantity in (curve, ends))
        if not (len(along) and len(stops)):
            raise NoData(f"{study}: no position is known.")
        one.view_init(**VIEW)
        _globe(one)
        x, y, z = along.T
        one.plot(x, y, -z, color=COLOURS[0], linewidth=0.7, alpha=0.8)
        one.plot(*(stops * (1.0, 1.0, -1.0)).T, "o", color="#222222", markersize=3.0)
        one.plot(*(stops[0] * (1.0, 1.0, -1.0)).reshape(3, 1), "o", color=COLOURS[1], markersize=6)
        one.set_title(title, y=0.97)
        one.set_box_aspect((1, 1, 1), zoom=1.35)
        one.set_axis_off()


def _globe(one: Axes) -> None:
    """The sphere's surface, its equator and the vertical."""
    turn, rise = np.meshgrid(np.linspace(0.0, 2.0 * np.pi, 49), np.linspace(0.0, np.pi, 25))
    surface = np.sin(rise) * np.cos(turn), np.sin(rise) * np.sin(turn), np.cos(rise)
    one.plot_surface(*surface, color=BAND, alpha=0.35, linewidth=0.0, shade=False)
    around = np.linspace(0.0, 2.0 * np.pi, 121)
    style: dict[str, object] = {"color": GUIDE, "linewidth": 0.6}
    one.plot(np.cos(around), np.sin(around), 0.0 * around, **style)
    one.plot([0.0, 0.0], [0.0, 0.0], [-1.0, 1.0], linestyle=(0, (4, 3)), **style)


def _places(frame: pd.DataFrame, study: str, quantity: str) -> np.ndarray:
    rows = pick(frame, study=study, quantity=quantity).sort_values("t")
    places = rows[["x", "y", "z"]].to_numpy(float)
    return places[np.all(np.isfinite(places), axis=1)]

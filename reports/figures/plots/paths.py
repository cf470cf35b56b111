"""Paths in the plane and on the sphere, one panel for each method."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.store.frames import pick
from reports.figures.style.identities import BAND, COLOURS, GUIDE, SUN
from reports.figures.style.layout import NoData, legend, share_y_label
from reports.figures.style.layout import panels as side_by_side


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
    looks = {}
    for k, body in enumerate(bodies):
        color = COLOURS[k % len(COLOURS)]
        x, y = _places(frame, curve, body)
        if not np.any(np.isfinite(y)):
            raise NoData(f"the positions of {body} are not known.")
        axes.plot(x, y, color=color, linewidth=0.7, alpha=0.6)
        axes.plot(*_places(frame, ends, body), ".", color=color, markersize=4.0)
        looks[body] = Line2D([], [], color=color, marker="o", markersize=4.0, linewidth=0.7)
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
    legend(axes, looks.values(), looks)


def _places(frame: pd.DataFrame, quantity: str, body: str) -> tuple[np.ndarray, np.ndarray]:
    rows = frame[(frame["quantity"] == quantity) & (frame["label"] == body)].sort_values("t")
    return rows["x"].to_numpy(float), rows["y"].to_numpy(float)


@dataclass(frozen=True)
class Panel:
    """Title; the study of its paths; half the width of the panel; whether they stop early."""

    title: str
    study: str
    half: float
    stops: bool = False


def paths(
    axes: Axes,
    frame: pd.DataFrame,
    *,
    panels: Sequence[Panel],
    bodies: Sequence[str],
    unit: str = "au",
) -> None:
    """Each body's positions as a line in its colour, with a cross where it stops early; the centre
    as a disc."""
    places = side_by_side(axes, len(panels))
    share_y_label(places, f"$y$ [{unit}]")
    for one, panel in zip(places, panels, strict=True):
        for k, body in enumerate(bodies):
            color, (x, y) = COLOURS[k % len(COLOURS)], _path(frame, panel.study, body)
            if not x.size:
                raise NoData(f"{panel.title}: the positions of {body} are not known.")
            one.plot(x, y, color=color, linewidth=0.7, alpha=0.9)
            if panel.stops:
                one.plot(x[-1], y[-1], "X", color=color, markersize=6, zorder=3,
                         markeredgecolor="white", markeredgewidth=0.5)  # fmt: skip
        one.plot(0.0, 0.0, "o", color=SUN, markeredgecolor="#222222", markeredgewidth=0.5,
                 markersize=5)  # fmt: skip
        one.set(xlabel=f"$x$ [{unit}]", aspect="equal", title=panel.title)
        one.set(xlim=(-panel.half, panel.half), ylim=(-panel.half, panel.half))
    lines = [Line2D([], [], color=COLOURS[k % len(COLOURS)]) for k, _ in enumerate(bodies)]
    names = list(bodies)
    if any(panel.stops for panel in panels):
        lines.append(Line2D([], [], color=GUIDE, marker="X", linestyle="none", markersize=6))
        names.append("the solver stops")
    legend(one, lines, names)


def _path(frame: pd.DataFrame, study: str, body: str) -> tuple[np.ndarray, np.ndarray]:
    rows = pick(frame, study=study, quantity="position", label=body).sort_values("t")
    rows = rows[np.isfinite(rows["x"]) & np.isfinite(rows["y"])]
    return rows["x"].to_numpy(float), rows["y"].to_numpy(float)


VIEW = {"elev": 18.0, "azim": -55.0}


def sphere(
    axes: Axes, frame: pd.DataFrame, *, panels: Mapping[str, str], curve: str, ends: str
) -> None:
    """One sphere for each study in ``panels`` (study -> title); z points down.

    curve, ends  quantities with points x, y, z on the unit sphere
    """
    places = side_by_side(axes, len(panels), projection="3d")
    for one, (study, title) in zip(places, panels.items(), strict=True):
        along, stops = (_on_sphere(frame, study, quantity) for quantity in (curve, ends))
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


def _on_sphere(frame: pd.DataFrame, study: str, quantity: str) -> np.ndarray:
    rows = pick(frame, study=study, quantity=quantity).sort_values("t")
    places = rows[["x", "y", "z"]].to_numpy(float)
    return places[np.all(np.isfinite(places), axis=1)]

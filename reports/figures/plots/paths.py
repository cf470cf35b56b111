"""Paths of bodies in the plane, and grains in the air below a rotor."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.artist import Artist
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.applications.brownout.cloud import PILOT_EYE, SIGHT_TARGET
from benchmarks.store.tables import pick
from galvi.arrays import Array
from galvi.kernels.forces.rotor_wind import R, decay, rotor_height
from reports.figures.moving import in_frame
from reports.figures.style.identities import COLOURS, GUIDE, SUN
from reports.figures.style.layout import NoData, legend, split

INK = "#222222"


@dataclass(frozen=True)
class Panel:
    """Paths of one run.

    Attributes
    ----------
    title
        title above the panel
    study
        study of the table; each `label` is a body, with positions in x and y
    quantity
        quantity that is drawn as lines
    ends
        quantity that is drawn as dots, such as the ends of steps; "" for none
    half
        half the width of the panel, in the unit of the positions; 0 to fit the paths
    stops
        whether the paths end early; a cross is drawn at their last points
    """

    title: str
    study: str
    quantity: str = "position"
    ends: str = ""
    half: float = 0.0
    stops: bool = False


def paths(
    axes: Axes,
    table: pd.DataFrame,
    *,
    panels: Sequence[Panel],
    bodies: Sequence[str],
    unit: str = "au",
) -> None:
    """Draw each body's path as a line in its colour, and the origin as a disc.

    Raises NoData for a body without a finite position.
    """
    planes = split(axes, len(panels), ylabel=f"$y$ [{unit}]")
    for plane, panel in zip(planes, panels, strict=True):
        plane.set(xlabel=f"$x$ [{unit}]", aspect="equal", title=panel.title)
        for k, body in enumerate(bodies):
            color, (x, y) = COLOURS[k], _path(table, panel.study, panel.quantity, body)
            if not x.size:
                raise NoData(f"{panel.title or panel.study}: no position of {body} is known.")
            plane.plot(x, y, color=color, linewidth=0.7, alpha=0.8)
            legend(plane, [Line2D([], [], color=color)], [body])
            plane.plot(*_path(table, panel.study, panel.ends, body), ".", color=color, markersize=4)
            if panel.stops:
                plane.plot(
                    x[-1],
                    y[-1],
                    "X",
                    color=color,
                    markersize=6,
                    markeredgecolor="white",
                    markeredgewidth=0.5,
                    zorder=3,
                )
        plane.plot(0.0, 0.0, "o", color=SUN, markeredgecolor=INK, markeredgewidth=0.5, markersize=5)
        if panel.stops:
            cross = {"color": GUIDE, "marker": "X", "linestyle": "none", "markersize": 6}
            legend(plane, [Line2D([], [], **cross)], ["the solver stops"])
        if panel.half:
            plane.set(xlim=(-panel.half, panel.half), ylim=(-panel.half, panel.half))


def _path(table: pd.DataFrame, study: str, quantity: str, body: str) -> Array:
    """The finite positions (x, y) of a body in the order of time, (2, times)."""
    rows = pick(table, study=study, quantity=quantity, label=body).sort_values("t")
    return rows[["x", "y"]].dropna().to_numpy(float).T


HALF_WIDTH, HEIGHT = 20.0, 12.0  # m, half of the width


def clouds(
    axes: Axes, table: pd.DataFrame, *, study: str, labels: Sequence[str], times: Sequence[float]
) -> None:
    """Draw x and z of the grains in the air: a panel for each time, a colour for each label, the
    last label in front. The rotor is a line; the ray of the optical depth is dashed."""
    for plane, t in zip(split(axes, len(times)), times, strict=True):
        for artist in _draw_cloud(plane, table, study, labels, t):
            artist.set_rasterized(True)
        plane.plot(
            *zip(PILOT_EYE, SIGHT_TARGET, strict=True),
            color=GUIDE,
            linewidth=0.7,
            linestyle=(0, (4, 3)),
        )
        plane.set_title(f"{t:g} s")
    _add_size_entries(plane, labels)


def moving_cloud(axes: Axes, table: pd.DataFrame, *, study: str, labels: Sequence[str]) -> None:
    """Draw the grains as `clouds`, in one panel with a frame for each time of the study."""
    times = np.unique(pick(table, study=study)["t"])
    for k, t in enumerate(times):
        time_text = axes.text(-19.0, 10.8, f"{t:.2f} s")
        in_frame([*_draw_cloud(axes, table, study, labels, t), time_text], k, len(times))
    _add_size_entries(axes, labels)


def _draw_cloud(
    axes: Axes, table: pd.DataFrame, study: str, labels: Sequence[str], t: float
) -> list[Artist]:
    """Draw the rotor and the grains of each size at time t; returns the artists."""
    rows = pick(table, study=study, t=t).dropna(subset=["x", "z"])
    if rows.empty:
        raise NoData("no grain has a finite position.")
    axes.set(
        xlim=(-HALF_WIDTH, HALF_WIDTH),
        ylim=(0.0, HEIGHT),
        aspect="equal",
        xlabel="$x$ [m]",
        ylabel="$z$ [m]",
        xticks=[-20, -10, 0, 10, 20],
        yticks=[0, 5, 10],
    )
    grains = [
        axes.plot(
            rows_of_size["x"],
            rows_of_size["z"],
            ".",
            color=COLOURS[k],
            markersize=2.3,
            markeredgewidth=0.0,
        )
        for k, rows_of_size in enumerate(pick(rows, label=label) for label in labels)
    ]
    rotor = axes.plot([-R, R], [rotor_height(decay(t))] * 2, color=INK, linewidth=1.3)
    return [artist for drawn in (*grains, rotor) for artist in drawn]


def _add_size_entries(axes: Axes, labels: Sequence[str]) -> None:
    """Add an entry of the legend for each size."""
    for k, label in enumerate(labels):
        axes.plot([], [], "o", color=COLOURS[k], label=label.replace("micrometres", "µm"))

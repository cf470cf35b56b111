"""Body momenta in three dimensions, on the momentum sphere and the energy ellipsoids."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from benchmarks.store.frames import pick
from reports.figures.style.identities import COLOURS, GUIDE, line_color
from reports.figures.style.layout import NoData
from reports.figures.style.layout import panels as side_by_side

UP, ROUND = 22.0, -52.0  # elevation and azimuth of the view in degrees
SURFACE = 41  # points across a surface
FINE = 221  # likewise, where two surfaces intersect
SMOOTH = 241  # points of an exact curve
PALE_YELLOW, PALE_BLUE, DARK = "#f7e0ad", "#cfe6f5", "#003C66"
DOWN, ZOOM = 0.13, 1.1  # of the sphere, so that it fills its panel below the title
HIDDEN = 0.25  # opacity of a line behind the sphere


@dataclass(frozen=True)
class Sphere:
    """One panel.

    title      above it
    study      of the momenta, in x, y, z; each `label` is a path
    lines      join the momenta, which are otherwise dots on the exact curves
    ellipsoid  the label whose ellipsoid of energy is drawn too, with the paths of that energy only;
               "" for none
    half       half the width of the panel
    """

    title: str
    study: str
    lines: bool = False
    ellipsoid: str = ""
    half: float = 0.76


def momentum_spheres(
    axes: Axes, frame: pd.DataFrame, *, panels: Sequence[Sphere], inertia: Sequence[float]
) -> None:
    """The unit sphere in each panel; exact curves in grey, faint where they are hidden."""
    places = side_by_side(axes, len(panels), projection="3d", computed_zorder=False)
    for one, panel in zip(places, panels, strict=True):
        rows = pick(frame, study=panel.study, quantity="momentum")
        rows = rows[np.isfinite(rows["x"]) & np.isfinite(rows["y"]) & np.isfinite(rows["z"])]
        if rows.empty:
            raise NoData(f"{panel.title}: no momentum is known.")
        paths = [
            path[["x", "y", "z"]].to_numpy(float)
            for _, path in rows.sort_values("t").groupby("label", sort=True)
        ]
        levels = [_twice_energy(y[0], inertia) for y in paths]
        if panel.ellipsoid:
            start = rows[rows["label"] == panel.ellipsoid].sort_values("t").iloc[0]
            level = _twice_energy(start[["x", "y", "z"]].to_numpy(float), inertia)
            paths = [y for y, own in zip(paths, levels, strict=True) if np.isclose(own, level)]
            _both_surfaces(one, np.sqrt(level * np.array(inertia)))
        else:
            _surface(one)
        for y in paths:
            _line(one, exact_curve(y[0], inertia), GUIDE, 0.9)
            if panel.lines:
                _line(one, y, line_color(panel.title, 1), 0.8)
            else:
                _dots(one, y, DARK)
        one.view_init(UP, ROUND)
        one.set(xlim=(-panel.half, panel.half), ylim=(-panel.half, panel.half),
                zlim=((DOWN - 1.0) * panel.half, (DOWN + 1.0) * panel.half),
                title=panel.title)  # fmt: skip
        one.set_box_aspect((1, 1, 1), zoom=ZOOM)
        one.set_axis_off()
        for k, name in enumerate(("$y_1$", "$y_2$", "$y_3$")):
            tip = np.array([1.0, -1.0, 1.0])[k] * np.eye(3)[k]  # on the near side
            one.plot(*zip(tip, 1.15 * tip, strict=True), color="#222222", linewidth=0.7, zorder=9)
            one.text(*(1.28 * tip), f"$-${name}" if k == 1 else name, fontsize=8, ha="center",
                     va="center")  # fmt: skip


def exact_curve(y: np.ndarray, inertia: Sequence[float]) -> np.ndarray:
    """The intersection, through y, of y . y = 1 and sum y_i^2 / I_i constant, (SMOOTH, 3).

    About the stable axis c: y_a, y_b lie on an ellipse, since y_c^2 = 1 - y_a^2 - y_b^2.
    """
    reciprocal = 1.0 / np.array(inertia)
    y = y / np.linalg.norm(y)
    order = np.argsort(inertia)
    middle = reciprocal[order[1]]
    c = order[0] if np.sum(reciprocal * y**2) > middle else order[2]
    a, b = (k for k in range(3) if k != c)
    gaps = reciprocal - reciprocal[c]
    left = float(np.sum(gaps * y**2))
    phi = np.linspace(0.0, 2.0 * np.pi, SMOOTH)
    curve = np.zeros((SMOOTH, 3))
    curve[:, a] = np.sqrt(left / gaps[a]) * np.cos(phi)
    curve[:, b] = np.sqrt(left / gaps[b]) * np.sin(phi)
    rest = 1.0 - curve[:, a] ** 2 - curve[:, b] ** 2
    curve[:, c] = np.copysign(np.sqrt(np.maximum(rest, 0.0)), y[c])
    return curve


def _twice_energy(y: np.ndarray, inertia: Sequence[float]) -> float:
    return float(np.sum(y**2 / np.array(inertia)))


def _surface(axes: Axes) -> None:
    axes.plot_surface(*np.moveaxis(_directions(SURFACE), -1, 0), color=COLOURS[5], alpha=0.16,
                      linewidth=0.0, rstride=1, cstride=1, zorder=1, rasterized=True)  # fmt: skip


def _both_surfaces(axes: Axes, half_axes: np.ndarray) -> None:
    """The outer parts of the unit sphere and of the ellipsoid, each in its colour."""
    u = _directions(FINE)
    reach = 1.0 / np.linalg.norm(u / half_axes, axis=-1)
    colours = np.where((reach > 1.0)[..., None], to_rgba(PALE_YELLOW), to_rgba(PALE_BLUE))
    axes.plot_surface(*np.moveaxis(np.maximum(reach, 1.0)[..., None] * u, -1, 0),
                      facecolors=colours, linewidth=0.0, rstride=1, cstride=1, zorder=1,
                      antialiased=False, rasterized=True)  # fmt: skip


def _directions(points: int) -> np.ndarray:
    """(points, points, 3) of unit length."""
    u, v = np.linspace(0.0, 2.0 * np.pi, points), np.linspace(0.0, np.pi, points)
    parts = (np.outer(np.cos(u), np.sin(v)), np.outer(np.sin(u), np.sin(v)),
             np.outer(np.ones(points), np.cos(v)))  # fmt: skip
    return np.stack(parts, axis=-1)


def _in_front(y: np.ndarray) -> np.ndarray:
    """Which points are on the near side."""
    up, around = np.radians(UP), np.radians(ROUND)
    eye = np.array([np.cos(up) * np.cos(around), np.cos(up) * np.sin(around), np.sin(up)])
    return y @ eye >= 0.0


def _line(axes: Axes, y: np.ndarray, color: str, width: float) -> None:
    near = _in_front(y)
    far = ~near  # with both ends of a segment that leaves the near side, so that none is missing
    far[1:] |= ~near[:-1]
    far[:-1] |= ~near[1:]
    for seen, alpha, order in ((far, HIDDEN, 2), (near, 1.0, 3)):
        axes.plot(*np.where(seen[:, None], y, np.nan).T, color=color, linewidth=width, alpha=alpha,
                  zorder=order)  # fmt: skip


def _dots(axes: Axes, y: np.ndarray, color: str) -> None:
    near = _in_front(y)
    for seen, alpha, order in ((~near, HIDDEN, 2), (near, 1.0, 4)):
        axes.plot(*y[seen].T, ".", color=color, markersize=2.2, alpha=alpha, zorder=order,
                  markeredgewidth=0.0)  # fmt: skip

"""Paths on the unit sphere: momenta with the ellipsoids of their energy, and a pendulum's mass."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.colors import to_rgba

from benchmarks.store.tables import pick
from reports.figures.style.identities import COLOURS, GUIDE, line_color
from reports.figures.style.layout import NoData, split

ELEVATION, AZIMUTH = 22.0, -52.0  # elevation and azimuth of the view in degrees
VIEW_DIRECTION = np.array(
    [
        np.cos(np.radians(ELEVATION)) * np.cos(np.radians(AZIMUTH)),
        np.cos(np.radians(ELEVATION)) * np.sin(np.radians(AZIMUTH)),
        np.sin(np.radians(ELEVATION)),
    ]
)
SURFACE_POINTS, INTERSECTION_POINTS = (
    41,
    221,
)  # grid points in each direction of one surface, and of two that intersect
CURVE_POINTS = 241  # points of an exact curve
PALE_YELLOW, PALE_BLUE, DARK, INK = "#f7e0ad", "#cfe6f5", "#003C66", "#222222"
HALF_WIDTH, ZOOM, CENTRE_Z = (
    0.76,
    1.1,
    0.1,
)  # of the view, so that the sphere fills its panel below the title
HIDDEN_OPACITY = 0.25  # opacity of a line behind the sphere
DOT_STYLE: dict[str, Any] = {"marker": ".", "linestyle": "none", "markeredgewidth": 0.0}
POSITION = ["x", "y", "z"]
AXES = {"$y_1$": (1.0, 0.0, 0.0), "$-y_2$": (0.0, -1.0, 0.0), "$y_3$": (0.0, 0.0, 1.0)}


@dataclass(frozen=True)
class Sphere:
    """One panel of momenta.

    Attributes
    ----------
    title
        title above the panel
    study
        study of the momenta, in x, y, z; each `label` is a path
    lines
        whether lines join the momenta, which are otherwise dots on the exact curves
    ellipsoid
        the label of a path whose energy ellipsoid is drawn, too, with the paths of that energy
        alone; "" for the sphere and all paths
    """

    title: str
    study: str
    lines: bool = False
    ellipsoid: str = ""


def momentum_spheres(
    axes: Axes, table: pd.DataFrame, *, panels: Sequence[Sphere], inertia: Sequence[float]
) -> None:
    """Draw momenta on the unit sphere, with the exact curves in grey; lines behind it are faint.

    Raises NoData for a study without a finite momentum.
    """
    for sphere, panel in zip(_spheres(axes, len(panels)), panels, strict=True):
        paths = _paths(table, panel.study, "momentum")
        if not paths:
            raise NoData(f"{panel.title}: no momentum is known.")
        if panel.ellipsoid:
            level = _twice_energy(paths[panel.ellipsoid][0], inertia)
            paths = {
                label: y
                for label, y in paths.items()
                if np.isclose(_twice_energy(y[0], inertia), level)
            }
            _draw_sphere_and_ellipsoid(sphere, np.sqrt(level * np.array(inertia)))
        else:
            _draw_sphere(sphere)
        for y in paths.values():
            _draw_points(sphere, exact_curve(y[0], inertia), color=GUIDE, linewidth=0.9)
            if panel.lines:
                _draw_points(sphere, y, color=line_color(panel.title, 1), linewidth=0.8)
            else:
                _draw_points(sphere, y, color=DARK, markersize=2.2, **DOT_STYLE)
        sphere.set_title(panel.title)
        for name, tip in AXES.items():
            axis_ends = np.outer(tip, (1.0, 1.15))
            sphere.plot(*axis_ends, color=INK, linewidth=0.7, zorder=9)
            sphere.text(*(1.28 * np.array(tip)), name, fontsize=8, ha="center", va="center")


def pendulum_spheres(
    axes: Axes, table: pd.DataFrame, *, panels: Mapping[str, str], curve: str, ends: str
) -> None:
    """Draw a sphere for each study in `panels` (study -> title), with its first path; the table's z
    points downwards.

    Parameters
    ----------
    curve, ends
        quantities with points x, y, z on the unit sphere, drawn as a line and as dots
    """
    equator = np.pad(_circle(), ((0, 0), (0, 1)))
    for sphere, (study, title) in zip(_spheres(axes, len(panels)), panels.items(), strict=True):
        curves, end_points = (
            [y * (1.0, 1.0, -1.0) for y in _paths(table, study, quantity).values()]
            for quantity in (curve, ends)
        )
        if not (curves and end_points):
            raise NoData(f"{study}: no position is known.")
        _draw_sphere(sphere)
        _draw_points(sphere, equator, color=GUIDE, linewidth=0.6)
        sphere.plot(
            [0.0, 0.0], [0.0, 0.0], [-1.0, 1.0], color=GUIDE, linewidth=0.6, linestyle=(0, (4, 3))
        )
        _draw_points(sphere, curves[0], color=COLOURS[0], linewidth=0.7)
        _draw_points(sphere, end_points[0], color=INK, markersize=6.0, **DOT_STYLE)
        _draw_points(sphere, end_points[0][:1], color=COLOURS[1], markersize=12.0, **DOT_STYLE)
        sphere.set_title(title)


def _spheres(axes: Axes, count: int) -> list[Axes]:
    spheres = split(axes, count, projection="3d", computed_zorder=False)
    for sphere in spheres:
        sphere.view_init(ELEVATION, AZIMUTH)
        sphere.set(
            xlim=(-HALF_WIDTH, HALF_WIDTH),
            ylim=(-HALF_WIDTH, HALF_WIDTH),
            zlim=(CENTRE_Z - HALF_WIDTH, CENTRE_Z + HALF_WIDTH),
        )
        sphere.set_box_aspect((1, 1, 1), zoom=ZOOM)
        sphere.set_axis_off()
    return spheres


def _paths(table: pd.DataFrame, study: str, quantity: str) -> dict[str, np.ndarray]:
    """Label -> finite positions in the order of time, (times, 3)."""
    rows = pick(table, study=study, quantity=quantity).sort_values("t").dropna(subset=POSITION)
    return {str(label): path[POSITION].to_numpy(float) for label, path in rows.groupby("label")}


def exact_curve(y: np.ndarray, inertia: Sequence[float]) -> np.ndarray:
    """The points through y / |y| with y . y = 1 and constant sum of y_i^2 / I_i, (CURVE_POINTS, 3).

    The curve surrounds a stable axis c. Inserting y_c^2 = 1 - y_a^2 - y_b^2 shows that the other
    two components lie on an ellipse.
    """
    reciprocal = 1.0 / np.array(inertia)
    y = y / np.linalg.norm(y)
    order = np.argsort(inertia)
    middle_reciprocal = reciprocal[order[1]]
    stable_axis = order[0] if np.sum(reciprocal * y**2) > middle_reciprocal else order[2]
    ellipse_axes = [k for k in range(3) if k != stable_axis]
    reciprocal_gaps = reciprocal - reciprocal[stable_axis]
    half_axes = np.sqrt(np.sum(reciprocal_gaps * y**2) / reciprocal_gaps[ellipse_axes])
    curve = np.zeros((CURVE_POINTS, 3))
    curve[:, ellipse_axes] = half_axes * _circle()
    curve[:, stable_axis] = np.copysign(
        np.sqrt(np.maximum(1.0 - np.sum(curve**2, axis=1), 0.0)), y[stable_axis]
    )
    return curve


def _circle() -> np.ndarray:
    """Points of the unit circle, (CURVE_POINTS, 2)."""
    phi = np.linspace(0.0, 2.0 * np.pi, CURVE_POINTS)
    return np.stack([np.cos(phi), np.sin(phi)], axis=-1)


def _twice_energy(y: np.ndarray, inertia: Sequence[float]) -> float:
    return float(np.sum(y**2 / np.array(inertia)))


def _draw_sphere(axes: Axes) -> None:
    axes.plot_surface(
        *_directions(SURFACE_POINTS),
        color=COLOURS[5],
        alpha=0.16,
        linewidth=0.0,
        rstride=1,
        cstride=1,
        zorder=1,
        rasterized=True,
    )


def _draw_sphere_and_ellipsoid(axes: Axes, half_axes: np.ndarray) -> None:
    """Draw the outer parts of the unit sphere and of the ellipsoid, each in its colour."""
    u = _directions(INTERSECTION_POINTS)
    radius = 1.0 / np.linalg.norm(u / half_axes[:, None, None], axis=0)
    colours = np.where((radius > 1.0)[..., None], to_rgba(PALE_YELLOW), to_rgba(PALE_BLUE))
    axes.plot_surface(
        *(np.maximum(radius, 1.0) * u),
        facecolors=colours,
        linewidth=0.0,
        rstride=1,
        cstride=1,
        zorder=1,
        antialiased=False,
        rasterized=True,
    )


def _directions(points: int) -> np.ndarray:
    """Unit vectors on a grid of spherical angles, (3, points, points)."""
    u, v = np.meshgrid(
        np.linspace(0.0, 2.0 * np.pi, points), np.linspace(0.0, np.pi, points), indexing="ij"
    )
    return np.stack([np.cos(u) * np.sin(v), np.sin(u) * np.sin(v), np.cos(v)])


def _draw_points(axes: Axes, y: np.ndarray, **style: Any) -> None:
    """Draw the points y, (points, 3), as a line or dots, faint on the far side of the sphere."""
    visible = np.where((y @ VIEW_DIRECTION >= 0.0)[:, None], y, np.nan)
    axes.plot(*y.T, alpha=HIDDEN_OPACITY, zorder=2, **style)
    axes.plot(*visible.T, zorder=3, **style)

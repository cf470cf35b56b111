"""Moving pictures of galvi's curves: planets in 100-day steps, and a tumbling body.

They are made from the tables of claims V9 and L9; nothing is integrated for the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.vector_spaces import v09_solar_system_in_long_steps as v09
from benchmarks.store.tables import pick
from benchmarks.studies.long_steps import CURVE, ENDS
from galvi.arrays import Array
from reports.figures.style.identities import COLOURS, SUN
from reports.results.claim_results import ClaimResult

PATH_POINTS = 600  # approximate number of points of a path
SIZE = 400  # width and height of the picture, in units of its coordinates
MARGIN = 14  # in the same units
ELEVATION, AZIMUTH = (
    np.radians(18.0),
    np.radians(-55.0),
)  # elevation and azimuth of the view of the sphere


@dataclass(frozen=True)
class Path:
    """The path of a body in the picture's coordinates: points at equal intervals of time, and ends
    of steps."""

    points: tuple[tuple[float, float], ...]
    stops: tuple[tuple[float, float], ...]
    color: str
    width: float

    @property
    def line(self) -> str:
        """The path as the attribute d of SVG."""
        return "M" + "L".join(f"{x:g} {y:g}" for x, y in self.points)


@dataclass(frozen=True)
class Motion:
    """A moving picture.

    Attributes
    ----------
    still
        SVG elements that do not move
    dot, moving
        radii of the dots at step ends, and of the moving bodies
    box
        the viewBox of the SVG
    """

    name: str
    title: str
    caption: str
    alternative: str
    paths: tuple[Path, ...]
    still: tuple[Markup, ...]
    dot: float
    moving: float = 5.0
    box: str = f"0 0 {SIZE} {SIZE}"


def motions(checked: Sequence[ClaimResult]) -> list[Motion]:
    """The moving pictures whose claims were measured."""
    tables = {
        claim_result.claim.id: claim_result.table
        for claim_result in checked
        if claim_result.table is not None
    }
    pictures = []
    if "V9" in tables:
        pictures.append(_motion_of_planets(tables["V9"]))
    if "L9" in tables:
        pictures.append(_motion_of_body(tables["L9"]))
    return [picture for picture in pictures if picture is not None]


def _motion_of_planets(table) -> Motion | None:  # type: ignore[no-untyped-def]
    curves = [
        _finite_positions(pick(table, quantity=CURVE, label=body), "xy") for body in v09.INNER
    ]
    ends = [_finite_positions(pick(table, quantity=ENDS, label=body), "xy") for body in v09.INNER]
    if not all(map(len, (*curves, *ends))):
        return None
    half_width = max(float(np.abs(curve).max()) for curve in curves)
    paths = tuple(
        Path(
            _points(curve, half_width, PATH_POINTS * 3), _points(stops, half_width), COLOURS[k], 0.5
        )
        for k, (curve, stops) in enumerate(zip(curves, ends, strict=True))
    )
    sun = Markup('<circle cx="{0}" cy="{0}" r="6" fill="{1}" stroke="#222" stroke-width=".6"/>')
    return Motion(
        "planets",
        f"The inner planets in {v09.STEPS} steps of {v09.STEP:g} days",
        f"Small dots: the ends of the steps, one in {v09.STEP:g} days, longer than Mercury's year "
        "of 88; the planets move along the curves of the steps.",
        "Mercury, Venus, Earth and Mars move round the Sun on closed orbits; of the dots, which "
        "mark the ends of the steps, fewer than one belongs to a revolution of Mercury.",
        paths,
        (sun.format(SIZE // 2, SUN), *map(_name_above, paths, v09.INNER)),
        2.0,
    )


def _name_above(path: Path, body: str) -> Markup:
    """The body's name above the top of its path."""
    x, y = min(path.points, key=lambda point: point[1])
    text = '<text x="{0:g}" y="{1:g}" font-size="11" text-anchor="middle" fill="{2}">{3}</text>'
    return Markup(text).format(x, max(y - 4.0, 11.0), path.color, body)


def _motion_of_body(table) -> Motion | None:  # type: ignore[no-untyped-def]
    rows = pick(table, study=l09.named(l09.DRAWN, "Cayley"))
    curve, stops = (
        _finite_positions(pick(rows, quantity=name), "xyz") for name in (l09.CURVE, l09.ENDS)
    )
    if not (len(curve) and len(stops)):
        return None
    path = Path(
        _points(_projected(curve), 1.0, 2 * PATH_POINTS),
        _points(_projected(stops), 1.0),
        COLOURS[0],
        0.9,
    )
    centre, radius = SIZE / 2, SIZE / 2 - MARGIN
    globe = Markup('<circle cx="{0:g}" cy="{0:g}" r="{1:g}" fill="#eef3f7" stroke="#bbb"/>')
    equator = Markup(
        '<ellipse cx="{0:g}" cy="{0:g}" rx="{1:g}" ry="{2:g}" fill="none" stroke="#bbb"/>'
    )
    return Motion(
        "body",
        f"A heavy body tumbling, in steps of {l09.STEP:g}",
        f"The centre of mass on the sphere round its pivot over {l09.SHOWN} steps from upside "
        "down. Black dots: ends of the steps, of almost half a turn; line: the curve on the group.",
        "A point moves on a sphere along a curve that passes through dots, the ends of the steps; "
        "from one to the next the body turns by up to half a turn.",
        (
            Path(path.points, (), path.color, path.width),
            Path(path.points[:1], path.stops, "#222", 0),
        ),
        (globe.format(centre, radius), equator.format(centre, radius, radius * np.sin(ELEVATION))),
        2.0,
    )


def _finite_positions(rows, axes: str) -> Array:  # type: ignore[no-untyped-def]
    positions = rows.sort_values("t")[list(axes)].to_numpy(float)
    return positions[np.all(np.isfinite(positions), axis=1)]


def _projected(positions: Array) -> Array:
    """Points on the sphere, z downwards, (n, 3), projected along the view, (n, 2)."""
    x, y, z = positions.T * np.array([1.0, 1.0, -1.0])[:, None]
    right = -np.sin(AZIMUTH) * x + np.cos(AZIMUTH) * y
    depth = np.cos(AZIMUTH) * x + np.sin(AZIMUTH) * y
    return np.column_stack((right, np.cos(ELEVATION) * z - np.sin(ELEVATION) * depth))


def _points(
    positions: Array, half_width: float, approximate_count: int | None = None
) -> tuple[tuple[float, float], ...]:
    """Points in the picture's coordinates, y downwards; half is the largest coordinate shown.

    With `approximate_count`, every k-th point is taken, so that about that many remain, or up to
    twice as many.
    """
    thinned = (
        positions
        if approximate_count is None
        else positions[:: max(1, len(positions) // approximate_count)]
    )
    scaled = SIZE / 2 + (SIZE / 2 - MARGIN) * thinned / half_width * np.array([1.0, -1.0])
    return tuple((round(float(x), 1), round(float(y), 1)) for x, y in scaled)

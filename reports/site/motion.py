"""Moving pictures from galvi's own curves: planets in 100-day steps, a tumbling body.

Both come from the tables of claims V9 and L9, so that nothing is integrated for the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from markupsafe import Markup

from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.vector_spaces import v09_solar_system_in_long_steps as v09
from benchmarks.store.frames import pick
from benchmarks.studies.long_steps import CURVE, ENDS
from galvi.arrays import Array
from reports.figures.style.identities import COLOURS, SUN
from reports.results.claim_results import ClaimResult

POINTS = 600  # of a moving body's path
SIZE = 400  # of the picture, in its own unit
MARGIN = 14
UP, AROUND = np.radians(18.0), np.radians(-55.0)  # of the view of the sphere


@dataclass(frozen=True)
class Path:
    """The path of one body in the picture's coordinates: points in equal times, and step ends."""

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
    """A moving picture; still: SVG elements that do not move; dot: radius of a step's end;
    moving: of a body."""

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
        pictures.append(_planets(tables["V9"]))
    if "L9" in tables:
        pictures.append(_body(tables["L9"]))
    return [picture for picture in pictures if picture is not None]


def _planets(table) -> Motion | None:  # type: ignore[no-untyped-def]
    curves = [_places(pick(table, quantity=CURVE, label=body), "xy") for body in v09.INNER]
    ends = [_places(pick(table, quantity=ENDS, label=body), "xy") for body in v09.INNER]
    if not all(map(len, (*curves, *ends))):
        return None
    half = max(float(np.abs(curve).max()) for curve in curves)
    paths = tuple(
        Path(_points(curve, half, POINTS * 3), _points(stops, half), COLOURS[k], 0.5)
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
        (sun.format(SIZE // 2, SUN), *map(_name, paths, v09.INNER)),
        2.0,
    )


def _name(path: Path, body: str) -> Markup:
    """The body's name above the top of its path."""
    x, y = min(path.points, key=lambda point: point[1])
    text = '<text x="{0:g}" y="{1:g}" font-size="11" text-anchor="middle" fill="{2}">{3}</text>'
    return Markup(text).format(x, max(y - 4.0, 11.0), path.color, body)


def _body(table) -> Motion | None:  # type: ignore[no-untyped-def]
    rows = pick(table, study=l09.named(l09.DRAWN, "Cayley"))
    curve, stops = (_places(pick(rows, quantity=name), "xyz") for name in (l09.CURVE, l09.ENDS))
    if not (len(curve) and len(stops)):
        return None
    path = Path(
        _points(_projected(curve), 1.0, 2 * POINTS),
        _points(_projected(stops), 1.0),
        COLOURS[0],
        0.9,
    )
    middle, radius = SIZE / 2, SIZE / 2 - MARGIN
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
        (globe.format(middle, radius), equator.format(middle, radius, radius * np.sin(UP))),
        2.0,
    )


def _places(rows, axes: str) -> Array:  # type: ignore[no-untyped-def]
    places = rows.sort_values("t")[list(axes)].to_numpy(float)
    return places[np.all(np.isfinite(places), axis=1)]


def _projected(places: Array) -> Array:
    """Points of the sphere, z downwards, projected as in the figures."""
    x, y, z = places.T * np.array([1.0, 1.0, -1.0])[:, None]
    right = -np.sin(AROUND) * x + np.cos(AROUND) * y
    depth = np.cos(AROUND) * x + np.sin(AROUND) * y
    return np.column_stack((right, np.cos(UP) * z - np.sin(UP) * depth))


def _points(
    places: Array, half: float, at_most: int | None = None
) -> tuple[tuple[float, float], ...]:
    """Points in the picture's coordinates, y downwards; thinned to equal strides."""
    chosen = places if at_most is None else places[:: max(1, len(places) // at_most)]
    scaled = SIZE / 2 + (SIZE / 2 - MARGIN) * chosen / half * np.array([1.0, -1.0])
    return tuple((round(float(x), 1), round(float(y), 1)) for x, y in scaled)

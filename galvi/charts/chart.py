"""Charts of Lie groups, Cayley's, the exponential, and modified Rodrigues parameters: their maps,
with inverse and derivative, between elements and coordinates."""

from __future__ import annotations

from collections.abc import Hashable
from dataclasses import dataclass
from typing import Any, ClassVar, Protocol

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.compile.jit import jit
from galvi.kernels.constants import TWO_PI
from galvi.kernels.lie import product
from galvi.kernels.lie.charts import cayley, exponential, modified_rodrigues
from galvi.kernels.lie.dispatch import CHARTS, angle_of, coordinate_of
from galvi.kernels.lie.product import GROUPS


class Chart(Hashable, Protocol):
    """A map Phi from the algebra to the group with Phi(0) = 1 and derivative 1 there (H 3.2.2)."""

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'Cayley'."""

    @property
    def number(self) -> int:
        """Index in galvi.kernels.lie.dispatch.CHARTS."""

    @property
    def limit(self) -> float:
        """The rotation angle, in radians, at which the map or its tangent becomes singular."""

    @property
    def farthest(self) -> float:
        """The largest |xi| that a rotation may have within a step."""


class MovingChart(Hashable, Protocol):
    """Coordinates that move with an integrable flow, see `galvi.frames.frame.Frame`."""

    @property
    def name(self) -> str:
        """For titles and tables, e.g. 'harmonic frame'."""

    @property
    def passes(self) -> int | None:
        """Passes of a step's iteration; None: as many as the tolerance needs."""


@dataclass(frozen=True)
class Cayley:
    """``Phi(xi) = (I - hat(xi) / 2)^-1 (I + hat(xi) / 2)``, ``|xi| = 2 tan(angle / 2)`` (H 3.4.2).

    Rational and therefore the fastest chart; a step must rotate by less than pi, half a turn. H's
    xi is half of galvi's, with the opposite sign.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.Cayley())
    >>> galvi.integrate(galvi.problems.pendulum_3d(), method, step=0.1, steps=20).status
    'Completed.'
    """

    name: ClassVar[str] = "Cayley"
    number: ClassVar[int] = CHARTS.index(cayley)
    limit: ClassVar[float] = cayley.SINGULAR_ANGLE
    farthest: ClassVar[float] = cayley.LARGEST_IN_STEP


@dataclass(frozen=True)
class Exponential:
    """``Phi(xi) = exp(hat(xi))``, ``|xi| = angle``; a step must rotate by less than 2 pi (claim
    L14).

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), galvi.Exponential())
    >>> galvi.integrate(galvi.problems.free_rigid_body(), method, step=0.5, steps=20).status
    'Completed.'
    """

    name: ClassVar[str] = "exponential"
    number: ClassVar[int] = CHARTS.index(exponential)
    limit: ClassVar[float] = exponential.SINGULAR_ANGLE
    farthest: ClassVar[float] = exponential.LARGEST_IN_STEP


@dataclass(frozen=True)
class ModifiedRodrigues:
    """The Cayley transform squared, Phi(xi) = ((I - hat(xi) / 4)^-1 (I + hat(xi) / 4))^2.

    ``|xi| = 4 tan(angle / 4)``. Rational, like the Cayley chart; a step must rotate by less than
    2 pi. The modified Rodrigues parameters are xi / 4 (Schaub and Junkins, J. Astronautical
    Sciences 44 (1996) 1).

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8), galvi.ModifiedRodrigues())
    >>> galvi.integrate(galvi.problems.free_rigid_body(), method, step=0.8, steps=20).status
    'Completed.'
    """

    name: ClassVar[str] = "modified Rodrigues"
    number: ClassVar[int] = CHARTS.index(modified_rodrigues)
    limit: ClassVar[float] = modified_rodrigues.SINGULAR_ANGLE
    farthest: ClassVar[float] = modified_rodrigues.LARGEST_IN_STEP


def place(chart: Chart, group: Group, g: Any, xi: Any) -> Array:
    """g Phi(xi), for g (..., *group.shape) and xi (..., d) with the same leading axes."""
    xi = np.asarray(xi, dtype=np.float64)
    rows = xi.reshape(-1, group.dimension).copy()
    out = np.empty((len(rows), _entries(group)))
    _place_all(group.layout, chart.number, _flat(g, out.shape), rows, out)
    return out.reshape(*xi.shape[:-1], *group.shape)


def tangent(chart: Chart, group: Group, xi: Any) -> Array:
    """T(xi), (..., d, d), with g^-1 g' = T(xi) xi' along g = Phi(xi), for xi (..., d)."""
    xi = np.asarray(xi, dtype=np.float64)
    rows, d = xi.reshape(-1, group.dimension).copy(), group.dimension
    out = np.empty((len(rows), d, d))
    _tangent_all(group.layout, chart.number, rows, np.eye(d), out)
    return np.swapaxes(out, 1, 2).reshape(*xi.shape, d)


def coordinates(chart: Chart, group: Group, g: Any, k: Any) -> Array:
    """xi (..., d) with k = g Phi(xi), for elements k (..., *group.shape), and g of the same shape
    or one element."""
    lead = np.shape(k)[: np.ndim(k) - len(group.shape)]
    shape = (int(np.prod(lead)), _entries(group))
    out = np.empty((shape[0], group.dimension))
    _coordinates_all(group.layout, chart.number, _flat(g, shape), _flat(k, shape), out)
    return out.reshape(*lead, group.dimension)


def _entries(group: Group) -> int:
    return int(np.prod(group.shape))


def _flat(g: Any, shape: tuple[int, int]) -> Array:
    flat = np.asarray(g, dtype=np.float64).reshape(-1, shape[1])
    return np.broadcast_to(flat, shape).copy()


@jit
def _place_all(layout, chart, g, xi, out):  # type: ignore[no-untyped-def]
    for k in range(out.shape[0]):
        product.place(layout, chart, g[k], xi[k], out[k])


@jit
def _tangent_all(layout, chart, xi, units, out):  # type: ignore[no-untyped-def]
    for k in range(xi.shape[0]):
        for i in range(units.shape[0]):
            product.velocity(layout, chart, xi[k], units[i], out[k, i])


@jit
def _coordinates_all(layout, chart, g, k, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        product.coordinates(layout, chart, g[row], k[row], out[row])


def unwrapped(chart: Chart, group: Group, xi: Array) -> Array:
    """Coordinates (k, d) of a path from 0, with their rotations made continuous.

    A rotation by an angle about an axis is also one by angle - 2 pi m; the m nearest to the
    coordinates before is taken, and the translation of a rigid motion is changed to match. The
    rotation must stay below the chart's limit, except in the exponential chart, whose map extends
    beyond it.
    """
    path, start = xi.copy(), 0
    for number, d, _, rotations in group.layout:
        factor = path[:, start : start + d]
        for k in range(_first_change(chart, factor[:, :rotations]), len(path)):
            w = _nearest_to(chart, factor[k - 1, :rotations], factor[k, :rotations])
            if w is not None:
                GROUPS[number].with_rotation(chart.number, factor[k].copy(), w, factor[k])
        start += d
    return path


def _first_change(chart: Chart, w: Array) -> int:
    """The index of the first row of w (k, 3 or 1) that `_nearest_to` may change; k where it changes
    none, or w has no columns.

    Most paths need no change, and testing whole arrays is ten times as fast as a loop.
    """
    if w.shape[1] == 0:
        return len(w)
    size = np.linalg.norm(w, axis=1)
    angle = np.array([angle_of(chart.number, x) for x in size.tolist()])
    previous, current = size[:-1], size[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(current > 0.0, np.sum(w[:-1] * w[1:], axis=1) / (previous * current), 1.0)
        changed = (np.round((angle[:-1] * cosine - angle[1:]) / TWO_PI) != 0.0) & (previous > 0.0)
    return 1 + int(np.argmax(changed)) if np.any(changed) else len(w)


def _nearest_to(chart: Chart, previous: Array, current: Array) -> Array | None:
    """The coordinates nearest to ``previous`` of the rotation with the coordinates ``current``;
    None where these are nearest already."""
    size, previous_size = float(np.linalg.norm(current)), float(np.linalg.norm(previous))
    if previous_size == 0.0:
        return None
    axis = current / size if size > 0.0 else previous / previous_size
    angle, before = (angle_of(chart.number, x) for x in (size, previous_size))
    turns = round((before / previous_size * float(previous @ axis) - angle) / TWO_PI)
    return coordinate_of(chart.number, angle + turns * TWO_PI) * axis if turns else None

"""Charts of Lie groups (Cayley, exponential, modified Rodrigues): the map from coordinates to group
elements, its inverse and its derivative. H is Hall's dissertation (2013)."""

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
    """A map Phi from the algebra to the group with Phi(0) = 1 and derivative 1 there (H 3.2.2).

    `place`, `tangent` and `coordinates` evaluate it.
    """

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

    Rational, and the cheapest of the three; a step must rotate by less than 0.995 pi. H's xi is
    half of galvi's, with the opposite sign.

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
    """``Phi(xi) = exp(hat(xi))``, ``|xi| = angle``; a step must rotate by less than 1.99 pi
    (claim L14).

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
    1.99 pi. The modified Rodrigues parameters are xi / 4 (Schaub and Junkins, J. Astronautical
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
    """g Phi(xi) (..., *group.shape), for xi (..., d) and one g, or one for each xi."""
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


def coordinates(chart: Chart, group: Group, g: Any, target: Any) -> Array:
    """xi (..., d) with target = g Phi(xi), for elements ``target`` (..., *group.shape), and g of
    the same shape or one element."""
    lead = np.shape(target)[: np.ndim(target) - len(group.shape)]
    shape = (int(np.prod(lead)), _entries(group))
    out = np.empty((shape[0], group.dimension))
    _coordinates_all(group.layout, chart.number, _flat(g, shape), _flat(target, shape), out)
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
def _coordinates_all(layout, chart, g, targets, out):  # type: ignore[no-untyped-def]
    for row in range(out.shape[0]):
        product.coordinates(layout, chart, g[row], targets[row], out[row])


def unwrapped(chart: Chart, group: Group, xi: Array) -> Array:
    """A copy of the coordinates xi (n, d) of a path from 0, with their rotations made continuous.

    A rotation by an angle about an axis is also one by angle + 2 pi m: m is chosen so that the
    rotation is nearest to that of the row before, and the translation of a rigid motion is changed
    to match. A row that follows a row of zeros is left unchanged. The rotation must stay below the
    chart's limit, except in the exponential chart, whose map extends beyond it.
    """
    path, start = xi.copy(), 0
    for group_number, d, _, rotation_size in group.layout:
        factor = path[:, start : start + d]
        for row in range(_first_change(chart, factor[:, :rotation_size]), len(path)):
            w = _unwrapped_row(chart, factor[row - 1, :rotation_size], factor[row, :rotation_size])
            if w is not None:
                GROUPS[group_number].with_rotation(chart.number, factor[row].copy(), w, factor[row])
        start += d
    return path


def _first_change(chart: Chart, w: Array) -> int:
    """The index of the first row of w (n, 3 or 1) that `_unwrapped_row` may change; n where it
    changes none, or w has no columns.

    Most paths need no change, and testing most rows at once is ten times as fast as a loop.
    """
    if w.shape[1] == 0:
        return len(w)
    norm = np.linalg.norm(w, axis=1)
    angle = np.array([angle_of(chart.number, x) for x in norm.tolist()])
    previous, current = norm[:-1], norm[1:]
    with np.errstate(divide="ignore", invalid="ignore"):
        cosine = np.where(current > 0.0, np.sum(w[:-1] * w[1:], axis=1) / (previous * current), 1.0)
        changed = (np.round((angle[:-1] * cosine - angle[1:]) / TWO_PI) != 0.0) & (previous > 0.0)
    return 1 + int(np.argmax(changed)) if np.any(changed) else len(w)


def _unwrapped_row(chart: Chart, previous: Array, current: Array) -> Array | None:
    """The coordinates (3,) or (1,), nearest to ``previous``, of the rotation ``current``.

    None where ``current`` is the nearest already, and where ``previous`` is 0.
    """
    norm, previous_norm = float(np.linalg.norm(current)), float(np.linalg.norm(previous))
    if previous_norm == 0.0:
        return None
    axis = current / norm if norm > 0.0 else previous / previous_norm
    angle, previous_angle = (angle_of(chart.number, x) for x in (norm, previous_norm))
    along = previous_angle / previous_norm * float(previous @ axis)
    turns = round((along - angle) / TWO_PI)
    return coordinate_of(chart.number, angle + turns * TWO_PI) * axis if turns else None

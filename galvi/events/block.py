"""What is known of a function on each of many steps: a sign that it keeps, or an interpolant."""

from __future__ import annotations

from functools import lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import Curves, IdentityChart
from galvi.events.asked import Asked
from galvi.events.entries import Entry, LaterEntry
from galvi.events.pieces import Piece
from galvi.method import Galerkin
from galvi.spaces.polynomials import ComponentPolynomials, Polynomials

CHUNK = 2048  # steps searched at once
RESOLVED = 1e-9  # last coefficients of an interpolant, relative to its largest, that are small
DOUBLINGS = 3  # of the points of a step whose interpolant is not resolved
ROUNDING = 1e-12  # of a bound, within which it is 0


class Block:
    """Up to CHUNK steps of a piece."""

    def __init__(self, piece: Piece, first: int, method: Galerkin) -> None:
        self.piece, self.first, self.method = piece, first, method
        times = piece.times[first : first + CHUNK + 1]
        self.begin, self.end = times[:-1], times[1:]
        self.direct = isinstance(piece.curves, Curves) and isinstance(
            piece.curves.chart, IdentityChart
        )
        self._bounds: Any = None

    def series(self, asked: Asked, start: float) -> tuple[Array, Any, Array, int]:
        """Coefficients (k, points) of interpolants on the steps that may have a root, the numbers
        of these steps here (k,), values or signs (n + 1,) between steps, and how many are rough.

        start  the value, or the sign, at the end of the steps before; 0 where there are none
        """
        n = len(self.begin)
        joint, sure = self._joint(asked), np.zeros(n)
        if self.direct and not asked.refusal:
            sure = self._sure(asked, joint)
            sure[0] = 0.0 if sure[0] * start < 0.0 else sure[0]
        steps = np.flatnonzero(sure == 0.0)
        found = self._interpolants(asked, steps) if steps.size else np.zeros((0, 2))
        if joint is None:
            ends = np.zeros((n, 2))
            ends[:] = sure[:, None]
            ends[steps] = np.stack([_values(found, -1.0), _values(found, 1.0)], axis=1)
            joint = np.append(start or ends[0, 0], ends[:, 1])
            outside = np.flatnonzero((sure[1:] != 0.0) & (sure[:-1] == 0.0)) + 1
            joint[outside] = sure[outside]
        elif steps.size:
            off = joint[steps] - _values(found, -1.0), joint[steps + 1] - _values(found, 1.0)
            found[:, 0] += 0.5 * (off[0] + off[1])
            found[:, 1] += 0.5 * (off[1] - off[0])
        return found, steps, joint, int(np.sum(~is_resolved(found)))

    def _joint(self, asked: Asked) -> Array | None:
        """The function at the ends of steps, where they are known."""
        piece = self.piece
        if piece.q is None or piece.v is None:
            return None
        rows = slice(self.first, self.first + len(self.begin) + 1)
        q, v = (x[rows].reshape(len(self.begin) + 1, -1).T for x in (piece.q, piece.v))
        return asked.many(q, v, piece.times[rows])

    def _sure(self, asked: Asked, joint: Array | None) -> Array:
        """The sign (n,) that the function keeps on each step, ends included; 0 where that is not
        known, or a step before had another."""
        if not isinstance(self.method.space, Polynomials | ComponentPolynomials):
            return np.zeros(len(self.begin))
        low, high = asked.bounds(*self._box(), len(self.begin))
        slack = ROUNDING * np.maximum(np.abs(low), np.abs(high))
        with np.errstate(invalid="ignore"):
            sure = np.where(low > slack, 1.0, 0.0) - np.where(high < -slack, 1.0, 0.0)
        if joint is not None:
            return np.where((sure * joint[:-1] > 0.0) & (sure * joint[1:] > 0.0), sure, 0.0)
        sure[1:][sure[1:] * sure[:-1] < 0.0] = 0.0
        return sure

    def _box(self) -> tuple[Any, Any, Entry]:
        """Entries that are bounds of each step: coordinates, velocities and the time."""
        if self._bounds is None:
            curves: Any = self.piece.curves
            rows = slice(self.first, self.first + len(self.begin))
            own, rates = _series_of(curves.space, 4 * self.method.stages)
            bases = curves.bases[rows].reshape(len(self.begin), -1)
            parts = curves.coefficients[rows]

            def place(k: int) -> LaterEntry:
                return LaterEntry(lambda: _around(bases[:, k], parts[:, k] @ own))

            def rate(k: int) -> LaterEntry:
                return LaterEntry(lambda: _around(0.0, parts[:, k] @ rates / curves.step))

            both = np.empty((2, bases.shape[1]), dtype=object)
            both[:] = [[one(k) for k in range(bases.shape[1])] for one in (place, rate)]
            time = Entry(np.minimum(self.begin, self.end), np.maximum(self.begin, self.end))
            self._bounds = both[0], both[1], time
        found: tuple[Any, Any, Entry] = self._bounds
        return found

    def _interpolants(self, asked: Asked, steps: Any) -> Array:
        points = 4 * self.method.stages
        found = self._sampled(asked, steps, points)
        for _ in range(DOUBLINGS):
            rough = np.flatnonzero(~is_resolved(found))
            if not rough.size:
                break
            points *= 2
            wider = np.zeros((len(steps), points))
            wider[:, : found.shape[1]] = found
            wider[rough] = self._sampled(asked, steps[rough], points)
            found = wider
        return found

    def _sampled(self, asked: Asked, steps: Any, points: int) -> Array:
        """Coefficients (k, points) of the function's interpolants on some steps (k,)."""
        x, matrix = _points(points)
        share = 0.5 * (1.0 + x)
        begin, k = self.begin[steps], len(steps)
        t = begin[:, None] + share * (self.end[steps] - begin)[:, None]
        if self.direct:
            curves: Any = self.piece.curves
            places, rates = _basis(curves.space, points)
            parts = curves.coefficients[self.first + steps]
            bases = curves.bases[self.first + steps].reshape(k, -1, 1)
            q, v = bases + parts @ places, parts @ rates / curves.step
        else:
            q, v = (
                value(t.ravel()).reshape(k, points, -1).transpose(0, 2, 1)
                for value in (self.piece.curves.position, self.piece.curves.velocity)
            )
        found: Array = asked.many(q.transpose(1, 0, 2), v.transpose(1, 0, 2), t) @ matrix.T
        return found


@lru_cache(maxsize=16)
def _points(n: int) -> tuple[Array, Array]:
    """Chebyshev points in (-1, 1), and the matrix from values there to coefficients."""
    angle = np.pi * (np.arange(n) + 0.5) / n
    matrix = 2.0 / n * np.cos(np.arange(n)[:, None] * angle)
    matrix[0] *= 0.5
    return np.cos(angle), matrix


@lru_cache(maxsize=16)
def _basis(space: Any, n: int) -> tuple[Array, Array]:
    """The basis functions of a step's curve, less their values at its start, and their
    derivatives, (m, n) at the Chebyshev points."""
    share = np.append(0.5 * (1.0 + _points(n)[0]), 0.0)
    basis, slope = space.basis(share)[:, 1:], space.derivative(share)[:-1, 1:]
    return (basis[:-1] - basis[-1]).T.copy(), slope.T.copy()


@lru_cache(maxsize=16)
def _series_of(space: Any, n: int) -> tuple[Array, Array]:
    """Their Chebyshev coefficients (m, n), without those that are 0 of all."""
    both = [values @ _points(n)[1].T for values in _basis(space, n)]
    width = 1 + max(int(np.flatnonzero(np.abs(x).max(axis=0) > 1e-14)[-1]) for x in both)
    return both[0][:, :width].copy(), both[1][:, :width].copy()


def _around(middle: Any, series: Array) -> tuple[Array, Array]:
    """Bounds of Chebyshev series (n, terms) about ``middle``: each polynomial is within 1."""
    far = np.abs(series[:, 1:]) @ np.ones(series.shape[1] - 1)
    middle = middle + series[:, 0]
    return middle - far, middle + far


def is_resolved(coefficients: Array) -> Any:
    sizes = np.abs(coefficients)
    return sizes[:, -3:].max(axis=1) <= RESOLVED * sizes.max(axis=1)


def _values(coefficients: Array, end: float) -> Array:
    found: Array = coefficients @ (end ** np.arange(coefficients.shape[1]))
    return found

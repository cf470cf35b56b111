"""What is known of a function on each of many steps: a sign that it keeps, or an interpolant."""

from __future__ import annotations

from functools import cache, cached_property, lru_cache, partial
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.curves.curves import Curves, IdentityChart
from galvi.events.asked import Function
from galvi.events.entries import Entry, LaterEntry
from galvi.events.pieces import Piece
from galvi.events.roots import points_of
from galvi.kernels.curve_bounds import compiled_curve_bounds
from galvi.method import Galerkin
from galvi.run.states import saved_velocities
from galvi.spaces.polynomials import ComponentPolynomials, Polynomials

CHUNK = 8192  # steps searched at once
SAMPLED = 512  # and sampled
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
        self.bounded = self.direct and isinstance(method.space, Polynomials | ComponentPolynomials)

    def series(self, asked: Function, start: float) -> tuple[Array, Any, Array, int]:
        """Coefficients (k, points) of interpolants on the steps that may have a root, the numbers
        of these steps here (k,), values or signs (n + 1,) between steps, and how many are rough.

        start  the value, or the sign, at the end of the steps before; 0 where there are none
        """
        sure = np.zeros(len(self.begin))
        if self.bounded and not asked.refusal:
            sure = self._sure(asked)
            sure[1:][sure[1:] * sure[:-1] < 0.0] = 0.0
            sure[0] = 0.0 if sure[0] * start < 0.0 else sure[0]
        steps = np.flatnonzero(sure == 0.0)
        if not steps.size:
            return np.zeros((0, 2)), steps, np.append(sure, sure[-1]), 0
        joint = self._joint(asked, sure)
        steps = np.flatnonzero(sure == 0.0)
        found = self._interpolants(asked, steps)
        if joint is None:
            ends = np.stack([sure, sure], axis=1)
            ends[steps] = found @ _ends(found.shape[1])
            joint = np.append(start or ends[0, 0], ends[:, 1])
            outside = np.flatnonzero((sure[1:] != 0.0) & (sure[:-1] == 0.0)) + 1
            joint[outside] = sure[outside]
        else:
            off = np.stack([joint[steps], joint[steps + 1]], axis=1) - found @ _ends(found.shape[1])
            found[:, :2] += off @ np.array([[0.5, -0.5], [0.5, 0.5]])
        return found, steps, joint, int(np.sum(~is_resolved(found)))

    def _joint(self, asked: Function, sure: Array) -> Array | None:
        """The function at the ends of steps, where it is known, and its sign at those of steps that
        are sure; those that such an end belies are so no longer."""
        run, times = self.piece.run, self.piece.times
        if not self.piece.known:
            return None
        joint, known = np.append(sure, sure[-1]), np.zeros(len(sure) + 1, dtype=bool)
        while True:
            ends = np.append(sure == 0.0, False)
            ends[1:] |= sure == 0.0
            new = np.flatnonzero(ends & ~known)
            if not new.size:
                return joint
            rows = self.first + new
            joint[new] = asked.of(run.q[rows], saved_velocities(run, rows), times[rows])
            known = ends
            for end, seen in ((joint[:-1], ends[:-1]), (joint[1:], ends[1:])):
                sure[seen & (end * sure <= 0.0)] = 0.0

    def _sure(self, asked: Function) -> Array:
        """The sign (n,) that the function keeps on each step, ends included; 0 where that is not
        known."""
        low, high = asked.bounds(*self._box)
        with np.errstate(invalid="ignore"):
            above = (low > 0.0) & (low > ROUNDING * high)
            return 1.0 * above - 1.0 * ((high < 0.0) & (high < ROUNDING * low))

    @cached_property
    def _box(self) -> tuple[Any, Any, Entry]:
        """Entries that are bounds of each step: coordinates, velocities and the time."""
        curves: Any = self.piece.curves
        rows = slice(self.first, self.first + len(self.begin))
        parts, bases = curves.coefficients[rows], curves.bases[rows].reshape(len(self.begin), -1)
        (n, d, _), (places, rates) = parts.shape, _spans(curves.space, 4 * self.method.stages)
        rates = np.stack([rates[0] / curves.step, rates[1] / abs(curves.step)])

        @cache
        def around(fast: bool) -> tuple[Array, Array]:
            low, high = np.empty((d, n)), np.empty((d, n))
            base, spans = (np.zeros((1, d)), rates) if fast else (bases, places)
            compiled_curve_bounds()(base, parts, *spans, low, high)
            return low, high

        both = np.empty((2, d), dtype=object)
        both[:] = [
            [LaterEntry(partial(around, fast), k) for k in range(d)] for fast in (False, True)
        ]
        time = Entry(np.minimum(self.begin, self.end), np.maximum(self.begin, self.end))
        return both[0], both[1], time

    def _interpolants(self, asked: Function, steps: Any) -> Array:
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

    def _sampled(self, asked: Function, steps: Any, points: int) -> Array:
        """Coefficients (k, points) of the function's interpolants on some steps (k,)."""
        if len(steps) > SAMPLED:
            return np.concatenate([self._sampled(asked, steps[k : k + SAMPLED], points)
                                   for k in range(0, len(steps), SAMPLED)])  # fmt: skip
        x, matrix = points_of(points)
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
        return asked.at(q.transpose(1, 0, 2), v.transpose(1, 0, 2), t) @ matrix.T


@lru_cache(maxsize=16)
def _basis(space: Any, n: int) -> tuple[Array, Array]:
    """The basis functions of a step's curve, less their values at its start, and their
    derivatives, (m, n) at the Chebyshev points."""
    share = np.append(0.5 * (1.0 + points_of(n)[0]), 0.0)
    basis, slope = space.basis(share)[:, 1:], space.derivative(share)[:-1, 1:]
    return (basis[:-1] - basis[-1]).T.copy(), slope.T.copy()


@lru_cache(maxsize=16)
def _spans(space: Any, n: int) -> tuple[Array, Array]:
    """Of each of them two numbers (2, m): how far it is, at most, from the one by the other. These
    are its first Chebyshev coefficient and the sum of the other ones' sizes."""
    both = (values @ points_of(n)[1].T for values in _basis(space, n))
    places, rates = (np.stack([x[:, 0], np.abs(x[:, 1:]).sum(axis=1)]) for x in both)
    return places, rates


def is_resolved(coefficients: Array) -> Any:
    sizes = np.abs(coefficients)
    return sizes[:, -3:].max(axis=1) <= RESOLVED * sizes.max(axis=1)


def _ends(n: int) -> Array:
    """The values (n, 2) of the first n polynomials at -1 and 1."""
    return np.stack([(-1.0) ** np.arange(n), np.ones(n)], axis=1)

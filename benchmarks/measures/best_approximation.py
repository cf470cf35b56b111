"""Best polynomial approximation of a motion on K subintervals, and the error of a step.

M's norm on a subinterval of length h: |u|_X^2 = int |u'|^2 dt + |u(h)|^2 / h (M section 2). The
best polynomial of degree N has u's value at the end, and as derivative the orthogonal projection of
u' on degree N - 1.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np
from numpy.polynomial.legendre import leggauss, legvander

from galvi import Trajectory
from galvi.arrays import Array

Motion = Callable[[Array], tuple[Array, Array]]
GAUSS_POINTS = 24  # Gauss points in each piece of a subinterval between kinks


def best_errors(motion: Motion, edges: Array, degree: int, kinks: Sequence[float] = ()) -> Array:
    """inf |u - v|_X over polynomials v of this degree, for each subinterval, (K,).

    Parameters
    ----------
    motion
        function t -> (u, u'), of t's shape
    edges : array, shape (K + 1,)
        ends of the subintervals, increasing
    kinks
        times at which u is not smooth, at most one in each subinterval, whose quadrature is split
    """
    starts, stops = edges[:-1], edges[1:]
    errors = residual_norms(motion, *_nodes(starts, stops), starts, stops, degree)
    for kink in kinks:
        for k in np.flatnonzero((starts < kink) & (kink < stops)):
            start, stop = starts[k : k + 1], stops[k : k + 1]
            parts = [_nodes(start, np.array([kink])), _nodes(np.array([kink]), stop)]
            t, w = (np.concatenate(part, axis=1) for part in zip(*parts, strict=True))
            errors[k] = residual_norms(motion, t, w, start, stop, degree)[0]
    return errors


def step_error(run: Trajectory, motion: Motion, kinks: Sequence[float] = ()) -> float:
    """|u - u_N|_X of the first step of a run with one component; quadrature is split at kinks."""
    start, stop = float(run.t[0]), float(run.t[1])
    ends = np.array([start, *(kink for kink in kinks if start < kink < stop), stop])
    return error_at(run, motion, *(part.ravel() for part in _nodes(ends[:-1], ends[1:])))


def error_at(run: Trajectory, motion: Motion, t: Array, w: Array) -> float:
    """`step_error` by quadrature with nodes t and weights w."""
    gap = motion(t)[1] - run.velocity(t)[:, 0]
    end = float(motion(run.t[1:2])[0][0]) - run.q[1, 0]
    return float(np.sqrt(np.sum(w * gap**2) + end**2 / (run.t[1] - run.t[0])))


def residual_norms(
    motion: Motion, t: Array, w: Array, starts: Array, stops: Array, degree: int
) -> Array:
    """Norms (K,) of the residuals of projections of u', with quadrature nodes t and weights w,
    (K, p) each."""
    residual, h = motion(t)[1], (stops - starts)[:, None]
    P = legvander(2.0 * (t - starts[:, None]) / h - 1.0, degree - 1)
    scale = (2.0 * np.arange(degree) + 1.0) / h
    for _ in range(2):  # the second pass removes the rounding errors of the first
        parts = scale * np.einsum("kpi,kp->ki", P, w * residual)
        residual = residual - np.einsum("kpi,ki->kp", P, parts)
    return np.sqrt(np.sum(w * residual**2, axis=1))


def _nodes(starts: Array, stops: Array) -> tuple[Array, Array]:
    """Gauss points and weights of each interval, (K, GAUSS_POINTS)."""
    x, w = leggauss(GAUSS_POINTS)
    half = 0.5 * (stops - starts)[:, None]
    return starts[:, None] + half * (1.0 + x), half * w

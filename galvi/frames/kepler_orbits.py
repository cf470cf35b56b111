"""Kepler's orbits on arrays, real or complex: analytic, for derivatives by complex steps.

Near a parabola the places are those of galvi.kernels.lanes.frames.near_parabola.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.kernels.lanes.frames import universal
from galvi.kernels.lanes.frames.kepler_drift import NEAR
from galvi.kernels.lanes.frames.near_parabola import follow_each

CORRECTIONS = 60
TERMS = 10


class Orbits(NamedTuple):
    """Places and velocities (k, D, n) after a time, and what a pull-back takes (k, n)."""

    places: Array
    speeds: Array
    known: tuple[Array, Array, Array, Array, Array]


@np.errstate(invalid="ignore", over="ignore")  # of steps that failed, which hold NaN
def orbits(
    mu: Array, q: Array, v: Array, t: Array, low: tuple[Array, Array] | None = None
) -> Orbits:
    """The orbits after times t (k, 1) from q and v (k, D, n), and from their low parts if given."""
    r0 = np.sqrt(np.sum(q * q, axis=1))
    eta, beta = np.sum(q * v, axis=1), 2.0 * mu / r0 - np.sum(v * v, axis=1)
    zeta = mu - beta * r0
    X, solved = t * beta / mu, False
    for _ in range(CORRECTIONS):
        G = universal.universal(beta, X, TERMS)
        step = universal.far_correction(beta, r0, eta, zeta, X, G, t, lambda x, y: x / y, np.sqrt)
        X = X + step
        if solved:
            break
        solved = bool(np.all(np.abs(step) <= 1e-15 * np.abs(X)))  # imaginary parts need one more
    G1, G2, G3, _, _ = G = universal.universal(beta, X, TERMS)
    r = r0 + eta * G1 + zeta * G2
    Q = q * (1.0 - mu * G2 / r0)[:, None] + v * (t - mu * G3)[:, None]
    V = v * (1.0 - mu * G2 / r)[:, None] - q * (mu * G1 / (r * r0))[:, None]
    near = np.minimum(np.real(r0), np.real(r)) * np.abs(beta) < (
        NEAR * mu if mu.size > 1 else np.inf
    )
    k, i = np.nonzero(near)
    lows = low or (np.zeros(q.shape), np.zeros(q.shape))
    states = np.zeros((k.size, 8, q.shape[1]))
    for row, part in zip(range(4, 8), (q, lows[0], v, lows[1]), strict=True):
        states[:, row] = np.real(part[k, :, i])
    follow_each(mu[i], np.real(t[k, 0]), states)
    places = states[:, 4]
    if np.iscomplexobj(Q):
        since = np.imag(t[k])
        turned = states[:, 6] * since
        if mu.size > 1:  # others change the start too
            turned += np.imag(Q[k, :, i]) - np.real(V[k, :, i]) * since
        places = places + 1j * turned
    Q[k, :, i] = places
    return Orbits(Q, V, (G2, universal.lag(mu, X, G, t), mu * G3 - t, r / mu, 1.0 / r0))


def pulled_back(mu: Array, q: Array, v: Array, after: Orbits, a: Array) -> tuple[Array, Array]:
    """The changes (k, D, n) of q and v for changes a of the velocities after the orbits."""
    vectors = (q, v, after.places, after.speeds, a)
    q0, v0, Q, V, kick = (np.moveaxis(x, 1, 0) for x in vectors)
    changes = universal.pull_back(mu, *after.known, q0, v0, Q, V, kick, _dot)
    places, speeds = (np.stack(part, axis=1) for part in changes)
    return places, speeds


def attraction(strengths: Array, q: Any) -> Array:
    """The accelerations of point masses at q (k, bodies, D), of the given masses times G."""
    gap = q[:, None] - q[:, :, None]  # from the second to the third of the axes
    square = np.sum(gap * gap, axis=-1)
    bodies = np.arange(q.shape[1])
    square[:, bodies, bodies] = 1.0
    pulls: Array = np.einsum("j,kijx->kix", strengths, gap * (square**-1.5)[..., None])
    return pulls


def _dot(a: Any, b: Any) -> Any:
    return sum(x * y for x, y in zip(a, b, strict=True))

"""Orbits about a fixed centre by implicit Euler, each step solved in closed form.

A step x = c - h^2 mu x / |x|^3 with c = q + h v has its solution along c, at the distance r with
r + a / r^2 = |c|, a = h^2 mu. The left side is smallest at r = (2 a)^(1/3), where it is
3/2 (2 a)^(1/3): for smaller |c| a step has no solution, for larger |c| it has two. The larger one
tends to c as h tends to 0; the smaller one is near the centre.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from benchmarks.claims.kit import Array, Problem

DAYS_PER_YEAR = 365.25  # in a year
PRINTED_STEP = 0.005  # H's h, without a unit
YEARS_PER_UNIT = 0.5 / np.pi  # years, in which G = 1
INNER = ("Mercury", "Venus", "Earth", "Mars")
DURATION_YEARS = 20.0
SMALLER = (
    "least share of steps whose smaller solution throws the planet out, Mercury, Venus, Earth and "
    "Mars, implicit Euler"
)


def least_solvable(mu: Any, h: Any) -> Any:
    """3/2 (2 h^2 mu)^(1/3), the smallest |q + h v| for which a step has a solution."""
    return 1.5 * np.cbrt(2.0 * h**2 * mu)


def distances(size: Array, a: Array) -> tuple[Array, Array]:
    """The larger and the smaller solution r of r + a / r^2 = size; NaN where there is none.

    They are Viete's roots of the cubic r^3 - size r^2 + a = 0, which has three real roots if there
    are solutions.
    """
    with np.errstate(invalid="ignore"):
        turn = np.arccos(1.0 - 13.5 * a / size**3) / 3.0
    third = size / 3.0
    return third * (1.0 + 2.0 * np.cos(turn)), third * (1.0 + 2.0 * np.cos(turn - 2.0 * np.pi / 3))


def follow(
    q: Array, v: Array, mu: Array, h: Array, duration: float, smaller_at: Array | None = None
) -> tuple[Array, Array, Array]:
    """Follow orbits over the duration, or up to a step that has no solution.

    Parameters
    ----------
    q, v : array, shape (k, d)
    mu, h : array, shape (k,)
    smaller_at
        for each orbit the step, counted from 1, that takes the smaller solution; None for none

    Returns
    -------
    steps, largest, last : array, shape (k,)
        The number of steps before the one without a solution, -1 if all steps have one; the largest
        specific energy, above 0 for a planet that can escape; and the last specific energy.
    """
    counts = np.floor(duration / h + 0.5).astype(int)
    solved, live = np.zeros(h.size, int), np.arange(h.size)
    largest, last = np.full((2, h.size), -np.inf)
    for step in range(1, int(counts.max()) + 1):
        c = q + h[live, None] * v
        size = np.linalg.norm(c, axis=1)
        r, smaller = distances(size, h[live] ** 2 * mu[live])
        if smaller_at is not None:
            r = np.where(smaller_at[live] == step, smaller, r)
        continues = np.isfinite(r) & (step <= counts[live])
        live, r = live[continues], r[continues]
        q = c[continues] * (r / size[continues])[:, None]
        v = v[continues] - (h[live] * mu[live] / r**3)[:, None] * q
        last[live] = 0.5 * np.sum(v * v, axis=1) - mu[live] / r
        largest[live], solved[live] = np.maximum(largest[live], last[live]), step
        if not live.size:
            break
    return np.where(solved < counts, solved, -1), largest, last


def two_body(
    system: Any, h: Array, years: float = DURATION_YEARS, smaller_at: Array | None = None
) -> tuple[Array, Array, Array]:
    """As `follow`, for the inner planets about the Sun alone, in au and years: arrays (4 k,), for
    each planet those of all h (k,)."""
    masses = system.system.masses
    q, v = ((x[1:5] - x[0]).repeat(h.size, axis=0) for x in (system.q0, system.v0 * DAYS_PER_YEAR))
    mu = (masses[0] + masses[1:5]).repeat(h.size) * DAYS_PER_YEAR**2
    return follow(q, v, mu, np.tile(h, len(INNER)), years, smaller_at)


def escapes(system: Problem, count: int) -> dict[str, float]:
    """Fractions of orbits of the inner planets that gain the energy to escape.

    With the larger solution of every step, the fraction over planets and `count` step sizes from
    0.002 to 0.05 years and more; with the smaller solution once, at h = PRINTED_STEP, the smallest
    fraction, over the planets, of the steps at which that throws the planet out.
    """
    h = np.unique([*np.geomspace(2e-3, 0.05, count), PRINTED_STEP, PRINTED_STEP * YEARS_PER_UNIT])
    shares = []
    for k, stop in enumerate(two_body(system, np.array([PRINTED_STEP]))[0]):
        smaller_steps = np.tile(np.arange(1, stop + 1), len(INNER))
        orbits = two_body(
            system, np.full(stop, PRINTED_STEP), (stop + 100) * PRINTED_STEP, smaller_steps
        )
        shares.append(np.mean(orbits[1].reshape(len(INNER), -1)[k] > 0.0))
    return {
        "share of inner planets and h with energy to escape, larger solution of every step, "
        "implicit Euler": np.mean(two_body(system, h)[1] > 0.0),
        SMALLER: min(shares),
    }

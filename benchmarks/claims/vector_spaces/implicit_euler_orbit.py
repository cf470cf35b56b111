"""Orbits about a fixed centre by implicit Euler, each step solved in closed form.

A step x = c - h^2 mu x / |x|^3 with c = q + h v has its solution along c, at the distance r with
r + a / r^2 = |c|, a = h^2 mu. The left side is least at r = (2 a)^(1/3), where it is
3/2 (2 a)^(1/3): below that |c| a step has no solution at all, above it has two. The larger is the
one that tends to c as h tends to 0; the smaller is next to the centre.
"""

from __future__ import annotations

from benchmarks.claims.kit import *


def least_solvable(mu: Array, h: Array) -> Array:
    """3/2 (2 h^2 mu)^(1/3): the least |q + h v| from which a step has a solution."""
    return 1.5 * np.cbrt(2.0 * h**2 * mu)


def distances(size: Array, a: Array) -> tuple[Array, Array]:
    """The larger and the smaller solution r of r + a / r^2 = size, NaN where there is none.

    Vieta's form of the cubic r^3 - size r^2 + a = 0, which has three real roots then.
    """
    with np.errstate(invalid="ignore"):
        turn = np.arccos(1.0 - 13.5 * a / size**3) / 3.0
    third = size / 3.0
    return third * (1.0 + 2.0 * np.cos(turn)), third * (1.0 + 2.0 * np.cos(turn - 2.0 * np.pi / 3))


@dataclass(frozen=True, eq=False)
class Orbits:
    """What became of orbits, one for each start.

    unsolved  steps done before the one that has no solution; -1 where all were done
    energy    the largest specific energy over the steps, above 0 for one that may escape
    last      the energy after the last step that was done
    """

    unsolved: Array
    energy: Array
    last: Array

    @property
    def escaped(self) -> Array:
        """Whether every step was solved and the last energy is above 0."""
        return (self.unsolved < 0) & (self.last > 0.0)


def follow(
    q: Array, v: Array, mu: Array, h: Array, duration: float, smaller_at: Array | None = None
) -> Orbits:
    """Follow orbits over the duration, or up to the step that has no solution.

    q, v  (k, d); mu, h (k,)
    smaller_at  steps, counted from 1, that take the smaller solution; the larger where left out
    """
    q, v, a = q.copy(), v.copy(), h**2 * mu
    counts = np.floor(duration / h + 0.5).astype(int)
    unsolved = np.full(h.size, -1)
    energy = np.full(h.size, -np.inf)
    last = energy.copy()
    live = np.arange(h.size)
    for step in range(1, int(counts.max()) + 1):
        live = live[step <= counts[live]]
        c = q[live] + h[live, None] * v[live]
        size = np.sqrt(np.einsum("kd,kd->k", c, c))
        r, smaller = distances(size, a[live])
        unsolved[live[np.isnan(r)]] = step - 1
        if smaller_at is not None:
            r = np.where(smaller_at[live] == step, smaller, r)
        solved = ~np.isnan(r)
        live, c, r, size = live[solved], c[solved], r[solved], size[solved]
        if not live.size:
            break
        q[live] = c * (r / size)[:, None]
        v[live] -= (h[live] * mu[live] / r**3)[:, None] * q[live]
        now = 0.5 * np.einsum("kd,kd->k", v[live], v[live]) - mu[live] / r
        energy[live], last[live] = np.maximum(energy[live], now), now
    return Orbits(unsolved, energy, last)

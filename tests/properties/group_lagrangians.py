"""A Lagrangian on any group, whose mass and force depend on the configuration and the time."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from galvi.kernels.compile.jit import jit
from galvi.kernels.lie import product
from galvi.tracing.laws_of_systems import lines_of
from tests.properties.group_matrices import element

GROUPS: dict[str, Any] = {
    "SO3": galvi.SO3(),
    "SE3": galvi.SE3(),
    "SE2": galvi.SE2(),
    "SO2 x R2": galvi.Product((galvi.SO2(), galvi.Rn(2))),
    "SO3 x R1": galvi.Product((galvi.SO3(), galvi.Rn(1))),
    "SE3 x R1": galvi.Product((galvi.SE3(), galvi.Rn(1))),  # more columns than are written out
}
LAW = """from galvi.lanes.elementary import cos
from galvi.lanes.group_collocation import Chart

chart = Chart({layout}, 0)


def law(g, v, t, c):
    # {remark}
    d, r, first = {d}, {r}, 1 + 4 * len(chart.factors)
    c = [c[first + k] for k in range(r + d * d)]
    s, square = c[0] * g[0], v[0] * v[0]
    for k in range(1, r):
        s = s + c[k] * g[k]
    for i in range(1, d):
        square = square + v[i] * v[i]
    slope = 0.2 * s * square - cos(t) - s
    mass = [[c[r + d * i + j] for j in range(i + 1)] for i in range(d)]
    for i in range(d):
        mass[i][i] = mass[i][i] + 0.2 * (s * s)
    full = [[mass[max(i, j)][min(i, j)] for j in range(d)] for i in range(d)]
    mu = [sum(row[j] * v[j] for j in range(1, d)) + row[0] * v[0] for row in full]
    return chart.left_derivative(g, [c[k] * slope for k in range(r)]), mu, mass
"""


@jit
def slopes(g, v, t, constants, out):
    """Rows dL/dv and the left-trivialised dL/dg; constants: 4 x factors, the layout, c, A."""
    r, d, factors = g.size, v.size, int(constants[0])
    layout = np.empty((factors, 4), np.int64)
    for k in range(4 * factors):
        layout[k // 4, k % 4] = int(constants[1 + k])
    c = constants[1 + 4 * factors :]
    s, square, slope = 0.0, 0.0, np.empty(r)
    for k in range(r):
        s += c[k] * g[k]
    for i in range(d):
        square += v[i] * v[i]
    for k in range(r):
        slope[k] = c[k] * (0.2 * s * square - np.cos(t) - s)
    product.left_derivative(layout, g, slope, out[1])
    for i in range(d):
        out[0, i] = 0.2 * s * s * v[i]
        for j in range(d):
            out[0, i] += c[r + d * i + j] * v[j]


@dataclass(frozen=True, eq=False)
class Swelling:
    """L = v.Av/2 + (s |v|)^2/10 - s cos(t) - s^2/2, s = c . g, on a group of the above."""

    group: Any
    c: Any
    A: Any
    remark: str = "none"

    def __call__(self, q, v, t):
        s = self.c @ q.ravel()
        return float(0.5 * v @ self.A @ v + 0.1 * s * s * (v @ v) - s * np.cos(t) - 0.5 * s * s)

    def slopes(self, q, v, t):
        """dL/dv, then dL/dq."""
        s = self.c @ q.ravel()
        slope = 0.2 * s * (v @ v) - np.cos(t) - s
        return np.concatenate([self.A @ v + 0.2 * s * s * v, slope * self.c])

    def at_states(self, q, v, t):
        """L at v and at rest, and dL/dv, at several states."""
        s = q.reshape(len(q), -1) @ self.c
        mu = v @ self.A + 0.2 * (s * s)[:, None] * v
        kinetic = 0.5 * np.sum(v * (v @ self.A), axis=1) + 0.1 * s * s * np.sum(v * v, axis=1)
        at_rest = -s * np.cos(t) - 0.5 * s * s
        return kinetic + at_rest, at_rest, mu

    def compiled(self):
        """The slopes for the general kernel."""
        layout = self.group.layout
        head = [len(layout), *layout.ravel()]
        return slopes, np.concatenate([head, self.c, self.A.ravel()]).astype(float)


@lines_of.register
def _(value: Swelling) -> str:
    g = value.group
    return LAW.format(layout=g.layout.tolist(), d=g.dimension, r=value.c.size, remark=value.remark)


def swelling(name: str, seed: int, remark: str = "none") -> galvi.Problem:
    """A problem on the group with this name; another remark is another source."""
    random, group = np.random.default_rng(seed), GROUPS[name]
    d, r = group.dimension, int(np.prod(group.shape))
    root = 0.3 * random.normal(size=(d, d))
    found = Swelling(group, 0.4 * random.normal(size=r), np.eye(d) + root @ root.T, remark)
    system = galvi.Lagrangian(found, group, explicit_time=True)
    return galvi.Problem(
        system, element(group, random.normal(size=d)), 0.6 * random.normal(size=d), t0=0.3
    )

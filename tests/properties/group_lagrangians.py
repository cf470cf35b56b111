"""A Lagrangian on any group, whose mass and force depend on the configuration and the time."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from tests.properties.group_matrices import element

GROUPS: dict[str, Any] = {
    "SO3": galvi.SO3(),
    "SE3": galvi.SE3(),
    "SE2": galvi.SE2(),
    "SO2 x R2": galvi.Product((galvi.SO2(), galvi.Rn(2))),
    "SO3 x R1": galvi.Product((galvi.SO3(), galvi.Rn(1))),
    "SE3 x R1": galvi.Product((galvi.SE3(), galvi.Rn(1))),  # more columns than are written out
}


def swelling(name: str, seed: int, beat: Callable[[Any], Any] = np.cos) -> galvi.Problem:
    """L = v.Av/2 + (s |v|)^2/10 - s beat(t) - s^2/2, s = c . g, on the group with this name."""
    random, group = np.random.default_rng(seed), GROUPS[name]
    d, r = group.dimension, int(np.prod(group.shape))
    root, c = 0.3 * random.normal(size=(d, d)), 0.4 * random.normal(size=r)
    A = np.eye(d) + root @ root.T

    def L(q: Any, v: Any, t: Any) -> Any:
        s = c @ np.asarray(q).ravel()
        return 0.5 * v @ (A @ v) + 0.1 * s * s * (v @ v) - s * beat(t) - 0.5 * s * s

    system = galvi.Lagrangian(L, group, explicit_time=True)
    return galvi.Problem(
        system, element(group, random.normal(size=d)), 0.6 * random.normal(size=d), t0=0.3
    )

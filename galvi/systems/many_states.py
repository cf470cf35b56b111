"""Values, momenta and velocities of a Lagrangian's states, all at once where it has derivatives."""

from __future__ import annotations

from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.systems.builtin_lagrangian import BuiltinLagrangian, KnownMass
from galvi.systems.difference_scales import difference_scales
from galvi.systems.legendre_transform import SOLVED

SEVERAL = 8  # states, from which it pays
PASSES, MOVE = 12, 1e-5  # of Newton's method; share of a velocity by which momenta are differenced
ROUNDING = 1e-12  # relative residual below which stagnation is round-off


def values_and_momenta(
    system: Any, q: Array | None, v: Array, t: Any
) -> tuple[Array, Array] | None:
    """L (...) and dL/dv (..., d) at states with any axes in front, or None: where the Lagrangian
    does not bring its derivatives, states are few, or one is not finite."""
    rates = v.reshape(-1, system.group.dimension)
    if q is None or system.slopes is not None or system.builtin is None or len(rates) < SEVERAL:
        return None
    if not (np.all(np.isfinite(q)) and np.all(np.isfinite(v))):
        return None
    times = np.array(np.broadcast_to(t, v.shape[:-1]), dtype=np.float64).ravel()
    L = cast(BuiltinLagrangian, system.builtin)
    value, _, momenta = L.at_states(q.reshape(-1, *system.group.shape), rates, times)
    return value.reshape(v.shape[:-1]), momenta.reshape(v.shape)


def velocities(system: Any, q: Array | None, p: Array, t: Any, near: Array) -> Array | None:
    """The velocities with dL/dv = p (..., d), by Newton's method from ``near`` (d,) for all states;
    None where `values_and_momenta` is, or where that does not find one of them."""
    v = np.array(np.broadcast_to(near, p.shape))
    if values_and_momenta(system, q, v, t) is None or not np.all(np.isfinite(p)):
        return None
    places = cast(Array, q).reshape(-1, *system.group.shape)

    def momenta(rates: Array) -> Array:
        found = values_and_momenta(system, q, rates, t)
        return np.full(p.shape, np.nan) if found is None else found[1]

    with np.errstate(all="ignore"):
        if isinstance(system.function, KnownMass):
            masses = np.stack([system.function.mass(x) for x in places]).reshape(*p.shape, -1)
        else:
            moves = np.diag(MOVE * difference_scales(system.group, places[0], near)[1])
            sides = [(momenta(v + move) - momenta(v - move)) / (2.0 * move[k])
                     for k, move in enumerate(moves)]  # fmt: skip
            masses = np.stack(sides, axis=-1)
        before = np.inf
        for _ in range(PASSES):
            gap = p - momenta(v)
            sizes = np.abs(p) + (np.abs(masses) @ np.abs(v)[..., None])[..., 0]
            off = float(np.max(np.abs(gap) / np.where(sizes > 0.0, sizes, 1.0)))
            if off <= SOLVED or (off <= ROUNDING and off > 0.5 * before):
                return v
            before = off
            if not (np.all(np.isfinite(gap)) and np.all(np.isfinite(masses))):
                return None
            try:
                v = v + np.linalg.solve(masses, gap[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return None
    return None

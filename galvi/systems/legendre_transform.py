"""Legendre transform and its inverse, velocity from momentum by a damped Newton method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.systems.finite_differences import difference_scales
from galvi.systems.system import BuiltinLagrangian

VELOCITY_ITERATIONS = 50  # iterations of Newton's method for a velocity, at most
CORRECTION_HALVINGS = 40  # halvings of a correction that does not reduce the residual, at most
SOLVED_RESIDUAL = 2.0**-51  # relative residual of the momentum at which a velocity is accepted
ROUND_OFF_RESIDUAL = 1e-8  # relative residual below which stagnation is round-off and accepted
MASS_MATRIX_CONTRACTION = 0.2  # contraction factor above which d2L/dv2 is recomputed
BALANCES = 20
BATCH_ITERATIONS = 12  # iterations of Newton's method for many states at once, at most
MIN_BATCH = 8  # number of states from which solving for all at once is faster
MOVE = 1e-5  # share of a velocity by which momenta are differenced
BATCH_ROUND_OFF_RESIDUAL = 1e-12  # relative residual below which stagnation is round-off
SINGULAR_CONDITION = 1e12  # condition of a balanced d2L/dv2, beyond which it is not inverted
BALANCED_RATIO = 2.0  # ratio of the largest row to the smallest at which balancing stops


def solved(M: Array, p: Array) -> Array:
    """v with M v = p, (d,); NaN where M is singular."""
    try:
        return cast(Array, np.linalg.solve(M, p))
    except np.linalg.LinAlgError:
        return np.full(p.size, np.nan)


def velocity_with_momentum(
    p: Array, guess: Array, momentum: Callable[[Array], Array], mass: Callable[[Array], Array]
) -> Array:
    """v with momentum(v) = p, all (d,), by Newton's method from ``guess``, or from rest where the
    momentum is not finite there.

    Parameters
    ----------
    mass
        v -> d2L/dv2, (d, d)

    Notes
    -----
    A step is halved until it reduces the residual, also where it leaves the domain of L. NaN when
    the iteration does not converge.
    """
    lost = np.full(p.size, np.nan)
    v, gap = guess, p - _momentum_or_nan(momentum, guess)
    if not np.all(np.isfinite(gap)):
        v, gap = np.zeros(p.size), p - momentum(np.zeros(p.size))
    M, weight = np.zeros((p.size, p.size)), np.ones(p.size)
    fresh = renew = True
    for _ in range(VELOCITY_ITERATIONS):
        if not np.all(np.isfinite(gap)):
            return lost
        fresh = renew
        if renew:
            M = mass(v)
            if not np.all(np.isfinite(M)):
                return lost
            weight = balance(M)
        # A momentum may be a difference of terms, as of a charge: these round as they are large.
        sizes = np.maximum(np.abs(p), np.abs(p - gap)) + np.abs(M) @ np.abs(v)
        size = float(np.max(sizes / weight))
        off = float(np.max(np.abs(gap) / weight))
        close = off <= ROUND_OFF_RESIDUAL * size
        if off <= SOLVED_RESIDUAL * size:
            return v
        try:
            step = np.linalg.solve(M / np.outer(weight, weight), gap / weight) / weight
        except np.linalg.LinAlgError:
            return lost
        after = off
        for half in range(1 if close else CORRECTION_HALVINGS):
            shortened = v + 0.5**half * step
            ahead = p - _momentum_or_nan(momentum, shortened)
            after = float(np.max(np.abs(ahead) / weight))
            if after < off:
                v, gap = shortened, ahead
                break
        if not after < off and (close or fresh):
            return v if close else lost
        renew = not after <= MASS_MATRIX_CONTRACTION * off
    return lost


def values_and_momenta(
    system: Any, q: Array | None, v: Array, t: Any
) -> tuple[Array, Array] | None:
    """L (...) and dL/dv (..., d) at states with any axes in front, or None: where the Lagrangian
    does not bring its derivatives, states are few, or one is not finite."""
    rates = v.reshape(-1, system.group.dimension)
    if q is None or system.slopes is not None or system.builtin is None or len(rates) < MIN_BATCH:
        return None
    if not (np.all(np.isfinite(q)) and np.all(np.isfinite(v))):
        return None
    times = np.array(np.broadcast_to(t, v.shape[:-1]), dtype=np.float64).ravel()
    L = cast(BuiltinLagrangian, system.builtin)
    value, _, momenta = L.at_states(q.reshape(-1, *system.group.shape), rates, times)
    return value.reshape(v.shape[:-1]), momenta.reshape(v.shape)


def velocities(system: Any, q: Array | None, p: Array, t: Any, guess: Array) -> Array | None:
    """The velocities (..., d) with dL/dv = p, by Newton's method from ``guess`` (d,) at all states.

    None where `values_and_momenta` returns None, and where the iteration does not converge.
    """
    v = np.array(np.broadcast_to(guess, p.shape))
    if values_and_momenta(system, q, v, t) is None or not np.all(np.isfinite(p)):
        return None
    configurations = cast(Array, q).reshape(-1, *system.group.shape)

    def momenta(rates: Array) -> Array:
        L_and_p = values_and_momenta(system, q, rates, t)
        return np.full(p.shape, np.nan) if L_and_p is None else L_and_p[1]

    with np.errstate(all="ignore"):
        if system.has_known_mass:
            masses = np.stack([system.function.mass(x) for x in configurations]).reshape(
                *p.shape, -1
            )
        else:
            moves = np.diag(MOVE * difference_scales(system.group, configurations[0], guess)[1])
            sides = [
                (momenta(v + move) - momenta(v - move)) / (2.0 * move[k])
                for k, move in enumerate(moves)
            ]
            masses = np.stack(sides, axis=-1)
        before = np.inf
        for _ in range(BATCH_ITERATIONS):
            gap = p - momenta(v)
            sizes = np.abs(p) + (np.abs(masses) @ np.abs(v)[..., None])[..., 0]
            off = float(np.max(np.abs(gap) / np.where(sizes > 0.0, sizes, 1.0)))
            if off <= SOLVED_RESIDUAL or (off <= BATCH_ROUND_OFF_RESIDUAL and off > 0.5 * before):
                return v
            before = off
            if not (np.all(np.isfinite(gap)) and np.all(np.isfinite(masses))):
                return None
            try:
                v = v + np.linalg.solve(masses, gap[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return None
    return None


def _momentum_or_nan(momentum: Callable[[Array], Array], v: Array) -> Array:
    """momentum(v), or NaN where L is not defined."""
    try:
        with np.errstate(all="ignore"):
            return momentum(v)
    except (ArithmeticError, ValueError):
        return np.full(v.size, np.nan)


def balance(M: Array) -> Array:
    """Divisors (d,) of rows and columns that make the largest entry of each row about 1."""
    weight, size = np.ones(len(M)), np.abs(M)
    for _ in range(BALANCES):
        rows = (size / np.outer(weight, weight)).max(axis=1)
        rows = np.where(rows > 0.0, rows, 1.0)
        if rows.max() <= BALANCED_RATIO * rows.min():
            break
        weight = weight * np.sqrt(rows)
    return weight * float(np.sqrt(rows.max()))


def check_regular(M: Array) -> None:
    """ValueError unless d2L/dv2 (d, d) at the start is finite and invertible."""
    if not np.all(np.isfinite(M)):
        raise ValueError(
            f"d2L/dv2 must be finite at the start; received {M.tolist()}. Start with velocities in "
            f"the interior of the Lagrangian's domain."
        )
    if is_singular(M):
        raise ValueError(
            f"the Lagrangian is degenerate at the start: d2L/dv2 is singular, with eigenvalues "
            f"{np.linalg.eigvalsh(0.5 * (M + M.T)).tolist()}; L is linear in the velocity along "
            f"{_missing(M)}, or does not depend on it. Expected a regular Lagrangian, whose "
            f"momenta give its velocities: leave out those that L does not depend on; for an L "
            f"that is linear in others, galvi has no method."
        )


def is_singular(M: Array) -> bool:
    """Whether d2L/dv2 (d, d), finite, cannot be inverted, whatever the units of velocities."""
    weight = balance(M)
    return not np.linalg.cond(M / np.outer(weight, weight)) <= SINGULAR_CONDITION


def _missing(M: Array) -> str:
    """The null directions of d2L/dv2 as text, such as 'v[0] - v[1]', or 'v[0] and v[1]'."""
    weight = balance(M)
    scaled = M / np.outer(weight, weight)
    values, vectors = np.linalg.eigh(0.5 * (scaled + scaled.T))
    sizes = np.abs(values)
    null = np.flatnonzero(sizes * SINGULAR_CONDITION <= np.max(sizes))
    if len(null) == len(M):
        null_vectors = np.eye(len(M))
    else:
        null_vectors = vectors[:, null if len(null) else [np.argmin(sizes)]].T
    return " and ".join(_in_words(along / weight) for along in null_vectors)


def _in_words(along: Array) -> str:
    """A direction of velocities as text, such as 'v[0] - v[1]'."""
    along = along / along[np.argmax(np.abs(along))]
    terms: list[str] = []
    for i in np.flatnonzero(np.abs(along) > 1e-6):
        size = f"{abs(along[i]):.4g} ".removeprefix("1 ")
        sign = ("- " if terms else "-") if along[i] < 0.0 else ("+ " if terms else "")
        terms.append(f"{sign}{size}v[{i}]")
    return " ".join(terms)

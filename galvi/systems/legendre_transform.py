"""Legendre transform and its inverse, velocity from momentum by a damped Newton method."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.systems.finite_differences import difference_scales
from galvi.systems.system import BuiltinLagrangian

VELOCITY_ITERATIONS = 50  # largest number of iterations of Newton's method for a velocity
CORRECTION_HALVINGS = 40  # largest number of lengths, each half the last, of a correction
SOLVED_RESIDUAL = 2.0**-51  # relative residual of the momentum at which a velocity is accepted
ROUND_OFF_RESIDUAL = 1e-8  # relative residual below which stagnation is round-off and accepted
MASS_MATRIX_CONTRACTION = 0.2  # contraction factor above which d2L/dv2 is recomputed
BALANCE_SWEEPS = 20  # largest number of sweeps over rows and columns of a matrix to balance it
BATCH_ITERATIONS = 12  # largest number of iterations of Newton's method for many states at once
MIN_BATCH = 8  # number of states from which solving for all at once is faster
MOMENTUM_STEP = 1e-5  # step by which momenta are differenced, over the length of a velocity
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
    """v with momentum(v) = p, all (d,), by Newton's method from ``guess``, or from 0 where the
    momentum at the guess is not finite; NaN where the iteration does not converge.

    Parameters
    ----------
    mass
        v -> d2L/dv2, (d, d)

    Notes
    -----
    A correction is halved until it reduces the residual, also where it leaves the domain of L.
    """
    no_velocity = np.full(p.size, np.nan)
    v, residual = guess, p - _momentum_or_nan(momentum, guess)
    if not np.all(np.isfinite(residual)):
        v, residual = np.zeros(p.size), p - momentum(np.zeros(p.size))
    M, weight = np.zeros((p.size, p.size)), np.ones(p.size)
    mass_is_current = recompute_mass = True
    for _ in range(VELOCITY_ITERATIONS):
        if not np.all(np.isfinite(residual)):
            return no_velocity
        mass_is_current = recompute_mass
        if recompute_mass:
            M = mass(v)
            if not np.all(np.isfinite(M)):
                return no_velocity
            weight = balance(M)
        # A momentum may be a small difference of large terms, such as those of a charge in a field,
        # whose rounding limits the residual.
        sizes = np.maximum(np.abs(p), np.abs(p - residual)) + np.abs(M) @ np.abs(v)
        momentum_size = float(np.max(sizes / weight))
        error = float(np.max(np.abs(residual) / weight))
        within_rounding = error <= ROUND_OFF_RESIDUAL * momentum_size
        if error <= SOLVED_RESIDUAL * momentum_size:
            return v
        try:
            step = np.linalg.solve(M / np.outer(weight, weight), residual / weight) / weight
        except np.linalg.LinAlgError:
            return no_velocity
        error_after = error
        for half in range(1 if within_rounding else CORRECTION_HALVINGS):
            shortened = v + 0.5**half * step
            ahead = p - _momentum_or_nan(momentum, shortened)
            error_after = float(np.max(np.abs(ahead) / weight))
            if error_after < error:
                v, residual = shortened, ahead
                break
        if not error_after < error and (within_rounding or mass_is_current):
            return v if within_rounding else no_velocity
        recompute_mass = not error_after <= MASS_MATRIX_CONTRACTION * error
    return no_velocity


def values_and_momenta(
    system: Any, q: Array | None, v: Array, t: Any
) -> tuple[Array, Array] | None:
    """L (...) and dL/dv (..., d) at states with leading axes (...), computed for all at once.

    None without q, for slopes of the user, for an L whose derivatives are neither built in nor
    traced, for fewer than MIN_BATCH states, and where q or v is not finite.
    """
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
            moves = np.diag(
                MOMENTUM_STEP * difference_scales(system.group, configurations[0], guess)[1]
            )
            columns = [
                (momenta(v + move) - momenta(v - move)) / (2.0 * move[k])
                for k, move in enumerate(moves)
            ]
            masses = np.stack(columns, axis=-1)
        error_before = np.inf
        for _ in range(BATCH_ITERATIONS):
            residual = p - momenta(v)
            sizes = np.abs(p) + (np.abs(masses) @ np.abs(v)[..., None])[..., 0]
            error = float(np.max(np.abs(residual) / np.where(sizes > 0.0, sizes, 1.0)))
            if error <= SOLVED_RESIDUAL or (
                error <= BATCH_ROUND_OFF_RESIDUAL and error > 0.5 * error_before
            ):
                return v
            error_before = error
            if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(masses))):
                return None
            try:
                v = v + np.linalg.solve(masses, residual[..., None])[..., 0]
            except np.linalg.LinAlgError:
                return None
    return None


def _momentum_or_nan(momentum: Callable[[Array], Array], v: Array) -> Array:
    """momentum(v); NaN where it raises an ArithmeticError or a ValueError."""
    try:
        with np.errstate(all="ignore"):
            return momentum(v)
    except (ArithmeticError, ValueError):
        return np.full(v.size, np.nan)


def balance(M: Array) -> Array:
    """Divisors (d,) of rows and columns that make the largest size in each row about 1."""
    weight, size = np.ones(len(M)), np.abs(M)
    for _ in range(BALANCE_SWEEPS):
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
            f"{_null_directions(M)}, or does not depend on it. Expected a regular Lagrangian, "
            f"whose momenta give its velocities: leave out velocities that L does not depend on; "
            f"for an L that is linear in a velocity, galvi has no method."
        )


def is_singular(M: Array) -> bool:
    """Whether d2L/dv2 (d, d), finite, cannot be inverted, whatever the units of velocities."""
    weight = balance(M)
    return not np.linalg.cond(M / np.outer(weight, weight)) <= SINGULAR_CONDITION


def _null_directions(M: Array) -> str:
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
    return " and ".join(_direction_text(along / weight) for along in null_vectors)


def _direction_text(along: Array) -> str:
    """A direction of velocities as text, such as 'v[0] - v[1]'."""
    along = along / along[np.argmax(np.abs(along))]
    terms: list[str] = []
    for i in np.flatnonzero(np.abs(along) > 1e-6):
        size = f"{abs(along[i]):.4g} ".removeprefix("1 ")
        sign = ("- " if terms else "-") if along[i] < 0.0 else ("+ " if terms else "")
        terms.append(f"{sign}{size}v[{i}]")
    return " ".join(terms)

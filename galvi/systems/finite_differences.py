"""Derivatives by central differences of order eight, for functions given without derivatives.

The weights are 4/5, -1/5, 4/105, -1/280 (Fornberg, Math. Comp. 51 (1988), table 1), the steps
2^-6, 2^-10 and 2^-14 times a length of each coordinate. Of the two neighbouring steps that agree
best the finer is used. Where their difference, or round-off, is too large an error, longer steps
are tried; where no two of the first steps agree, shorter ones. The derivative is NaN where no two
steps agree.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache, lru_cache
from typing import Any, NamedTuple

import numba
import numpy as np
from numba.extending import is_jitted

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.constants import EPSILON
from galvi.kernels.lie import product

ZERO_LENGTH = 1e-24  # coordinates and velocities of at most this size are taken as zero
WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)
STEPS = (2.0**-6, 2.0**-10, 2.0**-14)  # over the length of a coordinate
CALLS = 2 * len(WEIGHTS) * len(STEPS)  # smallest number of calls of the function per component
STEP_RATIO = STEPS[0] / STEPS[1]
COARSER_STEPS, FINER_STEPS = 24, 7  # largest numbers of longer and of shorter steps
# Largest difference of neighbouring steps, in roundings, that counts as round-off.
NOISY_ROUNDINGS = 512.0
GOOD_ERROR = 2.0**-36  # relative error at which no further step is tried
AGREEMENT = 1e-6  # largest relative difference of neighbouring steps that agree
LEAST_LENGTH = 1e-100  # where no coordinate is larger, all have the length 1
SHORT_SHARE = 1e-10  # coordinates of at most this share of the largest one have its length


def difference_scales(group: Group, q: Array, v: Array) -> tuple[Array, Array]:
    """Estimated lengths, (d,) each, over which a Lagrangian changes with q and with v.

    For q: 1 radian for rotations; for translations the largest coordinate or velocity of the same
    factor of the group. For v: the largest velocity of the same kind in the factor; for
    translations at rest the largest coordinate. 1 where all of these vanish.
    """
    by_q, by_v = np.ones(v.size), np.ones(v.size)
    sizes, start = np.empty(v.size), 0
    product.position_scale(group.layout, np.array(q, dtype=np.float64).ravel(), sizes)
    for _, d, _, rotations in group.layout:
        turns, moves = slice(start, start + rotations), slice(start + rotations, start + d)
        length, speed = (float(np.max(np.abs(x), initial=0.0)) for x in (sizes[moves], v[moves]))
        by_q[moves] = _first(max(length, speed))
        by_v[moves] = _first(speed, length)
        by_v[turns] = _first(float(np.max(np.abs(v[turns]), initial=0.0)))
        start += d
    return by_q, by_v


def _first(*sizes: float) -> float:
    """The first size above ZERO_LENGTH; 1 where none is."""
    return next((size for size in sizes if size > ZERO_LENGTH), 1.0)


class Differencing(NamedTuple):
    """Settings of the differencer.

    Attributes
    ----------
    weights
        of the differences in a quotient
    steps
        the first steps, over the length of a coordinate
    noise
        round-off of the function, relative to its size
    good
        relative error at which no further step is tried
    usable
        largest relative difference of neighbouring steps that still counts as agreement
    """

    weights: tuple[float, ...] = WEIGHTS
    steps: tuple[float, ...] = STEPS
    noise: float = EPSILON
    good: float = GOOD_ERROR
    usable: float = AGREEMENT


DEFAULT_DIFFERENCING = Differencing()


def _differencer(jit: Callable[..., Any], choose: Any, larger: Any, any_of: Any) -> Any:
    """The function `slope_along`, for numbers or arrays, in Python or compiled by numba.

    Parameters
    ----------
    jit
        decorator of its functions
    choose
        (condition, x, y) -> x where the condition holds, else y
    larger
        maximum of two values
    any_of
        whether a condition holds for some entry
    """

    @jit
    def quotient(function, x, t, i, step, size, noise, weights):  # type: ignore[no-untyped-def]
        """The difference quotient along a coordinate, and its round-off."""
        shifted, total, largest = x.copy(), 0.0, size
        for k in range(len(weights)):
            shifted[i] = x[i] + (k + 1) * step
            ahead = function(shifted, t)
            shifted[i] = x[i] - (k + 1) * step
            behind = function(shifted, t)
            total = total + weights[k] * (ahead - behind) / step
            largest = larger(largest, larger(abs(ahead), abs(behind)))
        return total, noise * largest / step

    @jit
    def compared(coarse, fine, rounding, usable):  # type: ignore[no-untyped-def]
        """The estimated error of the finer of two quotients; infinite where they do not agree."""
        gap = abs(fine - coarse)
        agree = (gap <= usable * abs(fine)) | (gap <= NOISY_ROUNDINGS * rounding)
        return choose(agree, larger(gap, rounding), np.inf)

    @jit
    def slope_along(function, x, t, i, length, size, way):  # type: ignore[no-untyped-def]
        """The derivative of function(x, t) by x_i and its error; see `differences`."""
        weights, steps, noise, good, usable = way
        longest_step, shortest_step = steps[0] * length, steps[len(steps) - 1] * length
        widest, widest_rounding = quotient(function, x, t, i, longest_step, size, noise, weights)
        first, finest, best = widest, widest, widest
        error = choose(widest == 0.0, np.inf, np.inf)  # infinite, with the shape of the quotient
        for n in range(1, len(steps)):
            fine, rounding = quotient(function, x, t, i, steps[n] * length, size, noise, weights)
            estimate = compared(finest, fine, rounding, usable)
            better = estimate < error
            best, error, finest = choose(better, fine, best), choose(better, estimate, error), fine
        no_agreement = choose(error < np.inf, False, True)  # among the first steps
        for _ in range(COARSER_STEPS):
            zero = (best == 0.0) & (widest == 0.0) & (longest_step >= STEPS[0])
            if not any_of((error > good * abs(best)) & (zero ^ True) & (error < np.inf)):
                break
            longest_step *= STEP_RATIO
            wider, rounding = quotient(function, x, t, i, longest_step, size, noise, weights)
            estimate = compared(wider, widest, widest_rounding, usable)
            better = estimate < error
            best, error = choose(better, widest, best), choose(better, estimate, error)
            widest, widest_rounding = wider, rounding
            if not any_of(better):
                break
        for _ in range(FINER_STEPS):
            if not any_of((error == np.inf) | (no_agreement & (error > good * abs(best)))):
                break
            shortest_step /= STEP_RATIO
            fine, rounding = quotient(function, x, t, i, shortest_step, size, noise, weights)
            may_be_rounding = (fine == 0.0) & (rounding > usable * abs(first))
            estimate = choose(may_be_rounding, np.inf, compared(finest, fine, rounding, usable))
            better = estimate < error
            best, error, finest = choose(better, fine, best), choose(better, estimate, error), fine
            if not any_of(better | (error == np.inf)):
                break
        return choose(error < np.inf, best, np.nan), error

    return slope_along


def _uncompiled(function: Callable[..., Any]) -> Callable[..., Any]:
    return function


def _choose(condition: Any, x: Any, y: Any) -> Any:
    return x if condition else y


slopes_along = _differencer(_uncompiled, np.where, np.maximum, np.any)  # of arrays
slope_along = _differencer(_uncompiled, _choose, max, bool)


@cache
def compiled_slope_along() -> Callable[..., Any]:
    """`slope_along` for compiled functions."""
    compiled = (numba.njit(function) for function in (_choose, lambda x, y: max(x, y), lambda x: x))
    return _differencer(numba.njit, *compiled)


def differences(
    function: Callable[[Array], Array],
    x: Array,
    lengths: Array,
    *,
    size: float = 0.0,
    way: Differencing = DEFAULT_DIFFERENCING,
) -> tuple[Array, Array]:
    """Derivatives of function(x) (m,) by the components of x, and their errors, both (m, d).

    Parameters
    ----------
    lengths : array, shape (d,)
        estimated lengths over which the function changes
    size
        size of the terms that cancel in the function: its round-off is noise * max(size,
        |function|)
    way
        settings

    Notes
    -----
    The error of an entry is the larger of its round-off and its difference to the neighbouring
    step. While it exceeds ``way.good``, longer steps are tried as long as it falls; shorter ones
    where no two of the first steps agree. NaN, with infinite error, where no two neighbouring steps
    agree. An exception of the function is raised again where an entry is NaN.
    """
    x = np.array(x, dtype=np.float64)
    with np.errstate(all="ignore"):
        value = NanWhereRaised(function, np.full(1, np.nan))
        columns = [
            slopes_along(value, x, 0.0, i, float(length), size, way)
            for i, length in enumerate(lengths)
        ]
    value.raise_if_lost(np.concatenate([slope for slope, _ in columns]))
    slopes, errors = (np.stack(parts, axis=1) for parts in zip(*columns, strict=True))
    return slopes, errors


class NanWhereRaised:
    """A function of x that returns ``fallback``, a NaN, where a user's function raises: at shifted
    points it may be undefined."""

    def __init__(self, function: Callable[[Array], Any], fallback: Any) -> None:
        self.function, self.fallback = function, fallback
        self.raised: Exception | None = None

    def __call__(self, x: Array, t: float) -> Any:
        try:
            return self.function(x)
        except Exception as error:  # a user's function may raise anything
            self.raised = error
            return self.fallback

    def raise_if_lost(self, slopes: Array) -> None:
        """Raise the last exception of the function if an entry of the slopes is NaN."""
        if self.raised is not None and np.any(np.isnan(slopes)):
            raise self.raised


def lengths_of(q: Array) -> Array:
    """A length for each coordinate, (d,): its size, or the largest size where it is close to 0."""
    sizes = np.abs(q)
    largest = float(np.max(sizes, initial=0.0))
    largest = largest if largest > LEAST_LENGTH else 1.0
    return np.where(sizes > SHORT_SHARE * largest, sizes, largest)


def _slopes_of(potential: Callable[..., Any], q: Array, *time: float) -> tuple[Array, Array]:
    """dV/dq (d,) at one configuration and its error, (d,)."""
    value = NanWhereRaised(lambda point: float(potential(point, *time)), np.nan)
    pairs = [
        slope_along(value, q, 0.0, i, length, 0.0, DEFAULT_DIFFERENCING)
        for i, length in enumerate(lengths_of(q).tolist())
    ]
    slopes, errors = np.array(pairs).T
    value.raise_if_lost(slopes)
    return slopes, errors


def noise_of(potential: Callable[..., Any], q: Array, *time: float) -> float:
    """The largest error of a differenced dV/dq, relative to its largest entry; infinite where no
    two steps agree."""
    slopes, errors = _slopes_of(potential, q, *time)
    largest, error = np.max(np.abs(slopes)), np.max(errors)
    return float(error / largest) if largest > 0.0 else 0.0 if error == 0.0 else np.inf


@lru_cache(maxsize=64)
def differenced_gradient(potential: Callable[..., Any], explicit_time: bool) -> Callable[..., Any]:
    """A function that returns dV/dq by differences of V, NaN where no two steps agree; compiled
    where V is. A call needs at least CALLS * d evaluations of V."""
    if is_jitted(potential):
        return _compiled_gradient(potential, explicit_time)

    return lambda q, *time: _slopes_of(potential, q, *time)[0]


def _compiled_gradient(potential: Any, explicit_time: bool) -> Callable[..., Any]:
    along, jit = compiled_slope_along(), numba.njit
    timed_potential = potential if explicit_time else jit(lambda q, t: potential(q))

    @jit
    def value(q, t):  # type: ignore[no-untyped-def]
        try:  # the potential may be undefined at a shifted point
            return float(timed_potential(q, t))
        except Exception:
            return np.nan

    @jit
    def timed(q, t):  # type: ignore[no-untyped-def]
        largest = 0.0
        for i in range(q.size):
            largest = max(largest, abs(q[i]))
        largest = largest if largest > LEAST_LENGTH else 1.0
        gradient = np.zeros(q.size)
        for i in range(q.size):
            length = abs(q[i]) if abs(q[i]) > SHORT_SHARE * largest else largest
            slope, _ = along(value, q, t, i, length, 0.0, DEFAULT_DIFFERENCING)
            gradient[i] = slope
        return gradient

    return timed if explicit_time else jit(lambda q: timed(q, 0.0))


def differenced_hessian(gradient: Callable[..., Any]) -> Callable[..., Array]:
    """A function that returns d2V/dq2 (d, d), row i the derivatives of component i of dV/dq, by
    differences of dV/dq; a call needs at least CALLS * d gradients."""

    def hessian(q: Array, *time: float) -> Array:
        return differences(lambda x: np.array(gradient(x, *time)), q, lengths_of(q))[0]

    return hessian


def differenced_rotation_gradient(potential: Callable[..., Any]) -> Callable[..., Array]:
    """A function that returns a dV/dR, (3, 3), with the torque of V(R) or V(R, t), by differences
    of V at rotations only.

    dV/dR = -R hat(torque) / 2, where torque_a = -dV(R hat(e_a)), differenced along the Cayley
    transform. A call needs at least 3 CALLS evaluations of V.
    """

    def gradient(R: Array, *time: float) -> Array:
        def potential_at(s: Array) -> Array:
            return np.array([float(potential(R @ cayley_rotation(s), *time))])

        slope = differences(potential_at, np.zeros(3), np.ones(3))[0][0]
        return 0.5 * R @ hat(slope)

    return gradient


def hat(w: Array) -> Array:
    """(3, 3), with hat(w) x = w x x."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def cayley_rotation(w: Array) -> Array:
    """Cayley's map (I - hat(w) / 2)^-1 (I + hat(w) / 2), (3, 3)."""
    W = hat(w)
    return np.eye(3) + (W + 0.5 * W @ W) / (1.0 + 0.25 * float(w @ w))

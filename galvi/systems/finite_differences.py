"""Derivatives by central differences of order eight, for functions given without derivatives.

With weights 4/5, -1/5, 4/105, -1/280 (Fornberg, Math. Comp. 51 (1988), table 1) and steps of
2^-6, 2^-10 and 2^-14 times |q|. Of the two neighbouring steps that agree best the finer is used,
which guards against both a short length scale and round-off.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import Any

import numba
import numpy as np
from numba.core.registry import CPUDispatcher

from galvi.arrays import Array
from galvi.groups.group import Group
from galvi.kernels.lie import product

SMALLEST = 1e-24  # coordinates and velocities below it are taken as zero


def difference_scales(group: Group, q: Array, v: Array) -> tuple[Array, Array]:
    """Estimated lengths (d,), (d,) over which a Lagrangian changes with q and with v.

    For q: 1 radian for rotations; for translations the largest coordinate or velocity of the same
    factor of the group. For v: the largest velocity of the factor, else its largest coordinate.
    1 where all of these vanish.
    """
    by_q, by_v = np.ones(v.size), np.ones(v.size)
    sizes, start = np.empty(v.size), 0
    product.position_scale(group.layout, np.array(q, dtype=np.float64).ravel(), sizes)
    for _, d, _, rotations in group.layout:
        turns, moves = slice(start, start + rotations), slice(start + rotations, start + d)
        far, fast = (float(np.max(np.abs(x), initial=0.0)) for x in (sizes[moves], v[moves]))
        by_q[moves] = _first(max(far, fast))
        by_v[moves] = _first(fast, far)
        by_v[turns] = _first(float(np.max(np.abs(v[turns]), initial=0.0)))
        start += d
    return by_q, by_v


def _first(*sizes: float) -> float:
    return next((size for size in sizes if size > SMALLEST), 1.0)


WEIGHTS = (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)
STEPS = (2.0**-6, 2.0**-10, 2.0**-14)
CALLS = 2 * len(WEIGHTS) * len(STEPS)  # of the function, for each component
RATIO = STEPS[0] / STEPS[1]
COARSER, FINER = 24, 7  # further steps, tried where those above do not suffice
ROUNDING = 2.0**-52
NOISY = 512.0  # largest difference of neighbouring steps, in roundings, that is only round-off


@lru_cache(maxsize=64)
def differenced_gradient(potential: Callable[..., Any], explicit_time: bool) -> Callable[..., Any]:
    """dV/dq from V by differences, compiled when V is; CALLS * d evaluations of V a call."""

    def plain(q, t):  # type: ignore[no-untyped-def]
        size = 0.0
        for i in range(q.size):
            size = max(size, abs(q[i]))
        size = size if size > 0.0 else 1.0
        gradient = np.zeros(q.size)
        found = np.zeros(len(STEPS))
        for i in range(q.size):
            there = q.copy()
            for n in range(len(STEPS)):
                found[n] = 0.0
                for k in range(len(WEIGHTS)):
                    there[i] = q[i] + (k + 1) * STEPS[n] * size
                    ahead = value(there, t)
                    there[i] = q[i] - (k + 1) * STEPS[n] * size
                    found[n] += WEIGHTS[k] * (ahead - value(there, t)) / (STEPS[n] * size)
            gradient[i] = found[-1]
            best = np.inf
            for n in range(1, len(STEPS)):
                if np.abs(found[n] - found[n - 1]) < best:
                    best = np.abs(found[n] - found[n - 1])
                    gradient[i] = found[n]
        return gradient

    compiled = isinstance(potential, CPUDispatcher)
    jit: Callable[..., Any] = numba.njit if compiled else _same
    if explicit_time:
        value = potential
        return jit(plain)

    value = jit(lambda q, t: potential(q))
    timed = jit(plain)
    return jit(lambda q: timed(q, 0.0))


def differenced_hessian(gradient: Callable[..., Any]) -> Callable[..., Array]:
    """d2V/dq2 (d, d) from dV/dq, row i for component i; CALLS * d gradients a call."""

    def hessian(q: Array, *time: float) -> Array:
        size = float(np.max(np.abs(q))) or 1.0
        found = np.array([_slopes(gradient, q, step * size, *time) for step in STEPS])
        gaps = np.max(np.abs(np.diff(found, axis=0)), axis=(1, 2))
        gaps = np.where(np.isfinite(gaps), gaps, np.inf)
        return found[1 + int(np.argmin(gaps))]

    return hessian


def _slopes(gradient: Callable[..., Any], q: Array, step: float, *time: float) -> Array:
    columns = np.zeros((q.size, q.size))
    for i, unit in enumerate(np.eye(q.size)):
        for k, weight in enumerate(WEIGHTS, start=1):
            ahead = np.array(gradient(q + k * step * unit, *time))
            behind = np.array(gradient(q - k * step * unit, *time))
            columns[i] += weight * (ahead - behind) / step
    return columns.T


def differences(
    function: Callable[[Array], Array], x: Array, scale: Array, *, size: float = 0.0,
    weights: tuple[float, ...] = WEIGHTS, steps: tuple[float, ...] = STEPS,
    noise: float = ROUNDING, good: float = 2.0**-36, usable: float = 1e-6,
) -> tuple[Array, Array]:  # fmt: skip
    """Derivatives of function(x) (m,) by the components of x, and their errors, both (m, d).

    scale   (d,) initial estimates of the lengths over which the function changes
    size    size of the terms that cancel in the function: its round-off is
            noise * max(size, |function|)
    good    relative error at which no further step is tried
    usable  largest relative difference of neighbouring steps that still counts as agreement

    The error of an entry is the larger of its round-off and its difference to the neighbouring
    step. While it exceeds ``good``, coarser steps and then finer steps are tried as long as the
    error falls. NaN, with infinite error, where no two neighbouring steps agree.
    """
    columns = [
        _along(function, x, unit, float(length), size, weights, steps, noise, good, usable)
        for unit, length in zip(np.eye(x.size), scale, strict=True)
    ]
    slopes, errors = zip(*columns, strict=True)
    return np.stack(slopes, axis=1), np.stack(errors, axis=1)


def _along(
    function: Callable[[Array], Array], x: Array, unit: Array, scale: float, size: float,
    weights: tuple[float, ...], steps: tuple[float, ...], noise: float, good: float, usable: float,
) -> tuple[Array, Array]:  # fmt: skip
    def slope(step: float) -> tuple[Array, Array]:
        total, largest = np.zeros(1), np.full(1, size)
        for k, weight in enumerate(weights, start=1):
            ahead, behind = function(x + k * step * unit), function(x - k * step * unit)
            total = total + weight * (ahead - behind) / step
            largest = np.maximum(largest, np.maximum(np.abs(ahead), np.abs(behind)))
        return total, noise * largest / step

    def judge(coarse: tuple[Array, Array], fine: tuple[Array, Array]) -> Array:
        gap, rounding = np.abs(fine[0] - coarse[0]), fine[1]
        agree = (gap <= usable * np.abs(fine[0])) | (gap <= NOISY * rounding)
        return np.where(agree, np.maximum(gap, rounding), np.inf)

    def open_entries(step: float) -> Array:
        zero = (best == 0.0) & (coarsest[0] == 0.0) & (step >= STEPS[0])
        return ~((error <= good * np.abs(best)) | zero)

    with np.errstate(all="ignore"):
        found = [slope(step * scale) for step in steps]
        coarsest, finest = found[0], found[-1]
        best, error = found[-1][0], np.full(np.shape(found[-1][0]), np.inf)
        for coarse, fine in pairwise(found):
            best, error, _ = _better(best, error, fine[0], judge(coarse, fine))
        step = steps[0] * scale
        for _ in range(COARSER):
            if not np.any(open_entries(step) & np.isfinite(error)):
                break
            step *= RATIO
            try:
                wider = slope(step)
            except (ArithmeticError, ValueError):
                break  # the function is not defined that far away
            estimate = judge(wider, coarsest)
            best, error, better = _better(best, error, coarsest[0], estimate)
            coarsest = wider
            if not np.any(better):
                break
        lost, step = np.isinf(error), steps[-1] * scale
        for _ in range(FINER):
            if not np.any(np.isinf(error) | (lost & (error > good * np.abs(best)))):
                break
            step /= RATIO
            closer = slope(step)
            estimate = np.where(closer[0] == 0.0, np.inf, judge(finest, closer))
            best, error, better = _better(best, error, closer[0], estimate)
            finest = closer
            if not np.any(better | np.isinf(error)):
                break
    return np.where(np.isfinite(error), best, np.nan), error


def _better(best: Array, error: Array, other: Array, estimate: Array) -> tuple[Array, Array, Any]:
    better = estimate < error
    return np.where(better, other, best), np.where(better, estimate, error), better


def differenced_rotation_gradient(potential: Callable[..., Any]) -> Callable[..., Array]:
    """A dV/dR, (3, 3), that gives the torque of V(R) or V(R, t), from V at rotations only.

    dV/dR = -R hat(torque) / 2, where torque_a = -dV(R hat(e_a)) along the Cayley transform;
    3 CALLS evaluations of V a call.
    """

    def gradient(R: Array, *time: float) -> Array:
        slope = differenced_gradient.__wrapped__(lambda s: potential(R @ rotated(s), *time), False)(
            np.zeros(3)
        )
        return 0.5 * R @ hat(slope)

    return gradient


def hat(w: Array) -> Array:
    """(3, 3), with hat(w) x = w x x."""
    return np.array([[0.0, -w[2], w[1]], [w[2], 0.0, -w[0]], [-w[1], w[0], 0.0]])


def rotated(w: Array) -> Array:
    """Cayley's map (I - hat(w) / 2)^-1 (I + hat(w) / 2), (3, 3)."""
    W = hat(w)
    return np.eye(3) + (W + 0.5 * W @ W) / (1.0 + 0.25 * float(w @ w))


def _same(function: Callable[..., Any]) -> Callable[..., Any]:
    return function

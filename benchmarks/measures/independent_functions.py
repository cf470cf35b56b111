"""Function spaces in plain numpy, by textbook formulas: values and slopes on [0, 1].

Each space is a list of pairs (u, u'); they span the same functions as galvi's space of that name.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from galvi.arrays import Array

Function = Callable[[Array], Array]
Functions = list[tuple[Function, Function]]


def powers(degree: int) -> Functions:
    """1, t, .. t^degree."""
    return [_power(k, 0.0) for k in range(degree + 1)]


def waves(harmonics: int, frequency: float = 2.0 * np.pi) -> Functions:
    """cos k w t and sin k w t."""
    found: Functions = []
    for k in range(1, harmonics + 1):
        found += _wave(k * frequency)
    return found


def broken_powers(degree: int, pieces: int, smooth: int) -> Functions:
    """Powers, and (t - k / pieces)_+^j, j = smooth + 1 .. degree, at each joint: functions of this
    degree on each piece with ``smooth`` continuous derivatives; at a joint the right-hand slope."""
    joints = [k / pieces for k in range(1, pieces)]
    return powers(degree) + [
        _power(j, joint) for joint in joints for j in range(smooth + 1, degree + 1)
    ]


def table(functions: Functions, t: Array) -> tuple[Array, Array]:
    """Values and slopes, (times, functions) each."""
    both = [(u(t), du(t)) for u, du in functions]
    return np.stack([u for u, _ in both], axis=1), np.stack([du for _, du in both], axis=1)


def _power(k: int, start: float) -> tuple[Function, Function]:
    def value(t: Array) -> Array:
        return np.where(t >= start, (t - start) ** k, 0.0)

    def slope(t: Array) -> Array:
        return np.where(t >= start, k * (t - start) ** max(k - 1, 0), 0.0)

    return value, slope


def _wave(w: float) -> Functions:
    return [
        (lambda t: np.cos(w * t), lambda t: -w * np.sin(w * t)),
        (lambda t: np.sin(w * t), lambda t: w * np.cos(w * t)),
    ]

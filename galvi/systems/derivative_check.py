"""Compares given derivatives with differences of the functions to which they belong.

A function is sampled at the distances s and -s along a curve, s = 2^-4, 2^-6, ..., 2^-32 of a
length that suits the state. The derivative is accepted as soon as one central difference, or the
extrapolation of two, agrees with it. It is refused where none does although three neighbouring
differences agree with each other far better than with it, over distances over which neither the
given derivative nor the function bends. All else is undecided and passes: noise, kinks, jumps,
scales too short to be resolved, and functions that raise or are not finite nearby.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any
from weakref import WeakSet

import numpy as np

from galvi.arrays import Array
from galvi.kernels.constants import INVERSE_GOLDEN_RATIO

DERIVATIVE_TOLERANCE = 1e-4  # of a derivative, relative to the sum of the sizes of its terms
# Binary exponents of 1 / s in the order tried: most functions agree at the first two or three.
EXPONENTS = (10, 12, 8, 14, 16, 6, 18, 4, 20, 22, 24, 26, 28, 30, 32)
EXPONENTS_APART = 2  # of neighbouring exponents
SHARP = 0.02  # largest spread of three differences, over their distance from the given derivative
# Largest change of a slope, over that distance, at which the function is smooth there.
LARGEST_BEND = 0.25
VISIBLE = 0.1  # change of a function over its value, above which coarse rounding cannot hide it
DIFFERENCE_ROUNDING = 4.0 * 2.0**-52  # of a difference of two values, relative to them
SIGNAL = 1e-3  # derivative over the sum of the sizes of its terms, below which it shows no fault
NEARBY = (2.0**-3, 2.0**-10, 2.0**-20)  # distances of a second state, the first decisive one counts
SILVER = 2.0**0.5

AGREES, DIFFERS, UNDECIDED = "agrees", "differs", "undecided"
_CHECKED: WeakSet[Any] = WeakSet()  # systems whose derivatives have agreed with their functions


@dataclass(frozen=True, eq=False)
class Curve:
    """A function along a curve through a state, at distance 0, with its given derivative there.

    Attributes
    ----------
    function
        of the distance s, without a unit
    terms
        (s) -> the terms whose sum is the given derivative by s
    steps : array, shape (d,)
        the change of the coordinates per unit of s, in a group left-trivialised
    state
        name -> configuration, and velocity where the function depends on it
    way
        "along" the steps, or a rotation "about" them
    """

    function: Callable[[float], float]
    terms: Callable[[float], Array]
    steps: Array
    state: Mapping[str, Array]
    way: str = "along"


@dataclass(frozen=True)
class Difference:
    """A central difference at one distance: slope, round-off, half the jump of one-sided slopes,
    and whether all values are equal."""

    slope: float
    rounding: float
    bend: float
    flat: bool


def check_derivatives(system: Any, curves: Mapping[str, Callable[[float], Curve]]) -> None:
    """ValueError for the first derivative that differs at the start or at a state near it.

    Parameters
    ----------
    curves
        "the gradient of the potential" -> function of a distance, without a unit, that gives the
        curve through the start, for 0, or through a state at this distance from it

    Notes
    -----
    A system is checked until its derivatives agreed once. States where a function raises or returns
    something else than it should are skipped: a run refuses such a start, or lets the exception
    through.
    """
    if system in _CHECKED:
        return
    agreed = True
    with np.errstate(all="ignore"):
        for name, through in curves.items():
            at_state, nearby = _checked(system, name, through, 0.0), UNDECIDED
            for distance in NEARBY:
                nearby = _checked(system, name, through, distance)
                if nearby == AGREES:
                    break
            agreed = agreed and AGREES in (at_state, nearby)
    if agreed:
        _CHECKED.add(system)


def _checked(system: Any, name: str, through: Callable[[float], Curve], distance: float) -> str:
    try:
        curve = through(distance)
        verdict, slope = compare_with_differences(curve)
    except Exception:  # a user's function may raise anything
        return UNDECIDED
    if verdict == DIFFERS:
        length = float(np.linalg.norm(curve.steps))
        expected, received = slope / length, float(np.sum(curve.terms(0.0))) / length
        ratio = received / expected if expected else np.inf
        factor = "" if not np.isfinite(ratio) else f", {ratio:.6g} times that"
        factor = (
            ", of the opposite sign" if abs(ratio + 1.0) < 10.0 * DERIVATIVE_TOLERANCE else factor
        )
        derivative, _, function = name.partition(" of ")
        state = ", ".join(f"{name} = {abbreviated(x)}" for name, x in curve.state.items())
        where = f"{curve.way} {abbreviated(curve.steps / length)} at {state}"
        raise ValueError(
            f"{derivative} must be the derivative of {function}: {where}, expected "
            f"{expected:.10g}, from differences of {function}; received {received:.10g}{factor}. "
            f"Correct one of them, or give {type(system).__name__} check=False if they are meant "
            f"to differ."
        )
    return verdict


def compare_with_differences(curve: Curve) -> tuple[str, float]:
    """AGREES, DIFFERS or UNDECIDED, and the derivative by differences; NaN when undecided.

    AGREES needs a derivative in which a fault would show, so not one that vanishes.
    """
    terms, centre = curve.terms(0.0), curve.function(0.0)
    supplied, size = float(np.sum(terms)), float(np.sum(np.abs(terms)))
    differences: dict[int, Difference] = {}
    if not (np.isfinite(centre) and np.isfinite(size)):
        return UNDECIDED, np.nan
    for exponent in EXPONENTS:
        difference = _difference(curve.function, centre, 2.0**-exponent)
        if difference is None or difference.rounding > DERIVATIVE_TOLERANCE * (
            size + abs(difference.slope)
        ):
            continue
        differences[exponent] = difference
        for slope in (difference.slope, *_extrapolated(differences, exponent)):
            if abs(supplied - slope) <= DERIVATIVE_TOLERANCE * (size + abs(slope)) and (
                size or not difference.flat
            ):
                return (AGREES if abs(slope) > SIGNAL * size else UNDECIDED), slope
        if (
            size == 0.0
            and len(differences) > 1
            and all(difference.flat for difference in differences.values())
        ):
            return UNDECIDED, np.nan  # a constant, with derivative zero
    return _contradiction(curve, supplied, centre, differences)


def _difference(function: Callable[[float], float], centre: float, s: float) -> Difference | None:
    """None where the function raises or is not finite."""
    try:
        ahead, behind = function(s), function(-s)
    except Exception:  # a user's function may raise anything away from the start
        return None
    if not (np.isfinite(ahead) and np.isfinite(behind)):
        return None
    rounding = DIFFERENCE_ROUNDING * max(abs(ahead), abs(behind), abs(centre)) / s
    bend = 0.5 * abs(ahead - 2.0 * centre + behind) / s
    return Difference((ahead - behind) / (2.0 * s), rounding, bend, ahead == centre == behind)


def _extrapolated(differences: Mapping[int, Difference], exponent: int) -> list[float]:
    """The differences of order four of this distance and its neighbours."""
    pairs = ((exponent - EXPONENTS_APART, exponent), (exponent, exponent + EXPONENTS_APART))
    ratio = 4.0**EXPONENTS_APART
    return [
        (ratio * differences[fine].slope - differences[coarse].slope) / (ratio - 1.0)
        for coarse, fine in pairs
        if coarse in differences and fine in differences
    ]


def _contradiction(
    curve: Curve, supplied: float, centre: float, differences: Mapping[int, Difference]
) -> tuple[str, float]:
    """DIFFERS where three neighbouring differences agree with each other and not with the
    derivative."""
    if differences and all(difference.flat for difference in differences.values()):
        farthest = min(differences)
        hidden = abs(supplied) * 2.0**-farthest <= VISIBLE * abs(centre)
        straight = not hidden and _change(
            curve, supplied, sorted(differences)
        ) <= LARGEST_BEND * abs(supplied)
        return (DIFFERS, 0.0) if straight else (UNDECIDED, np.nan)
    best, sharpest = np.nan, np.inf
    bent = {
        exponent: difference for exponent, difference in differences.items() if not difference.flat
    }
    for first in bent:
        if not {first + EXPONENTS_APART, first + 2 * EXPONENTS_APART} <= bent.keys():
            continue
        a, b, c = (bent[first + k * EXPONENTS_APART] for k in range(3))
        slope = _extrapolated({0: b, EXPONENTS_APART: c}, 0)[0]
        off, spread = abs(supplied - slope), max(abs(b.slope - a.slope), abs(c.slope - b.slope))
        clear = spread <= SHARP * off and c.bend <= LARGEST_BEND * off and spread < sharpest
        within = [exponent for exponent in differences if exponent >= first]
        if clear and _change(curve, supplied, within) <= LARGEST_BEND * off:
            best, sharpest = slope, spread
    return (DIFFERS if np.isfinite(best) else UNDECIDED), best


def _change(curve: Curve, supplied: float, exponents: Sequence[int]) -> float:
    """The largest change of the given derivative over these distances; infinite where it raises."""
    try:
        ends = [sign * 2.0**-exponent for exponent in exponents for sign in (1.0, -1.0)]
        change = max(abs(float(np.sum(curve.terms(s))) - supplied) for s in ends)
    except Exception:  # a user's function may raise anything away from the start
        return np.inf
    return change if np.isfinite(change) else np.inf


def direction(count: int, number: int = 0) -> Array:
    """A fixed generic direction, (count,): sizes from 0.5 to 1.5 and both signs; one per number."""
    k = np.arange(1.0, count + 1.0) + 17.0 * number
    return (0.5 + (k * INVERSE_GOLDEN_RATIO) % 1.0) * np.where((k * SILVER) % 1.0 < 0.5, 1.0, -1.0)


def abbreviated(numbers: Array | Sequence[float]) -> str:
    """The first numbers of an array with a few digits."""
    shown = np.asarray(numbers, dtype=np.float64)
    text = np.array2string(shown, precision=5, separator=", ", threshold=9, edgeitems=3)
    return text.replace("\n", "")

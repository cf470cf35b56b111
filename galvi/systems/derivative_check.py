"""Compares given derivatives with differences of the functions to which they belong.

A function is sampled at the distances s and -s along a curve, s = 2^-4, 2^-6, ..., 2^-32 of a
length that suits the state. The derivative is accepted as soon as one central difference, or the
extrapolation of two, agrees with it. It is refused where none does, but three neighbouring
differences agree with each other far better than with it, or all differences are 0, over distances
over which the given derivative hardly changes. All other cases are undecided and accepted: noise,
kinks, jumps, scales too short to be resolved, and functions that raise or are not finite nearby.
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
# Largest spread of three differences, over their distance from the given derivative.
LARGEST_SPREAD = 0.02
# Largest change of a slope, over that distance, at which the function counts as smooth.
LARGEST_BEND = 0.25
# Relative change of a function above which coarse rounding of its values cannot hide it.
VISIBLE_CHANGE = 0.1
DIFFERENCE_ROUNDING = 4.0 * 2.0**-52  # of a difference of two values, relative to them
# A derivative below this share of the sum of the sizes of its terms would not show a fault.
SIGNAL_SHARE = 1e-3
# Distances of a second state, tried in turn until the derivative agrees or differs there.
NEARBY = (2.0**-3, 2.0**-10, 2.0**-20)
SQUARE_ROOT_OF_TWO = 2.0**0.5

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
        name -> configuration or velocity, for messages
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
    is_constant: bool


def check_derivatives(system: Any, curves: Mapping[str, Callable[[float], Curve]]) -> None:
    """ValueError for the first derivative that differs at the start or at a state near it.

    Parameters
    ----------
    curves
        name, such as "gradient of the potential" -> function that returns, for a dimensionless
        distance, the curve through the state at this distance from the start

    Notes
    -----
    A system whose derivatives have all agreed once is not checked again. States where a function
    raises or returns a wrong type are skipped: the run itself refuses such a start, or lets the
    exception through.
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
    """AGREES or UNDECIDED at the state at a distance; ValueError where the derivative differs."""
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
            f"Correct the function or its derivative, or give {type(system).__name__} check=False "
            f"if they are meant to differ."
        )
    return verdict


def compare_with_differences(curve: Curve) -> tuple[str, float]:
    """AGREES, DIFFERS or UNDECIDED, and the derivative by differences, NaN where none was accepted.

    A derivative that agrees but is too small to show a fault is UNDECIDED.
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
                size or not difference.is_constant
            ):
                return (AGREES if abs(slope) > SIGNAL_SHARE * size else UNDECIDED), slope
        if (
            size == 0.0
            and len(differences) > 1
            and all(difference.is_constant for difference in differences.values())
        ):
            return UNDECIDED, np.nan  # a constant, with derivative zero
    return _contradiction(curve, supplied, centre, differences)


def _difference(function: Callable[[float], float], centre: float, s: float) -> Difference | None:
    """The central difference at the distance s; None where the function raises or is not finite."""
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
    """The extrapolations, of order four, of this difference with each of its neighbours."""
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
    """DIFFERS and the derivative by differences where three neighbouring differences agree with
    each other and not with the supplied derivative, or all differences are 0; else UNDECIDED."""
    if differences and all(difference.is_constant for difference in differences.values()):
        farthest = min(differences)
        may_be_rounding = abs(supplied) * 2.0**-farthest <= VISIBLE_CHANGE * abs(centre)
        is_linear = not may_be_rounding and _change(
            curve, supplied, sorted(differences)
        ) <= LARGEST_BEND * abs(supplied)
        return (DIFFERS, 0.0) if is_linear else (UNDECIDED, np.nan)
    best, sharpest = np.nan, np.inf
    varying = {
        exponent: difference
        for exponent, difference in differences.items()
        if not difference.is_constant
    }
    for first in varying:
        if not {first + EXPONENTS_APART, first + 2 * EXPONENTS_APART} <= varying.keys():
            continue
        a, b, c = (varying[first + k * EXPONENTS_APART] for k in range(3))
        slope = _extrapolated({0: b, EXPONENTS_APART: c}, 0)[0]
        deviation, spread = (
            abs(supplied - slope),
            max(abs(b.slope - a.slope), abs(c.slope - b.slope)),
        )
        agree = (
            spread <= LARGEST_SPREAD * deviation
            and c.bend <= LARGEST_BEND * deviation
            and spread < sharpest
        )
        within = [exponent for exponent in differences if exponent >= first]
        if agree and _change(curve, supplied, within) <= LARGEST_BEND * deviation:
            best, sharpest = slope, spread
    return (DIFFERS if np.isfinite(best) else UNDECIDED), best


def _change(curve: Curve, supplied: float, exponents: Sequence[int]) -> float:
    """The largest change of the supplied derivative up to these distances; infinite where it raises
    or is not finite."""
    try:
        distances = [sign * 2.0**-exponent for exponent in exponents for sign in (1.0, -1.0)]
        change = max(abs(float(np.sum(curve.terms(s))) - supplied) for s in distances)
    except Exception:  # a user's function may raise anything away from the start
        return np.inf
    return change if np.isfinite(change) else np.inf


def direction(count: int, number: int = 0) -> Array:
    """A fixed generic direction, (count,), one for each ``number``: its entries have sizes from 0.5
    to 1.5 and both signs."""
    k = np.arange(1.0, count + 1.0) + 17.0 * number
    return (0.5 + (k * INVERSE_GOLDEN_RATIO) % 1.0) * np.where(
        (k * SQUARE_ROOT_OF_TWO) % 1.0 < 0.5, 1.0, -1.0
    )


def abbreviated(numbers: Array | Sequence[float]) -> str:
    """The numbers with five decimals, as text on one line; of more than nine the first and last
    three."""
    shown = np.asarray(numbers, dtype=np.float64)
    text = np.array2string(shown, precision=5, separator=", ", threshold=9, edgeitems=3)
    return text.replace("\n", "")

"""Input checks, whose messages state the expected and the received value, and a remedy."""

from __future__ import annotations

import math
from collections.abc import Iterable, Sequence, Sized
from contextlib import suppress
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only

LARGEST_WHOLE = 2**62  # largest whole number: the kernels count in 64 bits
SHOWN = 200  # about the largest number of characters of a value in a message
LONGEST_SHOWN = 256  # bits of the longest whole number that messages show in full


def whole(name: str, value: Any, at_least: int = 1, at_most: int | None = None) -> int:
    """``value`` as an int, or ValueError when it is not a whole number in the stated range.

    Parameters
    ----------
    at_most
        None: LARGEST_WHOLE, which the message states only when it is exceeded
    """
    largest = LARGEST_WHOLE if at_most is None else at_most
    if type(value) is int and at_least <= value <= largest:
        return value
    numbers = (int, float, np.integer, np.floating)
    is_number = isinstance(value, numbers) and not isinstance(value, bool)
    number = int(value) if is_number and (isinstance(value, int) or math.isfinite(value)) else None
    if number is None or number != value or not at_least <= number <= largest:
        beyond = is_number and (value > 0 if number is None else number > largest)
        limit = f"of at least {at_least}"
        if beyond or at_most is not None:
            limit = f"from {at_least} to {largest}"
        long = isinstance(value, int) and value.bit_length() > LONGEST_SHOWN
        received = f"a number of {value.bit_length()} bits" if long else shown(value)
        raise ValueError(f"{name} must be a whole number {limit}; received {received}.")
    return number


def real(name: str, value: Any, remedy: str = "") -> float:
    """``value`` as a finite float, or ValueError."""
    if type(value) is float and math.isfinite(value):
        return value
    number = float("nan")
    with suppress(ValueError, OverflowError):  # of lists that are no array; of 10**400
        if isinstance(value, int) and not isinstance(value, bool):
            number = float(value)  # also beyond 64 bits
        elif np.ndim(value) == 0 and np.asarray(value).dtype.kind in "iuf":
            number = float(value)
    if not math.isfinite(number):
        shape = value.shape if isinstance(value, np.ndarray) else ()
        received = f"an array of shape {shape}" if shape else shown(value)
        raise ValueError(_sentence(f"{name} must be a finite real number", received, remedy))
    return number


def positive(name: str, value: Any, remedy: str = "") -> float:
    """``value`` as a finite float; ValueError unless it is above zero."""
    number = real(name, value, remedy)
    if number <= 0.0:
        raise ValueError(_sentence(f"{name} must be positive", shown(value), remedy))
    return number


def flag(name: str, value: Any) -> bool:
    """``value`` as a bool; TypeError unless it is True or False."""
    if not isinstance(value, bool | np.bool_):
        raise TypeError(f"{name} must be True or False; received {shown(value)}.")
    return bool(value)


def has_items(value: Any) -> bool:
    """Whether the value can be iterated over; False for an array without dimensions and for a
    single Rotation of SciPy, which have no length."""
    try:
        return isinstance(value, Iterable) and (not isinstance(value, Sized) or len(value) >= 0)
    except TypeError:
        return False


def several(value: Any) -> tuple[Any, ...]:
    """The items of a value as a tuple; a tuple with the value itself where it cannot be iterated
    over."""
    return tuple(value) if has_items(value) else (value,)


def returned(name: str, value: Any) -> float:
    """A user function's result as a float, which may be infinite or NaN; ValueError unless it is a
    real number."""
    number = np.asarray(None)
    with suppress(ValueError):  # of lists of different lengths
        number = np.asarray(value)
    if number.ndim:
        raise ValueError(f"{name} must return a number; received an array of shape {number.shape}.")
    if number.dtype.kind not in "iuf":
        raise ValueError(f"{name} must return a real number; received {shown(value)}.")
    return float(number)


def array(name: str, value: Any, shape: Sequence[int] | None = None, remedy: str = "") -> Array:
    """``value`` as a read-only float64 array of finite numbers, or ValueError."""
    masked = int(np.ma.getmaskarray(value).sum()) if isinstance(value, np.ma.MaskedArray) else 0
    if masked:
        raise ValueError(
            f"{name} must have no masked entries; received {masked} of them. Fill them, or leave "
            f"them out."
        )
    try:
        entries = np.asarray(value)
    except ValueError:
        entries = np.array(None)
    if entries.dtype == object and all(type(x) in (int, float) for x in entries.flat):
        with suppress(OverflowError):
            entries = entries.astype(np.float64)  # whole numbers beyond 64 bits
    if entries.dtype.kind not in "iuf":
        raise ValueError(
            _sentence(f"{name} must be an array of real numbers", shown(value), remedy)
        )
    numbers = np.array(entries, dtype=np.float64)
    if shape is not None and numbers.shape != tuple(shape):
        raise ValueError(
            _sentence(f"{name} must have shape {tuple(shape)}", f"shape {numbers.shape}", remedy)
        )
    if not np.all(np.isfinite(numbers)):
        where = np.argwhere(~np.isfinite(np.atleast_1d(numbers)))[0].tolist()
        raise ValueError(
            _sentence(
                f"{name} must hold finite numbers only", f"a non-finite entry at {where}", remedy
            )
        )
    return read_only(numbers)


def shown(value: Any) -> str:
    """The text of a value for messages, on one line; the middle of a long text is left out."""
    try:
        text = " ".join(repr(value).split())
    except Exception:  # of a user's class, or of a number of thousands of digits
        text = f"an object of type {type(value).__name__}"
    return text if len(text) <= SHOWN else f"{text[: SHOWN // 2]} ... {text[-SHOWN // 2 :]}"


def _sentence(expected: str, received: str, remedy: str) -> str:
    return f"{expected}; received {received}." + (f" {remedy}" if remedy else "")

"""One entry of many states at once, as a number with which a function of one state computes.

A function of one configuration is called with arrays of such entries, so that one call computes its
values at many states. An entry holds the values at these states, or bounds of them on each of many
steps, from which arithmetic makes bounds of the function there (interval arithmetic, up to
rounding). Operations that need a single value, as a branch does, raise TypeError.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np

from galvi.arrays import Array


def _monotone(function: Any) -> Callable[[Entry], Entry]:
    def method(self: Entry) -> Entry:
        low = function(self.low)
        return _exact_entry(low) if self.exact else Entry(low, function(self.high))

    return method


class Entry:
    """Values at many states, where ``low`` is ``high``; else lower and upper bounds of values."""

    low: Any
    high: Any

    def __init__(self, low: Any, high: Any) -> None:
        self.low, self.high = low, high

    @property
    def exact(self) -> bool:
        """Whether it holds values, not bounds."""
        return self.low is self.high

    def __add__(self, other: Any) -> Entry:
        right = _entry(other)
        if self.exact and right.exact:
            return _exact_entry(self.low + right.low)
        return Entry(self.low + right.low, self.high + right.high)

    def __sub__(self, other: Any) -> Entry:
        right = _entry(other)
        if self.exact and right.exact:
            return _exact_entry(self.low - right.low)
        return Entry(self.low - right.high, self.high - right.low)

    def __neg__(self) -> Entry:
        return _exact_entry(-self.low) if self.exact else Entry(-self.high, -self.low)

    def __mul__(self, other: Any) -> Entry:
        if other is self:
            return self**2
        right = _entry(other)
        if self.exact and right.exact:
            return _exact_entry(self.low * right.low)
        if type(right.low) is float:
            ends = [self.low * right.low, self.high * right.low]
            return Entry(*(ends if right.low >= 0.0 else ends[::-1]))
        ends = [a * b for a in (self.low, self.high) for b in (right.low, right.high)]
        return Entry(np.minimum.reduce(ends), np.maximum.reduce(ends))

    def __truediv__(self, other: Any) -> Entry:
        right = _entry(other)
        if self.exact and right.exact:
            return _exact_entry(self.low / right.low)
        if right.exact and type(right.low) is float and right.low != 0.0:
            return self * (1.0 / right.low)
        nonzero = (right.low > 0.0) | (right.high < 0.0)
        low, high = (
            np.where(nonzero, 1.0 / x, y) for x, y in ((right.high, -np.inf), (right.low, np.inf))
        )
        return self * Entry(low, high)

    def __pow__(self, power: Any) -> Entry:
        if isinstance(power, Entry):
            raise TypeError("its power depends on the state")
        if self.exact:
            return _exact_entry(self.low**power)
        if power < 0:
            return _entry(1.0) / self**-power
        base = abs(self) if power % 2 == 0 else self
        if power % 1 == 0:
            return Entry(base.low**power, base.high**power)
        return Entry(np.maximum(self.low, 0.0) ** power, np.maximum(self.high, 0.0) ** power)

    def __abs__(self) -> Entry:
        if self.exact:
            return _exact_entry(np.abs(self.low))
        smallest = np.maximum(np.maximum(self.low, -self.high), 0.0)
        return Entry(smallest, np.maximum(-self.low, self.high))

    exp, log, sinh = _monotone(np.exp), _monotone(np.log), _monotone(np.sinh)
    tanh, arcsin, arctan = _monotone(np.tanh), _monotone(np.arcsin), _monotone(np.arctan)
    deg2rad, rad2deg = _monotone(np.deg2rad), _monotone(np.rad2deg)

    def sqrt(self) -> Entry:
        """The square root; bounds below 0 count as 0."""
        return self**0.5

    def sin(self) -> Entry:
        """The sine; a bound is 1 or -1 where the argument passes an extremum."""
        if self.exact:
            return _exact_entry(np.sin(self.low))
        ends, (reaches_maximum, reaches_minimum) = (
            (np.sin(self.low), np.sin(self.high)),
            (
                np.floor((self.high - extremum) / (2.0 * np.pi))
                >= np.ceil((self.low - extremum) / (2.0 * np.pi))
                for extremum in (0.5 * np.pi, -0.5 * np.pi)
            ),
        )
        return Entry(
            np.where(reaches_minimum, -1.0, np.minimum(*ends)),
            np.where(reaches_maximum, 1.0, np.maximum(*ends)),
        )

    def cos(self) -> Entry:
        """The cosine."""
        return _exact_entry(np.cos(self.low)) if self.exact else (self + 0.5 * np.pi).sin()

    def conjugate(self) -> Entry:
        """The entry itself, which is real."""
        return self

    def arctan2(self, x: Any) -> Entry:
        """The angle of (x, self); bounds are always -pi and pi."""
        right = _entry(x)
        if self.exact and right.exact:
            return _exact_entry(np.arctan2(self.low, right.low))
        return _entry(np.pi) * Entry(-1.0 + 0.0 * self.low, 1.0 + 0.0 * self.low)

    def hypot(self, y: Any) -> Entry:
        """sqrt(x^2 + y^2)."""
        return (self**2 + _entry(y) ** 2).sqrt()

    def _refuse_branch(self, *arguments: Any) -> Any:
        raise TypeError("it needs a value, as a branch does")

    def __rsub__(self, other: Any) -> Entry:
        return _entry(other) - self

    def __rtruediv__(self, other: Any) -> Entry:
        return _entry(other) / self

    __radd__, __rmul__ = __add__, __mul__
    __bool__ = __float__ = __int__ = __index__ = _refuse_branch
    __lt__ = __le__ = __gt__ = __ge__ = __rpow__ = __mod__ = __floordiv__ = _refuse_branch
    __eq__ = __ne__ = _refuse_branch
    __hash__ = object.__hash__


class LazyEntry(Entry):
    """Entry number k, whose values or bounds are evaluated when a function uses it."""

    def __init__(self, evaluate: Callable[[int], tuple[Array, Array]], k: int) -> None:
        self._find, self._k = evaluate, k

    def __getattr__(self, name: str) -> Any:
        if name not in ("low", "high"):
            raise AttributeError(name)
        self.low, self.high = self._find(self._k)
        return vars(self)[name]


def lazy_entries(evaluate: Callable[[int], tuple[Array, Array]], n: int) -> Any:
    """n entries (n,), each evaluated when a function uses it."""
    entries = np.empty(n, dtype=object)
    entries[:] = [LazyEntry(evaluate, k) for k in range(n)]
    return entries


def _exact_entry(values: Any) -> Entry:
    return Entry(values, values)


def _entry(value: Any) -> Entry:
    if isinstance(value, Entry):
        return value
    number = np.asarray(value)
    if number.ndim or number.dtype.kind not in "biuf":
        raise TypeError(f"it computes with {type(value).__name__}")
    return _exact_entry(float(number))


def evaluate_entries(
    function: Callable[..., Any], q: Any, v: Any, t: Any, shape: tuple[int, ...]
) -> tuple[Array, Array]:
    """Lower and upper bounds of a function of entries, two arrays of ``shape``; the same array
    twice where the entries hold values."""
    with np.errstate(all="ignore"):
        value = function(q, v, t)
        if isinstance(value, np.ndarray) and value.ndim == 0:
            value = value.item()
        entry = _entry(value)
    low = np.broadcast_to(entry.low, shape)
    return low, low if entry.exact else np.broadcast_to(entry.high, shape)

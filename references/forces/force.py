"""Forces of systems: by formulas, by a user's gradient, or by differences."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np
from numba import NumbaError, njit, types
from numba.extending import is_jitted

from galvi.arrays import Array
from references.compiled import njit as cached

ROWS = 12  # of the extrapolation table
FIRST_STEP = 2.0**-4  # over the length on which a function changes
STEP_RATIO = 2.0
ROUNDING = 1e-12  # relative difference of two correct ways to evaluate a gradient
DISTANCES = (0.01, 0.01, 0.1, 0.1, 1.0, 1.0, 3.0, 3.0)  # of points around a start, over its size


def derivative(function: Callable[[float], float], scale: float) -> float:
    """f'(0), from central differences of halved steps, extrapolated to zero.

    Parameters
    ----------
    scale
        length over which the function changes: the first step is a sixteenth of it

    Notes
    -----
    Returns the entry of the extrapolation table that differs least from its neighbours.
    """
    best, error, above = np.nan, np.inf, []
    for row in range(ROWS):
        step = FIRST_STEP * scale / STEP_RATIO**row
        entries = [(function(step) - function(-step)) / (2.0 * step)]
        for k, coarser in enumerate(above):
            factor = STEP_RATIO ** (2 * (k + 1))
            entries.append((factor * entries[k] - coarser) / (factor - 1.0))
            change = max(abs(entries[-1] - entries[-2]), abs(entries[-1] - coarser))
            if change <= error:
                best, error = entries[-1], change
        above = entries
    return float(best)


def gradient(function: Callable[[Any], float], q: Array) -> Array:
    """df/dq, (d,), by `derivative` with the scale max |q|, or 1 at q = 0."""
    scale = float(np.max(np.abs(q))) or 1.0
    units = np.eye(q.size)
    return np.array(
        [derivative(lambda s, unit=unit: float(function(q + s * unit)), scale) for unit in units]
    )


def agrees(
    function: Callable[[Array], Any], reference: Callable[[Array], Array], points: Iterable[Array]
) -> bool:
    """Whether a function and a reference return the same array, to ROUNDING, at all points; False
    where the function raises."""
    for point in points:
        try:
            values = np.asarray(function(point.copy()), dtype=np.float64)
        except Exception:  # a user's function may raise anything
            return False
        exact = reference(point)
        if values.shape != exact.shape:
            return False
        if not np.max(np.abs(values - exact)) <= ROUNDING * np.max(np.abs(exact)):
            return False
    return True


def points_around(q0: Array) -> list[Array]:
    """q0 and random points near and far from it, the same in every call."""
    size, draw = float(np.max(np.abs(q0))) or 1.0, np.random.default_rng(0)
    return [q0, *(q0 + size * distance * draw.standard_normal(q0.shape) for distance in DISTANCES)]


Function = Callable[..., Any]

VECTOR, REAL = types.float64[::1], types.float64
SIGNATURE = types.void(VECTOR, VECTOR, REAL, VECTOR, VECTOR)
COMPLEX_VECTOR = types.complex128[::1]
COMPLEX_SIGNATURE = types.void(COMPLEX_VECTOR, VECTOR, REAL, VECTOR, COMPLEX_VECTOR)
FUNCTION = types.FunctionType(SIGNATURE)
OPTIONS = {"error_model": "numpy", "nogil": True}
COMPLEX_STEP = 1e-30


@dataclass(frozen=True, eq=False)
class Force:
    """f(q, v, t) of one configuration.

    Attributes
    ----------
    function
        (q (d,), v (d,), t, numbers, out (d,)), which adds the force to out; compiled for SIGNATURE,
        or plain Python
    numbers
        constants of the function
    formula
        the uncompiled function of `references.forces.formulas`; None for another force
    """

    function: Function
    numbers: Array = field(default_factory=lambda: np.zeros(0))
    formula: Function | None = None

    @property
    def compiled(self) -> bool:
        """Whether compiled loops can call it."""
        return is_jitted(self.function)

    def __call__(self, q: Array, v: Array, t: float) -> Array:
        """f(q, v, t), in the shape of v."""
        out = np.zeros(v.size)
        copies = (np.array(x, dtype=np.float64).ravel() for x in (q, v))
        self.function(*copies, float(t), self.numbers, out)
        return out.reshape(v.shape)

    def jacobian(self, q: Array, t: float) -> Array:
        """df/dq of a formula at rest, (d, d), exact to rounding by complex steps."""
        assert self.formula is not None
        function = _compiled(self.formula, COMPLEX_SIGNATURE)
        shifted, zero_velocity, time = q.ravel().astype(np.complex128), np.zeros(q.size), float(t)
        columns = np.zeros((q.size, q.size), dtype=np.complex128)
        for i, column in enumerate(columns):
            shifted[i] += 1j * COMPLEX_STEP
            function(shifted, zero_velocity, time, self.numbers, column)
            shifted[i] = shifted[i].real
        return columns.imag.T / COMPLEX_STEP


def by_formula(formula: Function, *numbers: Any) -> Force:
    """A force of `references.forces.formulas`, compiled once and cached on disk."""
    constants = np.concatenate([np.ravel(x).astype(np.float64) for x in (*numbers, [])])
    return Force(_compiled(formula, SIGNATURE), constants, formula)


def by_function(function: Function, arguments: str, sign: float) -> Force:
    """sign times a user's function of ``arguments``, such as "qvt".

    Compiled if the function is jitted and returns an array (d,). Otherwise it is called from
    Python: its exceptions pass through, and a wrong shape raises ValueError.
    """
    jitted = is_jitted(function)
    adapted = _adapted(function, arguments, sign) if jitted else None
    return Force(adapted or _called(function, arguments, sign))


def together(first: Force, second: Force) -> Force:
    """The sum of two forces, compiled when both are."""
    split = first.numbers.size
    numbers = np.concatenate([[float(split)], first.numbers, second.numbers])
    if first.compiled and second.compiled:
        return Force(_sum(first.function, second.function), numbers)

    def add(q: Array, v: Array, t: float, numbers: Array, out: Array) -> None:
        first.function(q, v, t, first.numbers, out)
        second.function(q, v, t, second.numbers, out)

    return Force(add, numbers)


@lru_cache(maxsize=64)
def _sum(first: Function, second: Function) -> Function:
    def add(q: Array, v: Array, t: float, numbers: Array, out: Array) -> None:
        split = int(numbers[0]) + 1
        first(q, v, t, numbers[1:split], out)
        second(q, v, t, numbers[split:], out)

    return njit(SIGNATURE, _nrt=False, **OPTIONS)(add)


@lru_cache(maxsize=64)
def _compiled(formula: Function, signature: Any) -> Function:
    return cached(signature, _nrt=False, **OPTIONS)(formula)


@lru_cache(maxsize=64)
def _adapted(function: Function, arguments: str, sign: float) -> Function | None:
    """The jitted function as a compiled force, NaN for a wrong length; None if it does not
    compile."""
    call: Function = {
        "q": lambda q, v, t: function(q),
        "qt": lambda q, v, t: function(q, t),
        "qv": lambda q, v, t: function(q, v),
        "qvt": lambda q, v, t: function(q, v, t),
    }[arguments]
    jitted = njit(call, **OPTIONS)

    def add(q: Array, v: Array, t: float, numbers: Array, out: Array) -> None:
        values = jitted(q.copy(), v.copy(), t)
        for i in range(out.size):
            out[i] += sign * values[i] if values.size == out.size else np.nan

    try:
        compiled: Function = njit(SIGNATURE, **OPTIONS)(add)
    except NumbaError:
        return None
    return compiled


def _called(function: Function, arguments: str, sign: float) -> Function:
    def add(q: Array, v: Array, t: float, numbers: Array, out: Array) -> None:
        by_name = {"q": q.copy(), "v": v.copy(), "t": t}
        out += sign * checked(function(*(by_name[x] for x in arguments)), out.shape)

    return add


def checked(values: Any, shape: tuple[int, ...]) -> Array:
    """The values as a float64 array; ValueError for another shape."""
    array = np.asarray(values, dtype=np.float64)
    if array.shape != shape:
        raise ValueError(
            f"a force or gradient must return an array of shape {shape}; received shape "
            f"{array.shape}."
        )
    return array

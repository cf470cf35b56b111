"""Functions of a user: whether numba compiles them, and the arrays they return."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba.extending import is_jitted

from galvi.arrays import Array
from galvi.input_checks import flag, shown

Function = Callable[..., Any]


def compiles(function: Callable[..., Any], signature: Any) -> bool:
    """Whether a function is jitted and, for the signature's arguments, returns its return type."""
    if not is_jitted(function):
        return False
    try:
        function.compile(signature.args)
        returned = cast(Any, function.overloads[signature.args]).signature.return_type
    except Exception:  # numba's typing errors have no common public base; Python mode still works
        return False
    return bool(returned == signature.return_type)


def returned_array(name: str, values: Any, shape: tuple[int, ...], expected: str) -> Array:
    """The values as a contiguous float64 array; ValueError for another shape or non-real numbers.

    Parameters
    ----------
    name
        of the function, for the message
    expected
        the expected array in words, for the message: "an array of shape ..."

    Notes
    -----
    Non-finite values pass.
    """
    array = np.asarray(values)
    if array.shape != shape:
        raise ValueError(f"{name} must return {expected}; received shape {array.shape}.")
    if array.dtype.kind not in "iuf":
        raise ValueError(
            f"{name} must return {expected}, of real numbers; received numbers of type "
            f"{array.dtype}."
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def check_given(system: Any, names: tuple[str, ...], of: str, needed: str = "") -> None:
    """TypeError unless the fields of these names are functions, or None but for the one ``needed``,
    and ``check`` is True or False.

    Parameters
    ----------
    of
        their argument, for the message
    """
    flag("check", system.check)
    for name in names:
        function = getattr(system, name)
        if not callable(function) and (name == needed or function is not None):
            raise TypeError(f"{name} must be a function of {of}; received {shown(function)}.")


def arguments(system: Any, *state: Any) -> tuple[Any, ...]:
    """The arguments of a system's functions at a state (..., t): copies of its arrays, and t where
    ``explicit_time`` is set."""
    copies = tuple(np.array(x, dtype=np.float64) for x in state[:-1])
    return (*copies, float(state[-1])) if system.explicit_time else copies


def check_arguments(system: Any, names: tuple[str, ...], of: str, timed: str) -> None:
    """TypeError for a function that cannot be called with its arguments, and the time where the
    flag is set.

    Parameters
    ----------
    of
        the arguments without the time, such as "q, v"
    timed
        name of the flag
    """
    count, is_timed = of.count(",") + 1, bool(getattr(system, timed))
    for name in names:
        function = getattr(system, name)
        try:
            signature = inspect.signature(function)
        except (TypeError, ValueError):  # None, and functions of C
            continue
        if _binds(signature, count + is_timed):
            continue
        expectation = f"{name} must be a function of ({of}{', t' * is_timed})"
        if not is_timed and _binds(signature, count + 1):
            raise TypeError(
                f"{expectation}; received one of {count + 1} arguments, {signature}. If it is one "
                f"of ({of}, t), give {timed}=True."
            )
        if is_timed and _binds(signature, count):
            raise TypeError(
                f"{expectation}, with {timed}=True; received one of {count}, {signature}. Leave "
                f"{timed} out."
            )
        raise TypeError(f"{expectation}; received {shown(function)} of {signature}.")


def _binds(signature: inspect.Signature, count: int) -> bool:
    """Whether a function of that signature can be called with so many arguments."""
    try:
        signature.bind(*[None] * count)
    except TypeError:
        return False
    return True


def values_at(function: Callable[[Array, float], float], q: Array, t: Any, axes: int) -> Array:
    """A function of one configuration, of so many axes, and its time, at each of q (..., *shape)
    and t (...); NaN where q is not finite."""
    lead = q.shape[: q.ndim - axes]
    rows, times = q.reshape(-1, *q.shape[q.ndim - axes :]), np.broadcast_to(t, lead).ravel()
    values = [
        function(x, s) if np.all(np.isfinite(x)) else np.nan
        for x, s in zip(rows, times, strict=True)
    ]
    return np.array(values, dtype=np.float64).reshape(lead)


def sympy_module() -> Any:
    """The module sympy; ImportError, saying what needs it, where it is not installed."""
    try:
        import sympy
    except ImportError as error:
        raise ImportError(
            f"galvi.Lagrangian.from_sympy needs SymPy: {error}. Install sympy."
        ) from error
    return sympy

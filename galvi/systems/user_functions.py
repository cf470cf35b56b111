"""User-supplied functions: whether numba compiles them, their arguments, the arrays they return."""

from __future__ import annotations

import inspect
from collections.abc import Callable
from typing import Any, cast

import numpy as np
from numba.extending import is_jitted

from galvi.arrays import Array
from galvi.input_checks import flag, shown

Function = Callable[..., Any]


def compiles(function: Function, signature: Any) -> bool:
    """Whether a function is jitted and, for the signature's arguments, returns its return type."""
    if not is_jitted(function):
        return False
    try:
        function.compile(signature.args)
        returned = cast(Any, function.overloads[signature.args]).signature.return_type
    except Exception:  # LLVM's and others besides NumbaError; the function still runs in Python
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
            f"{name} must return {expected}, of real numbers; received an array of type "
            f"{array.dtype}."
        )
    return np.ascontiguousarray(array, dtype=np.float64)


def check_callables(
    system: Any, names: tuple[str, ...], argument_names: str, needed: str = ""
) -> None:
    """Raise TypeError unless each named field is callable or None and ``check`` is a bool.

    Parameters
    ----------
    argument_names
        such as "q, v", for the message
    needed
        the field that may not be None
    """
    signature = f"({argument_names})" if "," in argument_names else argument_names
    flag("check", system.check)
    for name in names:
        function = getattr(system, name)
        if not callable(function) and (name == needed or function is not None):
            raise TypeError(
                f"{name} must be a function of {signature}; received {shown(function)}."
            )


def arguments(system: Any, *state: Any) -> tuple[Any, ...]:
    """The arguments of the functions of a system with the flag ``explicit_time``, at a state
    (..., t): copies of its arrays, and t where the flag is set."""
    copies = tuple(np.array(x, dtype=np.float64) for x in state[:-1])
    return (*copies, float(state[-1])) if system.explicit_time else copies


def check_call_signatures(
    system: Any, names: tuple[str, ...], argument_names: str, time_flag: str
) -> None:
    """Raise TypeError unless each function with a signature takes these arguments, and t where the
    flag is set.

    Parameters
    ----------
    argument_names
        without the time, such as "q, v"
    time_flag
        name of the flag
    """
    count, takes_time = argument_names.count(",") + 1, bool(getattr(system, time_flag))
    for name in names:
        function = getattr(system, name)
        try:
            signature = inspect.signature(function)
        except (TypeError, ValueError):  # None, or a builtin without a signature
            continue
        if _binds(signature, count + takes_time):
            continue
        expectation = f"{name} must be a function of ({argument_names}{', t' * takes_time})"
        if not takes_time and _binds(signature, count + 1):
            raise TypeError(
                f"{expectation}; received a function of {count + 1} arguments, {signature}. If it "
                f"is one of ({argument_names}, t), give {time_flag}=True."
            )
        if takes_time and _binds(signature, count):
            raise TypeError(
                f"{expectation}, with {time_flag}=True; received a function of {count}, "
                f"{signature}. Leave {time_flag} out."
            )
        raise TypeError(f"{expectation}; received {shown(function)} of {signature}.")


def _binds(signature: inspect.Signature, count: int) -> bool:
    """Whether a function of that signature can be called with ``count`` arguments."""
    try:
        signature.bind(*[None] * count)
    except TypeError:
        return False
    return True


def values_at(function: Callable[[Array, float], float], q: Array, t: Any, ndim: int) -> Array:
    """function(q, t) at each configuration of q (..., *shape), where ``shape`` has ``ndim`` axes,
    and each t (...); NaN where q is not finite."""
    lead = q.shape[: q.ndim - ndim]
    rows, times = q.reshape(-1, *q.shape[q.ndim - ndim :]), np.broadcast_to(t, lead).ravel()
    values = [
        function(x, time) if np.all(np.isfinite(x)) else np.nan
        for x, time in zip(rows, times, strict=True)
    ]
    return np.array(values, dtype=np.float64).reshape(lead)


def sympy_module() -> Any:
    """The module sympy; ImportError with the remedy where it is not installed."""
    try:
        import sympy
    except ImportError as error:
        raise ImportError(
            f"Lagrangians by SymPy need the package sympy: {error}. Install sympy."
        ) from error
    return sympy

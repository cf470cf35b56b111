"""Calls from kernels to functions given by their addresses.

A kernel takes the addresses of a system's functions in an array of integers, so that one kernel,
compiled once and cached on disk, serves every system. (numba's first-class functions do the same,
but passing a dozen of them to the next kernel takes longer than evaluating a small Lagrangian.) The
interpreted form of a kernel takes the functions themselves, in a tuple.

    call_void(functions[0], Q, t, constants, out)       a function that returns nothing
    call_vector(functions[0], q)                        a function that returns a vector (d,)
    call_matrix(functions[1], q, t)                     a function that returns a matrix (d, d)
"""

from __future__ import annotations

import operator
from collections.abc import Callable
from functools import cache
from types import FunctionType
from typing import Any

import numpy as np
from numba import types
from numba.extending import intrinsic, is_jitted

from galvi.kernels.compile.internals import errors, impl_ret_new_ref
from galvi.kernels.compile.jit import MATRIX, REAL, TENSOR3, VECTOR


def addresses(*functions: tuple[Callable[..., Any] | None, Any]) -> Any:
    """Addresses (n,) of the compiled code of each (function, signature); 0 for None.

    The functions must exist as long as the addresses are used.

    Raises
    ------
    TypeError
        For a function that is not jitted or does not return the type of its signature.
    """
    pointers = [0 if f is None else _address(f, signature) for f, signature in functions]
    return np.array(pointers, dtype=np.int64)


def _address(function: Any, signature: Any) -> int:
    if not is_jitted(function):
        raise TypeError(
            f"a compiled kernel calls functions compiled with numba.njit; received {function!r}."
        )
    if signature.args not in function.overloads:
        function.compile(signature.args)
    code: Any = function.overloads[signature.args]
    address = int(code.library.get_pointer_to_function(code.fndesc.llvm_func_name))
    if code.signature.return_type != signature.return_type or address == 0:
        raise TypeError(
            f"{function.py_func.__name__} must return {signature.return_type} for "
            f"{signature.args}; it returns {code.signature.return_type}."
        )
    return address


def _typed_call(returned, address, arguments):
    """The type and the code generator of a call; exceptions of the function reach the caller.

    Raises
    ------
    TypingError
        For an argument that is no float, array of floats or int64.
    """
    for argument in arguments:
        if argument not in (REAL, VECTOR, MATRIX, TENSOR3, types.int64):
            raise errors.TypingError(f"a function called by its address cannot take {argument}")

    def generate(context, builder, signature, values):
        kind = context.call_conv.get_function_type(returned, arguments).as_pointer()
        unpacked = [builder.extract_value(values[1], i) for i in range(len(arguments))]
        status, returned_value = context.call_conv.call_function(
            builder, builder.inttoptr(values[0], kind), returned, arguments, unpacked
        )
        with builder.if_then(status.is_error, likely=False):
            context.call_conv.return_status_propagate(builder, status)
        if returned == types.void:
            return context.get_dummy_value()
        return impl_ret_new_ref(context, builder, returned, returned_value)

    return returned(address, types.StarArgTuple(arguments)), generate


@intrinsic
def call_void(typing_context, address, *arguments):
    """Call a function that returns nothing."""
    return _typed_call(types.void, address, arguments)


@intrinsic
def call_vector(typing_context, address, *arguments):
    """Call a function that returns a vector."""
    return _typed_call(VECTOR, address, arguments)


@intrinsic
def call_matrix(typing_context, address, *arguments):
    """Call a function that returns a matrix."""
    return _typed_call(MATRIX, address, arguments)


CALLS = (call_void, call_vector, call_matrix)


def interpreted(kernel: Any) -> Callable[..., Any]:
    """The Python form of a kernel, for functions of a user that cannot be compiled.

    Of the kernels that it calls, directly or not, those that call a function by its address are in
    Python form too; all others stay compiled. Exceptions and Ctrl-C behave as in any Python
    program.
    """
    source = kernel.py_func
    names = dict(source.__globals__)
    for name, value in _referenced_functions(kernel).items():
        if value in CALLS:
            names[name] = operator.call
        elif is_jitted(value) and _calls_by_address(value):
            names[name] = interpreted(value)
    return FunctionType(source.__code__, names, source.__name__, source.__defaults__)


@cache
def _calls_by_address(kernel: Any) -> bool:
    """Whether the kernel, or one that it calls, calls a function by its address."""
    return any(
        value in CALLS or (is_jitted(value) and _calls_by_address(value))
        for value in _referenced_functions(kernel).values()
    )


def _referenced_functions(kernel: Any) -> dict[str, Any]:
    """Name -> callable, for the global names in a kernel's code; without the kernel itself."""
    source = kernel.py_func
    referenced = {name: source.__globals__.get(name) for name in source.__code__.co_names}
    return {
        name: value for name, value in referenced.items() if callable(value) and value is not kernel
    }

"""Traces a user's function by calling it once with symbols."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable, Sequence
from inspect import getattr_static
from types import CellType, CodeType, FunctionType, MethodType, ModuleType
from typing import Any

import numpy as np
from numba.extending import is_jitted

from galvi.systems.traces import Untraceable
from galvi.tracing.graph import Graph, Node

FUNCTIONS = (
    "sin", "cos", "tan", "exp", "log", "sqrt", "sinh", "cosh", "tanh", "arctan", "arcsin",
    "arccos", "log2", "log10", "radians", "degrees", "fabs", "deg2rad", "rad2deg", "arctan2",
    "hypot",
)  # fmt: skip
IN_MATH = {"arctan": "atan", "arcsin": "asin", "arccos": "acos", "arctan2": "atan2"}
# Functions that create an array -> position of the argument dtype.
ARRAY_FUNCTIONS = {
    "zeros": 1, "ones": 1, "empty": 1, "full": 2, "zeros_like": 1, "ones_like": 1, "empty_like": 1,
    "full_like": 2, "eye": 3, "identity": 1, "array": 1, "asarray": 1, "ascontiguousarray": 1,
    "diag": 9,
}  # fmt: skip
MAX_FUNCTIONS = 200  # largest number of functions that a traced one may call, directly or not


class StandIns:
    """Replacements of numpy and math for symbols of a graph, and of functions that use them.

    For arguments without symbols they call the functions of numpy and math, but new arrays of real
    numbers can hold symbols.
    """

    def __init__(self, graph: Graph) -> None:
        self.graph = graph
        self.rewritten: dict[int, Any] = {}
        numpy, math_functions = {}, {}
        for name in FUNCTIONS:
            numpy_function = getattr(np, name)
            numpy[name] = self._elementwise(name, numpy_function)
            math_name = IN_MATH.get(name, name)
            if hasattr(math, math_name):
                math_functions[math_name] = self._elementwise(name, getattr(math, math_name))
        for name, twin in IN_MATH.items():
            numpy[twin] = numpy[name]
        math_functions["log"] = self._log
        math_functions["pow"] = lambda x, y: x**y if _has_symbols(x, y) else math.pow(x, y)
        numpy |= {
            name: self._new(name, dtype_position)
            for name, dtype_position in ARRAY_FUNCTIONS.items()
        }
        self.modules = {np: _Module(np, numpy), math: _Module(math, math_functions)}
        self.functions = {
            id(getattr(module, name)): function
            for module, stand_ins in ((np, numpy), (math, math_functions))
            for name, function in stand_ins.items()
            if hasattr(module, name)
        }

    def stand_in_of(self, value: Any) -> Any:
        """The stand-in of a module or a function; any other value itself."""
        if isinstance(value, ModuleType):
            return self.modules.get(value, value)
        if is_jitted(value):
            value = value.py_func
        if isinstance(value, MethodType):
            return MethodType(self.stand_in_of(value.__func__), value.__self__)
        if isinstance(value, functools.partial):
            return functools.partial(self.stand_in_of(value.func), *value.args, **value.keywords)
        if isinstance(value, FunctionType):
            return self.rewritten.get(id(value)) or self._rewrite(value)
        return self.functions.get(id(value), value)

    def _rewrite(self, function: FunctionType) -> FunctionType:
        """The function with stand-ins for the functions and modules that it refers to."""
        if len(self.rewritten) == MAX_FUNCTIONS:
            self.graph.refuse(f"it calls more than {MAX_FUNCTIONS} functions")
        names = dict(function.__globals__)
        cells = tuple(CellType() for _ in function.__closure__ or ())
        rewritten = FunctionType(function.__code__, names, function.__name__, None, cells or None)
        self.rewritten[id(function)] = rewritten
        for name in _names(function.__code__) & names.keys():
            names[name] = self.stand_in_of(names[name])
        for cell, original in zip(cells, function.__closure__ or (), strict=True):
            try:
                cell.cell_contents = self.stand_in_of(original.cell_contents)
            except ValueError:  # not yet assigned
                continue
        if function.__defaults__:
            rewritten.__defaults__ = tuple(map(self.stand_in_of, function.__defaults__))
        if function.__kwdefaults__:
            rewritten.__kwdefaults__ = {
                k: self.stand_in_of(x) for k, x in function.__kwdefaults__.items()
            }
        return rewritten

    def _elementwise(self, name: str, true: Callable[..., Any]) -> Callable[..., Any]:
        def evaluate(x: Any, *operands: Any) -> Any:
            node = self.graph.as_node(x)
            if node is None:
                self.graph.refuse(f"it calls {name} of {type(x).__name__}")
            return getattr(node, name)(*operands)

        def function(*arguments: Any, **options: Any) -> Any:
            if not _has_symbols(*arguments):
                return true(*arguments, **options)
            if options:
                self.graph.refuse(f"it calls {name} with {', '.join(options)}")
            return np.frompyfunc(evaluate, len(arguments), 1)(*arguments)

        return function

    def _log(self, x: Any, *base: Any) -> Any:
        if not _has_symbols(x, *base):
            return math.log(x, *base)
        logarithm = self.graph.as_node(x).log()  # type: ignore[union-attr]
        return logarithm / self._log(*base) if base else logarithm

    def _new(self, name: str, dtype_position: int) -> Callable[..., Any]:
        true = getattr(np, name.replace("empty", "zeros"))

        def function(*arguments: Any, dtype: Any = None, **options: Any) -> Any:
            dtype = arguments[dtype_position] if len(arguments) > dtype_position else dtype
            if dtype is not None and np.dtype(dtype).kind != "f":
                return true(*arguments[:dtype_position], dtype=dtype, **options)
            array = true(*arguments[:dtype_position], **options)
            return self._entries(array) if dtype or array.dtype.kind in "fO" else array

        return function

    def _entries(self, values: Any) -> Any:
        """An array of nodes for the values; entries that are no numbers are unchanged."""
        nodes = np.empty(values.shape, dtype=object)
        for k in np.ndindex(values.shape):
            node = self.graph.as_node(values[k])
            nodes[k] = values[k] if node is None else node
        return nodes


class _Module:
    """A module with some functions replaced."""

    def __init__(self, module: ModuleType, functions: dict[str, Callable[..., Any]]) -> None:
        self._module, self._functions = module, functions

    def __getattr__(self, name: str) -> Any:
        stand_in = self._functions.get(name)
        return getattr(self._module, name) if stand_in is None else stand_in


def _has_symbols(*values: Any) -> bool:
    """Whether a value is a symbol, or an array or a list of objects, which may hold symbols."""
    return any(isinstance(x, Node) or np.asarray(x).dtype == object for x in values)


def _names(code: CodeType) -> set[str]:
    """The names in a function's code, and in the code of functions defined in it."""
    names = set(code.co_names)
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            names |= _names(constant)
    return names


def traced_nodes(
    function: Callable[..., Any], arguments: Sequence[Any], shape: tuple[int, ...]
) -> list[Node]:
    """The numbers that a function returns, as nodes: an array of this shape, () or (n,).

    Parameters
    ----------
    arguments
        nodes and arrays of nodes of one graph, which are not changed

    Raises
    ------
    Untraceable
        For a function that needs the value of a symbol, as a branch does, that calls a function
        without an expression here, that raises an exception, or that returns another shape.

    Notes
    -----
    Numbers to which the function refers become constants.
    """
    copies = [x.copy() if isinstance(x, np.ndarray) else x for x in arguments]
    graph: Graph = next(x for a in copies for x in np.ravel(a)).graph
    graph.refusal = ""
    try:
        with np.errstate(all="ignore"):
            returned = np.asarray(_callable(function, StandIns(graph))(*copies), dtype=object)
            entries = [graph.as_node(x) for x in returned.ravel()]
    except Untraceable:
        raise
    except Exception as error:  # whatever the function raises with symbols
        reason = graph.refusal or f"it raises {type(error).__name__} with symbols: {error}"
        raise Untraceable(reason) from error
    if graph.refusal:
        raise Untraceable(graph.refusal)
    nodes = [x for x in entries if x is not None]
    if returned.shape != shape or len(nodes) < returned.size:
        raise Untraceable(f"it does not return real numbers of shape {shape}")
    return nodes


def _callable(function: Any, stand_ins: StandIns) -> Callable[..., Any]:
    call = getattr_static(function, "__call__", None)
    if not is_jitted(function) and isinstance(call, FunctionType):
        function = MethodType(call, function)
    return stand_ins.stand_in_of(function)

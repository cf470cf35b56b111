"""What tells one computation from another, also in another process: values as nested tuples."""

from __future__ import annotations

import dis
import sys
from collections.abc import Iterator, Mapping
from copyreg import dispatch_table
from dataclasses import fields, is_dataclass
from pickle import PicklingError
from types import (
    BuiltinFunctionType,
    CellType,
    CodeType,
    FunctionType,
    GetSetDescriptorType,
    MemberDescriptorType,
    MethodType,
    ModuleType,
)
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

from galvi.input_checks import shown

ATOMS = (type(None), type(...), bool, int, float, complex, str, bytes)
NOT_OF_A_CLASS = {  # entries of a class that say nothing about what it computes
    "__dict__", "__weakref__", "__doc__", "__module__", "__annotations__", "__abstractmethods__",
    "_abc_impl", "__firstlineno__", "__static_attributes__", "__annotate__",
    "__annotate_func__", "__annotations_cache__",
}  # fmt: skip


def identity(value: Any) -> Any:
    """A value as nested tuples of numbers and texts that tell it from others.

    A function is its code, defaults, closure, attributes and the globals that it names, with the
    functions among them; an object is its class and what pickle would keep of it; a class is its
    methods. What belongs to the standard library, galvi, or an installed package is its name and
    the package's version. Raises ValueError for what cannot be told apart.
    """
    return _Walk().plain(value)


class _Walk:
    """One walk, which numbers the functions, classes and objects it meets."""

    def __init__(self) -> None:
        self.met: dict[int, tuple[int, Any]] = {}  # by id; the values are kept alive

    def plain(self, value: Any) -> Any:
        """As `identity`."""
        kind = type(value)
        if kind in ATOMS:
            return kind.__name__, repr(value)
        if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
            return "array", value.dtype.str, value.shape, value.tobytes().hex()
        if kind is tuple:
            return "tuple", tuple(map(self.plain, value))
        if kind in (set, frozenset):
            return kind.__name__, tuple(sorted(map(self.plain, value), key=repr))
        if isinstance(value, CodeType):
            return self._code(value)
        if isinstance(value, CellType):
            return ("cell",) if value == CellType() else ("cell", self.plain(value.cell_contents))
        if isinstance(value, ModuleType):
            return "module", value.__name__, _version(value.__name__)
        if id(value) in self.met:
            return "met", self.met[id(value)][0]
        self.met[id(value)] = len(self.met), value
        return self._met_first(value)

    def _met_first(self, value: Any) -> Any:
        if type(value) is list:
            return "list", tuple(map(self.plain, value))
        if isinstance(value, Mapping):
            items = ((self.plain(key), self.plain(item)) for key, item in _sorted(value))
            return type(value).__qualname__, tuple(items)
        if isinstance(value, Dispatcher):
            return "compiled", self.plain(value.py_func), self.plain(dict(value.targetoptions))
        if isinstance(value, MethodType):
            return "method", self.plain(value.__func__), self.plain(value.__self__)
        if isinstance(value, FunctionType):
            return self._function(value)
        if isinstance(value, BuiltinFunctionType):
            return "builtin", value.__qualname__, self.plain(value.__self__)
        if isinstance(value, type):
            return self._class(value)
        if isinstance(value, staticmethod | classmethod):
            return type(value).__name__, self.plain(value.__func__)
        if isinstance(value, property):
            return "property", *map(self.plain, (value.fget, value.fset, value.fdel))
        if isinstance(value, GetSetDescriptorType | MemberDescriptorType):
            return "descriptor", value.__qualname__
        if is_dataclass(value) and _version(type(value).__module__) is not None:
            named = (
                (field.name, self.plain(getattr(value, field.name))) for field in fields(value)
            )
            return self.plain(type(value)), tuple(named)
        return self._object(value)

    def _code(self, code: CodeType) -> Any:
        about = code.co_argcount, code.co_kwonlyargcount, code.co_flags, code.co_names
        return "code", code.co_code.hex(), *about, tuple(map(self.plain, code.co_consts))

    def _function(self, function: FunctionType) -> Any:
        installed = _version(function.__module__)
        own = (
            function.__code__, function.__defaults__, function.__kwdefaults__,
            function.__closure__, function.__dict__,
        )  # fmt: skip
        if installed is not None:
            name = function.__module__, function.__qualname__, installed
            return "function", name, *map(self.plain, own[1:4])
        return "function", *map(self.plain, own), tuple(self._globals(function))

    def _globals(self, function: FunctionType) -> Iterator[Any]:
        codes = list(_codes(function.__code__))
        names = {name for code in codes for name in _global_names(code)}
        attributes = sorted({name for code in codes for name in code.co_names})
        for name in sorted(names & function.__globals__.keys()):
            value = function.__globals__[name]
            yield name, self.plain(value)
            if isinstance(value, ModuleType) and _version(value.__name__) is None:
                for attribute in attributes:
                    if hasattr(value, attribute):
                        yield name, attribute, self.plain(getattr(value, attribute))

    def _class(self, value: type) -> Any:
        name, installed = (value.__module__, value.__qualname__), _version(value.__module__)
        if installed is not None:
            return "class", name, installed
        own = {key: item for key, item in vars(value).items() if key not in NOT_OF_A_CLASS}
        return "class", name, self.plain(value.__bases__), self.plain(own)

    def _object(self, value: Any) -> Any:
        try:
            reduce = dispatch_table.get(type(value))
            parts = value.__reduce_ex__(4) if reduce is None else reduce(value)
        except (TypeError, ValueError, AttributeError, NotImplementedError, PicklingError) as error:
            raise ValueError(
                f"what an ensemble in a folder computes must be told from other work by values; "
                f"received {shown(value)}, which cannot be: {error}. Give numbers, arrays, "
                f"functions of them, or objects that pickle, or no folder."
            ) from error
        if isinstance(parts, str):
            return "named", type(value).__module__, parts, _version(type(value).__module__)
        made, arguments, *more = parts
        state = [list(x) if isinstance(x, Iterator) else x for x in more]
        return "object", self.plain(type(value)), self.plain(made), self.plain((*arguments, *state))


def _sorted(mapping: Mapping[Any, Any]) -> list[tuple[Any, Any]]:
    return sorted(mapping.items(), key=lambda item: (type(item[0]).__name__, repr(item[0])))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions in it."""
    yield code
    for constant in code.co_consts:
        if isinstance(constant, CodeType):
            yield from _codes(constant)


def _global_names(code: CodeType) -> set[str]:
    wanted = ("LOAD_GLOBAL", "LOAD_NAME")
    return {step.argval for step in dis.get_instructions(code) if step.opname in wanted}


def _version(module: str | None) -> str | None:
    """The version of the package that a module belongs to; None for the caller's own."""
    top = (module or "").partition(".")[0]
    if top == "galvi" or top in sys.stdlib_module_names or top == "builtins":
        return ""  # told apart by the versions of galvi and Python
    package = sys.modules.get(top)
    file = getattr(package, "__file__", None) or ""
    if "site-packages" in file or "dist-packages" in file:
        return str(getattr(package, "__version__", ""))
    return None

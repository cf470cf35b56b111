"""What tells one ensemble from another, also in another process: values and texts, no functions."""

from __future__ import annotations

import ast
import hashlib
import time
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from functools import cache
from pathlib import Path
from pickle import PicklingError
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

ATOMS = (type(None), bool, int, float, complex, str, bytes, Decimal)
OTHERS = {
    "analysis",
    "diagnostics",
    "interop",
    "properties",
    "recommend",
}  # no run needs them
IMPORTED = time.time()
NAMED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def identity(value: Any, version: str | None) -> Any:
    """A value as nested tuples of numbers and texts that tell it from others.

    version  of the caller's functions and classes, of which only names and values are looked at

    Raises ValueError when there is such a function or class, and no version: which other code it
    calls cannot be known.
    """
    kind = type(value)
    if kind in ATOMS:
        return kind.__name__, repr(value)
    if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
        return "array", value.dtype.str, value.shape, value.tobytes().hex()
    if isinstance(value, tuple | list):
        return kind.__name__, tuple(identity(item, version) for item in value)
    if isinstance(value, set | frozenset):
        return "set", tuple(sorted((identity(item, version) for item in value), key=repr))
    if isinstance(value, Mapping):
        items = [(identity(key, version), identity(item, version)) for key, item in value.items()]
        return "mapping", tuple(sorted(items, key=repr))
    if isinstance(value, np.ndarray):
        return "array", value.shape, identity(value.ravel().tolist(), version)
    named = hasattr(value, "__qualname__")  # functions and classes
    owner: Any = value if named else kind
    name = f"{owner.__module__}.{owner.__qualname__}"
    known = (named and "<" not in name) or (not named and is_dataclass(value))
    if version is None and not (name.startswith("galvi.") and known):
        raise ValueError(
            f"files in a folder cannot be told from those of earlier code of {name}, since what it "
            f"calls cannot be known. Give version='1', and another text whenever that code, or "
            f"what it calls, has changed."
        )
    if is_dataclass(value) and not named:
        own = {one.name: getattr(value, one.name) for one in fields(value)}
        return name, identity(own, version)
    return (name,) if version is None else (name, identity(_values(value), version))


def _values(value: Any) -> Any:
    """What a function or an object holds, which its version does not tell.

    Its own bytecode is among that, since two functions may have one name, such as <lambda>.
    """
    if isinstance(value, type | BuiltinFunctionType | np.ufunc):
        return None
    if isinstance(value, Dispatcher):
        return _values(value.py_func)
    if isinstance(value, MethodType):
        return value.__self__, _values(value.__func__)
    if isinstance(value, FunctionType):
        code, cells = value.__code__, value.__closure__ or ()
        constants = [one for one in code.co_consts if not isinstance(one, CodeType)]
        held = [one.cell_contents for one in cells if one != CellType()]
        return code.co_code, constants, value.__defaults__, value.__kwdefaults__, held
    try:
        return value.__reduce_ex__(2)[1:3]
    except (TypeError, ValueError, AttributeError, NotImplementedError, PicklingError) as error:
        raise ValueError(
            f"files in a folder are told apart by values; those of {type(value).__qualname__} "
            f"cannot be had: {error}. Give numbers, arrays, functions of them, or no folder."
        ) from error


@cache
def digest_of_galvi() -> str:
    """A digest of the code that runs depend on: syntax trees without docstrings and comments.

    Raises ValueError where a file was changed since this process imported galvi.
    """
    digest, top = hashlib.sha256(), Path(__file__).parents[2]
    for path in sorted(top.rglob("*.py")):
        if not OTHERS & {*path.relative_to(top).parts}:
            if IMPORTED < path.stat().st_mtime <= time.time():
                raise ValueError(
                    f"galvi's {path.name} was changed after this process had imported galvi, so "
                    f"that results in a folder would be of unknown code. Start Python anew."
                )
            tree = ast.parse(path.read_bytes())
            for node in _documented(tree):
                node.body = node.body[1:]
            digest.update(ast.dump(tree).encode())
    return digest.hexdigest()


def _documented(tree: ast.Module) -> Iterator[Any]:
    """The module, classes and functions that have a docstring."""
    for node in ast.walk(tree):
        if isinstance(node, NAMED) and ast.get_docstring(node, clean=False) is not None:
            yield node

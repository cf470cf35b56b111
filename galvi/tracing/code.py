"""Generates compiled code from SymPy expressions and caches it on disk.

The code depends on the expression alone, not on the names or values of parameters, and is the same
in every process. Its file is named after its content, so that galvi.kernels.compile.cache finds the
compiled form again.
"""

from __future__ import annotations

import hashlib
import os
import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from galvi.kernels.compile.cache import KernelCache
from galvi.kernels.compile.jit import jit
from galvi.kernels.forces import lagrangian_derivatives
from galvi.whole_files import write_whole

POWER = "power"  # name of the function in galvi.lanes.elementary
MAX_CACHED_EXPRESSIONS = 1000  # largest number of expressions whose code stays on disk, 60 kB each
EXPRESSIONS_FOLDER = "galvi-expressions"
FROM_MATH = {"erf", "erfc", "gamma", "lgamma"}
FROM_NUMPY = {
    "sin", "cos", "tan", "asin", "acos", "atan", "atan2", "sinh", "cosh", "tanh", "asinh", "acosh",
    "atanh", "exp", "expm1", "log", "log10", "log1p", "log2", "sqrt", "hypot", "floor", "ceil",
    "sign", "maximum", "minimum", "pi", "e", "nan",
}  # fmt: skip
NUMPY_NAMES = {
    "asin": "arcsin",
    "acos": "arccos",
    "atan": "arctan",
    "atan2": "arctan2",
    "asinh": "arcsinh",
    "acosh": "arccosh",
    "atanh": "arctanh",
}


def code_lines(
    expressions: Sequence[Any],
    arguments: Mapping[Any, str],
    store: Callable[[int, str], str],
    power: str = "",
) -> list[str]:
    """Lines of Python that compute the expressions, with common subexpressions computed once.

    Parameters
    ----------
    arguments
        symbol -> its code, e.g. 'q[0]'
    store
        (index of the expression, its code) -> the line that stores it
    power
        name of a function for powers; "" for the operator **

    Raises
    ------
    ValueError
        For a function that has no compiled form; the message names it.
    """
    import sympy

    shared, reduced = sympy.cse(
        list(expressions), symbols=sympy.numbered_symbols("x", real=True), order="canonical"
    )
    used = set().union(*(e.free_symbols for e in [*reduced, *(e for _, e in shared)]))
    lines = [f"{s} = {code}" for s, code in arguments.items() if s in used]
    lines += [f"{name} = {python_code(e, power)}" for name, e in shared]
    return lines + [store(k, python_code(e, power)) for k, e in enumerate(reduced)]


def python_code(expression: Any, power: str = "") -> str:
    """The Python code of an expression, by the functions of FROM_MATH and FROM_NUMPY.

    Parameters
    ----------
    power
        name of a function for powers; "" for the operator **

    Raises
    ------
    ValueError
        For a function that has no compiled form; the message names it.
    """
    import sympy
    from sympy.printing.codeprinter import PrintMethodNotImplementedError
    from sympy.printing.pycode import PythonCodePrinter

    class Printer(PythonCodePrinter):  # type: ignore[misc]
        def _print_Integer(self, number: Any) -> str:
            return str(number.p) if abs(number.p) < 2**31 else repr(float(number))

        def _print_Rational(self, number: Any) -> str:
            return repr(float(number))

        _print_Half = _print_Rational

        def _print_Pow(self, node: Any, rational: bool = False) -> str:
            if not power or node.exp == sympy.Rational(1, 2):
                return str(super()._print_Pow(node, rational))
            return f"{power}({self._print(node.base)}, {self._print(node.exp)})"

        def _print_sign(self, node: Any) -> str:
            return f"sign({self._print(node.args[0])})"

        def _print_Piecewise(self, node: Any) -> str:
            code = "nan"  # where no condition holds
            for value, condition in reversed(node.args):
                code = f"({self._print(value)} if {self._print(condition)} else {code})"
            return code

        def _print_Max(self, node: Any) -> str:
            return self._nested("maximum", node.args)

        def _print_Min(self, node: Any) -> str:
            return self._nested("minimum", node.args)

        def _nested(self, name: str, operands: Any) -> str:
            first, *following = operands
            nested = following and self._nested(name, following)
            return f"{name}({self._print(first)}, {nested})" if nested else str(self._print(first))

    try:
        code = Printer({"fully_qualified_modules": False, "strict": True}).doprint(expression)
    except PrintMethodNotImplementedError:
        code = ""
    names = {str(symbol) for symbol in expression.free_symbols}
    unknown = _names(code) - names - FROM_MATH - FROM_NUMPY - {"abs", power}
    if not code or unknown:
        heads = sorted({type(f).__name__ for f in expression.atoms(_function_class())})
        raise ValueError(
            f"the Lagrangian, its derivatives and the force must be made of functions that can be "
            f"compiled; received one of {', '.join(sorted(unknown) or heads)}. Replace it, or give "
            f"galvi.Lagrangian functions of Python."
        )
    return str(code)


def source(bodies: Mapping[str, tuple[str, list[str]]]) -> str:
    """The source of a module of functions, from name -> (arguments, lines); a digest of the source
    is appended to each name."""
    text = "\n".join(
        f"\n\ndef {name}_DIGEST({arguments}):\n" + "\n".join(f"    {line}" for line in lines)
        for name, (arguments, lines) in bodies.items()
    )
    names = _names(text)
    math = sorted(names & FROM_MATH)
    numpy = [
        f"{NUMPY_NAMES[n]} as {n}" if n in NUMPY_NAMES else n for n in sorted(names & FROM_NUMPY)
    ]
    head = [f"from math import {', '.join(math)}"] * bool(math)
    head += [f"from numpy import {', '.join(numpy)}"] * bool(numpy)
    return with_digest("\n".join(head) + text + "\n")


def with_digest(text: str) -> str:
    """The source with _DIGEST in names of functions replaced by a digest of the source."""
    return text.replace("_DIGEST(", f"_{hashlib.sha256(text.encode()).hexdigest()[:16]}(")


def functions_in(code: str) -> set[str]:
    """The names of FROM_MATH and FROM_NUMPY, and POWER, that occur in code."""
    return _names(code) & (FROM_MATH | FROM_NUMPY | {POWER})


@lru_cache(maxsize=256)
def functions(text: str) -> Mapping[str, Any]:
    """Name without the digest -> function of a source, compiled at its first call."""
    path = _cached_file(text)
    # Compiled code on disk is tied to a module that can be imported.
    names: dict[str, Any] = {"__name__": __name__, "np": np}
    exec(compile(text, str(path or "<an expression>"), "exec"), names)
    generated_functions = {
        name: f for name, f in names.items() if re.search("_[0-9a-f]{16}$", name)
    }
    return {
        name.rpartition("_")[0]: jit(function) for name, function in generated_functions.items()
    }


def _cached_file(text: str) -> Path | None:
    """The cached file with this text, written if absent; None if the cache is not writable."""
    with suppress(RuntimeError, OSError):
        folder = (
            Path(KernelCache(lagrangian_derivatives.rigid_body.py_func).cache_path)
            / EXPRESSIONS_FOLDER
        )
        entry = folder / hashlib.sha256(text.encode()).hexdigest()[:16]
        path = entry / "expression.source"
        if not path.exists() or path.read_text("utf-8") != text:
            entry.mkdir(parents=True, exist_ok=True)
            write_whole(path, text)
            _delete_old_expressions(folder)
        os.utime(path)
        return path
    return None


def _delete_old_expressions(folder: Path) -> None:
    """Delete all but the MAX_CACHED_EXPRESSIONS most recently used expressions."""
    by_use = sorted(folder.glob("*/expression.source"), key=lambda path: path.stat().st_mtime)
    for path in by_use[:-MAX_CACHED_EXPRESSIONS]:
        shutil.rmtree(path.parent, ignore_errors=True)


def _names(code: str) -> set[str]:
    import ast

    return {node.id for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)}


def _function_class() -> Any:
    import sympy

    return sympy.Function

"""Compiles generated code and caches it on disk.

The code depends on the expression alone, not on the names or values of parameters, and is the same
in every process. Its file is named after its content, so that galvi.kernels.compile.cache finds the
compiled form again.
"""

from __future__ import annotations

import ast
import hashlib
import os
import re
import shutil
from collections.abc import Mapping, Sequence
from contextlib import suppress
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.kernels.compile.cache import KernelCache
from galvi.kernels.compile.jit import jit
from galvi.kernels.forces import lagrangian_derivatives
from galvi.whole_files import write_whole

POWER = "power"  # of galvi.lanes.elementary
KEPT_EXPRESSIONS = 1000  # most expressions whose code is kept on disk, 60 kB each
EXPRESSIONS_FOLDER = "galvi-expressions"
IMPORTS = {  # function that code may have -> the line that imports it
    **{name: f"from math import {name}" for name in ("erf", "erfc", "gamma", "lgamma")},
    **{name: f"from numpy import {name}" for name in (
        "sin", "cos", "tan", "sinh", "cosh", "tanh", "arcsinh", "arccosh", "arctanh", "exp",
        "expm1", "log", "log1p", "sqrt", "floor", "ceil", "sign", "nan",
    )},
    "atan2": "from numpy import arctan2 as atan2",
}  # fmt: skip


def source(bodies: Mapping[str, list[str]]) -> str:
    """The source of functions (q, v, t, c, out) from name -> lines; names get a digest of it."""
    text = "\n".join(
        f"\n\ndef {name}_DIGEST(q, v, t, c, out):\n" + "\n".join(f"    {line}" for line in lines)
        for name, lines in bodies.items()
    )
    head = [IMPORTS[name] for name in sorted(functions_in(text) - {POWER})]
    return with_digest("\n".join(head) + text + "\n")


def with_digest(text: str) -> str:
    """The source with its own digest in the names that end with _DIGEST."""
    return text.replace("_DIGEST(", f"_{hashlib.sha256(text.encode()).hexdigest()[:16]}(")


def functions_in(code: str) -> set[str]:
    """The names of IMPORTS, and POWER, that occur in code."""
    names = {node.id for node in ast.walk(ast.parse(code)) if isinstance(node, ast.Name)}
    return names & {*IMPORTS, POWER}


@lru_cache(maxsize=256)
def functions(text: str) -> Mapping[str, Any]:
    """The functions of a source by name, without the digest; compiled at the first call."""
    path = _kept(text)
    # Compiled code on disk is tied to a module that can be imported.
    names: dict[str, Any] = {"__name__": __name__, "np": np}
    exec(compile(text, str(path or "<an expression>"), "exec"), names)
    made = {name: f for name, f in names.items() if re.search("_[0-9a-f]{16}$", name)}
    return {name.rpartition("_")[0]: jit(function) for name, function in made.items()}


def in_python(
    text: str, name: str, shape: tuple[int, ...], q: Array, v: Array, t: float,
    constants: Sequence[float],
) -> Array:  # fmt: skip
    """What a function of a source makes of zeros of this shape, without compilation; NaN where it
    is undefined."""
    out = np.zeros(shape)
    function = functions(text)[name].py_func
    try:
        with np.errstate(all="ignore"):
            function(np.ravel(q), np.asarray(v), np.float64(t), np.array(constants), out)
    except (ArithmeticError, ValueError):  # math's functions raise where numpy's are NaN
        out[...] = np.nan
    return out


def _kept(text: str) -> Path | None:
    """The cached file with this text, written if absent; None where the cache is not writable."""
    with suppress(RuntimeError, OSError):
        folder = (
            Path(KernelCache(lagrangian_derivatives.rigid_body.py_func).cache_path)
            / EXPRESSIONS_FOLDER
        )
        place = folder / hashlib.sha256(text.encode()).hexdigest()[:16]
        path = place / "expression.source"
        if not path.exists() or path.read_text("utf-8") != text:
            place.mkdir(parents=True, exist_ok=True)
            write_whole(path, text)
            _tidy(folder)
        os.utime(path)
        return path
    return None


def _tidy(folder: Path) -> None:
    """Delete all but the KEPT_EXPRESSIONS most recently used expressions."""
    by_use = sorted(folder.glob("*/expression.source"), key=lambda path: path.stat().st_mtime)
    for path in by_use[:-KEPT_EXPRESSIONS]:
        shutil.rmtree(path.parent, ignore_errors=True)

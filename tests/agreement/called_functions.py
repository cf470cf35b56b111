"""The same problem, of functions that are called, since they cannot be traced."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import galvi
from tests.properties.lagrangians import opaque

FIELDS = ("function", "slopes", "potential", "gradient", "force")


def is_of_user(value: Any) -> bool:
    """Whether it is a function of Python or of Numba, and no value of galvi's."""
    return type(value).__name__ == "function" or hasattr(value, "py_func")


def called(problem: galvi.Problem) -> galvi.Problem:
    """A problem whose user's functions are wrapped so that tracing refuses them."""
    system: Any = problem.system
    functions = {name: getattr(system, name, None) for name in FIELDS}
    wrapped = {name: opaque(value) for name, value in functions.items() if is_of_user(value)}
    return replace(problem, system=replace(system, check=False, **wrapped))

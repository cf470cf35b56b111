"""Bounds of rounding errors: an operation's error from those of its arguments, from both sides."""

import numpy as np
import pytest

from galvi.tracing.trace_check import _operation

ERRORS = np.array([3e-7, 1e-7])
X = np.array([0.7, -0.4])
FUNCTIONS = {
    "+": lambda x, y: x + y,
    "-": lambda x, y: x - y,
    "*": lambda x, y: x * y,
    "atan2": np.arctan2,
    "power": np.power,
    "inverse": lambda x: 1.0 / x,
    **{name: getattr(np, name) for name in ("tan", "exp", "log", "sqrt", "sinh", "cosh")},
}
SLOPES_UP_TO_1 = {"sin": np.sin, "cos": np.cos, "tanh": np.tanh}  # bounded by a slope of 1


def largest_change(function, x):
    """The largest change of the value where each argument is off by its error."""
    signs = np.array(np.meshgrid(*[[-1.0, 1.0]] * len(x))).reshape(len(x), -1)
    shifted = function(*(x[:, None] + signs * ERRORS[: len(x), None]))
    return np.max(np.abs(shifted - function(*x)))


@pytest.mark.parametrize("name", [*FUNCTIONS, *SLOPES_UP_TO_1])
def test_an_operation_passes_on_the_errors_of_its_arguments(name):
    function = {**FUNCTIONS, **SLOPES_UP_TO_1}[name]
    x = X if name in ("+", "-", "*", "atan2", "power") else X[:1]
    value, error = _operation(name, x, ERRORS)
    change = largest_change(function, x)
    assert value == function(*x) and error >= change * (1.0 - 1e-5)
    assert error <= (1.0 + 1e-5) * (ERRORS[0] if name in SLOPES_UP_TO_1 else change)

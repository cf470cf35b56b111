"""Functions that kernels call: linked into them, and compiled anew for calls from Python."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numba.core.errors import TypingError

from galvi.kernels.compile.jit import jit, jit_inline


def pair() -> tuple[Any, Any]:
    """A function, and one that calls it with whole and real numbers."""

    @jit_inline
    def twice(x):
        return x + x

    @jit
    def total(values):
        found = 0.0
        for x in values:
            found += twice(x)
        return found + twice(1)

    return twice, total


def test_what_was_a_part_can_be_called_from_python_and_by_others() -> None:
    twice, total = pair()
    total(np.arange(4.0))
    assert (twice(2.0), twice(3)) == (4.0, 6)
    assert total(np.arange(3)) == 8.0

    @jit
    def other(x):
        return twice(x) + total(np.full(2, x))

    assert other(1.0) == 2.0 + 6.0


def test_an_error_in_a_part_is_named_with_what_called_it() -> None:
    @jit
    def wrong(x):
        return x.nothing

    @jit
    def outer(x):
        return wrong(x)

    with pytest.raises(TypingError, match="Unknown attribute 'nothing'"):
        outer(1.0)

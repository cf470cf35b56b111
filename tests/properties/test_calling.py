"""Functions that a kernel calls by their address."""

import numpy as np
import pytest
from numba import njit, types
from numba.core.errors import TypingError
from numba.core.runtime import _nrt_python, rtsys

from galvi.kernels.compile.function_pointers import addresses, call_matrix, call_vector, call_void
from galvi.kernels.compile.jit import MATRIX, REAL, VECTOR

RETURNS_NOTHING = types.void(VECTOR, REAL)


@njit
def double(x, factor):
    """x <- 2 factor x."""
    x *= 2.0 * factor


@njit
def rotated(x, y):
    """The vector turned by a right angle, with y added to its second entry."""
    return np.array([-x[1], x[0] + y])


@njit
def outer_product(x):
    """The outer product of x with itself; ValueError if x is empty."""
    if x.size == 0:
        raise ValueError("nothing to multiply")
    product = np.empty((x.size, x.size))
    for i in range(x.size):
        for j in range(x.size):
            product[i, j] = x[i] * x[j]
    return product


@njit
def copy_of(x):
    """A copy of x."""
    return x.copy()


@njit
def call_all_three(functions, x, y):
    """Calls the three functions once each, by their addresses."""
    call_void(functions[0], x, y)
    return call_vector(functions[1], x, y), call_matrix(functions[2], x)


def three_addresses():
    """The addresses of `double`, `rotated` and `outer_product`."""
    return addresses(
        (double, RETURNS_NOTHING), (rotated, VECTOR(VECTOR, REAL)), (outer_product, MATRIX(VECTOR))
    )


def test_functions_are_called_by_their_addresses_with_what_they_return():
    x = np.array([1.0, 3.0])
    pair, square = call_all_three(three_addresses(), x, 2.0)
    assert x.tolist() == [4.0, 12.0]
    assert pair.tolist() == [-12.0, 6.0]
    assert square.tolist() == [[16.0, 48.0], [48.0, 144.0]]


def test_what_is_returned_is_freed():
    @njit
    def first_entries_summed(functions, x, times):
        total = 0.0
        for _ in range(times):
            total += call_vector(functions[0], x)[0]
        return total

    _nrt_python.memsys_enable_stats()
    functions = addresses((copy_of, VECTOR(VECTOR)))
    assert first_entries_summed(functions, np.ones(10), 1) == 1.0
    before = rtsys.get_allocation_stats()
    assert first_entries_summed(functions, np.ones(10), 1000) == 1000.0
    after = rtsys.get_allocation_stats()
    assert after.alloc - before.alloc == after.free - before.free >= 1000


def test_what_a_function_raises_reaches_the_caller():
    @njit
    def square(functions, x):
        return call_matrix(functions[2], x)

    with pytest.raises(ValueError, match="nothing to multiply"):
        square(three_addresses(), np.zeros(0))


def test_what_is_not_jitted_or_returns_something_else_is_refused():
    def plain(x):
        return x

    with pytest.raises(TypeError, match="received <function"):
        addresses((plain, VECTOR(VECTOR)))
    with pytest.raises(TypeError, match="rotated must return array"):
        addresses((rotated, MATRIX(VECTOR, REAL)))


@pytest.mark.parametrize(
    ("call", "signature", "message"),
    [
        (lambda address: call_void(address, 1j), "(int64,)", "cannot take complex128"),
        (lambda address, x: call_vector(address, x[::2], 1.0), (types.int64, VECTOR), "take array"),
    ],
)
def test_what_an_address_cannot_take_is_refused_when_compiled(call, signature, message):
    with pytest.raises(TypingError, match=message):
        njit(call).compile(signature)

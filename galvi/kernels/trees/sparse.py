"""Arithmetic of numbers and triples without operations on the numbers 0, 1 and -1.

For lanes, numbers, complex numbers and arrays; kernels compile the usual operations.
"""

from galvi.kernels.lie.arithmetic import generic, in_kernels


@generic
def _times(x, y):
    return x * y


@generic
def _plus(x, y):
    return x + y


@generic
def _minus(x, y):
    return x - y


@in_kernels(_times)
def times(x, y):
    """x y, without a product if a factor is the number 0, 1 or -1."""
    for factor, cofactor in ((x, y), (y, x)):
        if isinstance(factor, float) and factor in (0.0, 1.0, -1.0):
            if factor == 0.0:
                return 0.0
            return cofactor if factor == 1.0 else minus(0.0, cofactor)
    return x * y


@in_kernels(_plus)
def plus(x, y):
    """x + y, without a sum if x or y is the number 0."""
    if isinstance(x, float) and x == 0.0:
        return y
    return x if isinstance(y, float) and y == 0.0 else x + y


@in_kernels(_minus)
def minus(x, y):
    """x - y, without a difference if x or y is the number 0."""
    if isinstance(y, float) and y == 0.0:
        return x
    return -y if isinstance(x, float) and x == 0.0 else x - y


@generic
def triple(a, k):
    """Three entries from the k-th on."""
    return a[k], a[k + 1], a[k + 2]


@generic
def keep(values, out, k):
    """out[k : k + 3] <- three numbers."""
    out[k], out[k + 1], out[k + 2] = values[0], values[1], values[2]


@generic
def dot(a, b):
    """a . b."""
    return plus(plus(times(a[0], b[0]), times(a[1], b[1])), times(a[2], b[2]))


@generic
def cross(a, b):
    """a x b."""
    return (
        minus(times(a[1], b[2]), times(a[2], b[1])),
        minus(times(a[2], b[0]), times(a[0], b[2])),
        minus(times(a[0], b[1]), times(a[1], b[0])),
    )


@generic
def sum_of(a, b):
    """a + b."""
    return plus(a[0], b[0]), plus(a[1], b[1]), plus(a[2], b[2])


@generic
def difference_of(a, b):
    """a - b."""
    return minus(a[0], b[0]), minus(a[1], b[1]), minus(a[2], b[2])


@generic
def scaled(x, a):
    """x a."""
    return times(x, a[0]), times(x, a[1]), times(x, a[2])


@generic
def rotated(a, k, b):
    """The product of the matrix (3, 3), by rows from index k of a on, and b."""
    return dot(triple(a, k), b), dot(triple(a, k + 3), b), dot(triple(a, k + 6), b)


@generic
def rotated_back(a, k, b):
    """The product of the transposed matrix (3, 3), by rows from index k of a on, and b."""
    first, second = scaled(b[0], triple(a, k)), scaled(b[1], triple(a, k + 3))
    return sum_of(sum_of(first, second), scaled(b[2], triple(a, k + 6)))


@generic
def symmetric(a, k, b):
    """The product of the symmetric matrix with xx, xy, xz, yy, yz, zz from index k of a on, and
    b."""
    return (
        dot((a[k], a[k + 1], a[k + 2]), b),
        dot((a[k + 1], a[k + 3], a[k + 4]), b),
        dot((a[k + 2], a[k + 4], a[k + 5]), b),
    )


@generic
def _is_there(x):
    return x != 0.0


@in_kernels(_is_there)
def may_be_nonzero(x):
    """Whether x may be nonzero: False only for the number 0."""
    return not isinstance(x, float) or x != 0.0

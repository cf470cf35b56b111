"""Symmetric matrices in lanes: factors L D L^T without pivots, and solutions by them.

Rows up to the diagonal are Python lists of lanes and numbers, so that entries that are 0 for every
state cost nothing. Where code without loops would take long to compile, the entries are rows of an
array, and loops go over these.
"""

from __future__ import annotations

import math
from typing import Any

from galvi.kernels.compile.internals import cgutils
from galvi.lanes.values import Lane

# Largest number of products of a factorisation without loops. The law of 12 ball joints in a chain
# (36 velocities, 7,140 products) compiles in 6 s with loops and in 11 s without, for steps of
# 0.21 and 0.19 ms.
WRITTEN_OUT_PRODUCTS = 4500
COLUMNS_TOGETHER = 4  # columns that are eliminated together


def is_zero(x):
    """Whether x is 0 for every state."""
    return not isinstance(x, Lane) and x == 0.0


def product(x, y):
    """x y, or the number 0 if a factor is the number 0."""
    return 0.0 if is_zero(x) or is_zero(y) else x * y


def difference(x, y):
    """x - y, or x itself if y is the number 0."""
    return x if is_zero(y) else x - y


def ldl_factors(mass):
    """The rows of L, with 1 / D on the diagonal, from the rows of a matrix up to its diagonal.

    A pivot that is always 0 gives NaN, so that every step is left to the general kernel.
    """
    rows: list[list[Any]] = []
    for i, lower_row in enumerate(mass):
        scaled: list[Any] = []  # row i of L D
        for j in range(i):
            value = lower_row[j]
            for k in range(j):
                value = difference(value, product(scaled[k], rows[j][k]))
            scaled.append(value)
        row, pivot = [product(scaled[j], rows[j][j]) for j in range(i)], lower_row[i]
        for j in range(i):
            pivot = difference(pivot, product(scaled[j], row[j]))
        rows.append([*row, math.nan if is_zero(pivot) else 1.0 / pivot])
    return rows


def times_symmetric(rows, v):
    """M v for a symmetric M, given by its rows up to the diagonal."""
    return [sum(rows[max(i, j)][min(i, j)] * v[j] for j in range(len(v))) for i in range(len(v))]


def inverse_from_factors(rows):
    """The rows up to the diagonal of the inverse, from the factors L and 1 / D of a matrix."""
    d = len(rows)
    inverse = [[0.0] * (i + 1) for i in range(d)]
    for column in range(d):
        x = [0.0] * column + [1.0] + [0.0] * (d - column - 1)
        for i in range(column + 1, d):
            for j in range(column, i):
                x[i] = difference(x[i], product(rows[i][j], x[j]))
        x = [product(x[i], rows[i][i]) for i in range(d)]
        for i in range(d - 1, -1, -1):
            for j in range(i):
                x[j] = difference(x[j], product(rows[i][j], x[i]))
        for i in range(column, d):
            inverse[i][column] = x[i]
    return inverse


def is_written_out(below):
    """Whether a factorisation is short enough for code without loops.

    Parameters
    ----------
    below
        indices (i, j), j < i, of the entries of L that are not 0
    """
    rows: dict[int, list[int]] = {}
    for i, j in below:
        rows.setdefault(i, []).append(j)
    products = sum(len(set(row) & set(rows.get(j, ()))) for row in rows.values() for j in row)
    return products <= WRITTEN_OUT_PRODUCTS


class Triangle:
    """A lower triangle of lanes, whose entries are successive rows of an array.

    Parameters
    ----------
    first
        row of the array that holds the first entry
    d
        number of rows of the triangle
    """

    def __init__(self, builder, lanes, array, first, d):
        self.builder, self.lanes, self.data, self.d = builder, lanes, array, d
        self.row = lanes.padded.type
        self.first = self.row(first)

    def start(self, i):
        """The row of the array that holds the first entry of row i."""
        builder = self.builder
        square = builder.mul(i, builder.add(i, self.row(1)))
        return builder.add(self.first, builder.lshr(square, self.row(1)))

    def at(self, row):
        return Lane(self.builder, self.lanes.load(self.data, row))

    def keep(self, lane, row):
        self.lanes.store(lane.value, self.data, row)

    def factor(self):
        """Replace a matrix by its factors, by the operations of `ldl_factors` in the same order."""
        builder = self.builder
        with cgutils.for_range(builder, self.row(self.d), intp=self.row) as rows:
            i = rows.index
            row_start, together = self.start(i), self.row(COLUMNS_TOGETHER)
            grouped = builder.mul(builder.udiv(i, together), together)
            with cgutils.for_range_slice(builder, self.row(0), grouped, together, self.row) as loop:
                self.eliminate(row_start, i, loop[0], COLUMNS_TOGETHER)
            with cgutils.for_range(builder, i, start=grouped, intp=self.row) as loop:
                self.eliminate(row_start, i, loop.index, 1)
            last = builder.add(row_start, i)
            with cgutils.for_range(builder, i, intp=self.row) as loop:
                entry, pivot = builder.add(row_start, loop.index), self.start(loop.index)
                scaled = self.at(entry)
                factor = scaled * self.at(builder.add(pivot, loop.index))
                self.keep(self.at(last) - scaled * factor, last)
                self.keep(factor, entry)
            self.keep(1.0 / self.at(last), last)

    def eliminate(self, row_start, i, k, count):
        """Subtract from row i of the matrix the products with ``count`` columns of L D, from the
        k-th on: from these columns and from all later ones."""
        builder, scaled = self.builder, list[Lane]()

        def reduce(j, count):
            target, pivot_row = builder.add(row_start, j), builder.add(self.start(j), k)
            reduced = self.at(target)
            for m in range(count):
                reduced = reduced - scaled[m] * self.at(builder.add(pivot_row, self.row(m)))
            self.keep(reduced, target)
            return reduced

        for m in range(count):
            scaled.append(reduce(builder.add(k, self.row(m)), m))
        after = builder.add(k, self.row(count))
        with cgutils.for_range(builder, i, start=after, intp=self.row) as loop:
            reduce(loop.index, count)

    def solve(self, x):
        """M^-1 x from the factors of M, as d lanes; x holds d lanes or numbers."""
        builder, d = self.builder, self.d
        solution = cgutils.alloca_once(builder, self.lanes.kind, self.row(d))

        def address(i):
            return builder.gep(solution, [i])

        def entry(i):
            return Lane(builder, builder.load(address(i)))

        def subtract(i, amount):
            builder.store((entry(i) - amount).value, address(i))

        zero = Lane(builder, self.lanes.zero)
        for i, value in enumerate(x):
            builder.store(zero.same(value).value, address(self.row(i)))
        with cgutils.for_range(builder, self.row(d), intp=self.row) as columns:
            j = columns.index
            component, after = entry(j), builder.add(j, self.row(1))
            with cgutils.for_range(builder, self.row(d), start=after, intp=self.row) as loop:
                factor = self.at(builder.add(self.start(loop.index), j))
                subtract(loop.index, factor * component)
        with cgutils.for_range(builder, self.row(d), intp=self.row) as loop:
            i = loop.index
            pivot = self.at(builder.add(self.start(i), i))
            builder.store((entry(i) * pivot).value, address(i))
        with cgutils.for_range(builder, self.row(d), intp=self.row) as rows:
            i = builder.sub(self.row(d - 1), rows.index)
            component, row_start = entry(i), self.start(i)
            with cgutils.for_range(builder, i, intp=self.row) as loop:
                subtract(loop.index, self.at(builder.add(row_start, loop.index)) * component)
        return [entry(self.row(i)) for i in range(d)]

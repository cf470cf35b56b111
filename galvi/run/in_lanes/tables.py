"""The tables of a method in the layout that laws in lanes read, see galvi.lanes.layouts."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.extended_precision import decimals, extended_precision, rounded, scaled
from galvi.kernels.lie.arithmetic import two_sum
from galvi.lanes.vectors import LANES
from galvi.tableau import Tableau


class LawTables(NamedTuple):
    """Tables, complement and growth of galvi.lanes.layouts; ``extra``, the number of rows of the
    complement or of functions Y; and the nodes (P,)."""

    tables: Array
    complement: Array
    growth: Array
    extra: int
    nodes: Array


class Form(NamedTuple):
    """The step size and vectors for which tables are made.

    Attributes
    ----------
    step
        h by which the tables are multiplied; 1 for members of an ensemble
    lanes
        lanes of a vector of one run's stages; 0 where a vector holds eight runs
    """

    step: float
    lanes: int


MEMBERS = Form(1.0, 0)


@lru_cache(maxsize=64)
def tables_on_space(
    table: Tableau, degrees: tuple[int, ...] | None, form: Form = MEMBERS
) -> LawTables:
    """The tables of a law on R^d.

    Parameters
    ----------
    degrees
        (d,) number of coefficients of each component; None where all have that of the table
    """
    s, m = table.slope.shape
    A, B = (matrix.swapaxes(1, 2) for matrix in integrals_of(table))
    coefficients, complement = degrees or (m,), np.zeros((0, s))
    if s > min(coefficients):
        projections = [complement_projection(table, k).T for k in coefficients]
        complement = np.concatenate([pad_square(matrix, form) for matrix in projections])
    means = np.zeros(row_length(s, form))
    return _tables(table, A, B, means, complement, len(complement), form)


@lru_cache(maxsize=64)
def nystrom_tables(table: Tableau, form: Form = MEMBERS) -> LawTables:
    """The tables of a Nystrom method, for laws whose positions alone are iterated."""
    s = table.c.size
    P = row_length(s, form)
    A, beta = np.stack([table.A.T, table.low_parts[3].T]), np.zeros((2, s, P))
    beta[:, 0, :s] = table.beta, table.low_parts[2]
    low_nodes = pad_rows(table.low_parts[0][None], P)[0]
    return _tables(table, A, beta, low_nodes, np.zeros((0, s)), 0, form, 2)


@lru_cache(maxsize=64)
def tables_on_group(table: Tableau, form: Form = MEMBERS) -> LawTables:
    """The tables of a law on a group: the first lane beyond the stages has the step's end."""
    s, m = table.slope.shape
    P = row_length(s, form)
    A, B = np.zeros((2, 2, s, P))
    A[:, :, :s], B[:, :, :s] = (matrix.swapaxes(1, 2) for matrix in integrals_of(table))
    for k, b in enumerate((table.b, table.low_parts[1])):
        A[k, :, s:] = b[:, None]
    B[0, :, :s], rounding = two_sum(B[0, :, :s], -table.b[:, None])
    B[1, :, :s] += rounding - table.low_parts[1][:, None]
    Y, means = orthonormal_complement(table), np.zeros(P)
    if s > m:
        means[:s] = np.mean(Y * Y, axis=0) * table.b
    weights = np.pad(Y * table.b, ((0, 0), (0, P - s)))
    complement = np.concatenate([pad_rows(Y, P), weights])
    return _tables(table, A, B, means, complement, s - m, form)


def _tables(
    table: Tableau,
    A: Array,
    B: Array,
    means: Array,
    complement: Array,
    extra: int,
    form: Form,
    power: int = 1,
) -> LawTables:
    """The parts in the order of galvi.lanes.layouts.Tables; A and B times h^power."""
    s, h = table.c.size, form.step
    P, kicks = row_length(s, form), np.stack([table.b, table.low_parts[1]])
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        A, B, kicks = scaled(A, h, power), scaled(B, h, power), scaled(kicks, h)
        extended = extrapolate_matrix(table, A[0] if power == 2 else np.eye(s))
    rows = np.concatenate([np.pad(kicks, ((0, 0), (0, P - s))), means[None]])
    nodes = pad_rows(table.c[None], P)
    blocks = [pad_square(matrix, form) for matrix in (*A, *B)]
    extrapolations = [table.extrapolation.T]
    if form.lanes:
        ends = np.zeros((s, P))
        ends[:, :4] = np.stack([kicks[0], B[0, 0, :s], kicks[1], B[1, 0, :s]], axis=1)
        extrapolations = [pad_square(matrix, form) for matrix in (ends, *extended)]
    tables, complement = aligned_copies(
        np.concatenate([*blocks, rows, nodes, pad_square(table.analysis.T, form), *extrapolations]),
        pad_rows(complement, P),
    )
    return LawTables(tables, complement, read_only(table.growth), extra, read_only(nodes[0].copy()))


def row_length(s: int, form: Form) -> int:
    """P, the length of a row for s stages; s where a vector holds eight runs."""
    return -(-s // form.lanes) * form.lanes if form.lanes else s


def pad_rows(rows: Array, P: int) -> Array:
    """Rows of length P, whose last numbers are repeated."""
    return np.pad(rows, ((0, 0), (0, P - rows.shape[1])), mode="edge")


def pad_square(matrix: Array, form: Form) -> Array:
    """A matrix (s, s or P) with rows of length P and as many of them, the last ones 0."""
    P = row_length(len(matrix), form)
    return np.pad(pad_rows(matrix, P), ((0, P - len(matrix)), (0, 0)))


def complement_projection(table: Tableau, coefficients: int) -> Array:
    """C (s, s) of galvi.lanes.collocation for the space's first functions."""
    root = np.sqrt(table.b)
    slopes = np.linalg.qr(root[:, None] * table.slope[:, :coefficients])[0]
    return np.eye(root.size) - slopes @ slopes.T * root / root[:, None]


def orthonormal_complement(table: Tableau) -> Array:
    """The functions Y (s - m, s) of galvi.lanes.group_collocation at the stages."""
    root = np.sqrt(table.b)
    basis = np.linalg.qr(root[:, None] * table.slope, mode="complete")[0]
    return basis[:, table.slope.shape[1] :].T / root


@lru_cache(maxsize=32)
def integrals_of(table: Tableau) -> tuple[Array, Array]:
    """The integrals of slopes, A, and of their dual, B, each with its low part: (2, s, s)."""
    with extended_precision():
        b = decimals(table.b) + decimals(table.low_parts[1])
        A = decimals(table.integral) + decimals(table.low_parts[4])
        return with_low_part(A), with_low_part(b - (A.T * b) / b[:, None])


def stages_in_lanes(s: int, lanes: int = LANES) -> Any:
    """The index (P,) of the stage in each lane; the last stage is repeated."""
    return np.minimum(np.arange(-(-s // lanes) * lanes), s - 1)


def with_low_part(exact: Any) -> Array:
    """The nearest float64 numbers and their rounding errors, (2, ...)."""
    nearest = rounded(exact)
    return np.stack([nearest, rounded(exact - decimals(nearest))])


def aligned(*shapes: tuple[int, ...]) -> list[Array]:
    """Arrays of zeros in one buffer; the first starts at a cache line, and so does each one that
    follows whole lines."""
    buffer = np.zeros(sum(map(math.prod, shapes)) + LANES)
    offset, arrays = (-buffer.ctypes.data // 8) % LANES, []
    for shape in shapes:
        end = offset + math.prod(shape)
        arrays.append(buffer[offset:end].reshape(shape))
        offset = end
    return arrays


def aligned_copies(*arrays: Array) -> list[Array]:
    """Copies of arrays, aligned as by `aligned`."""
    copies = aligned(*(array.shape for array in arrays))
    for copy, array in zip(copies, arrays, strict=True):
        copy[:] = array
    return copies


def extrapolate_matrix(table: Tableau, matrix: Array) -> Array:
    """A matrix (s, P) after the extrapolation to the next step's stages by 1, ..., l Legendre
    polynomials: (l, s, P)."""
    terms = table.extrapolation.T @ matrix
    return np.cumsum(table.analysis[: len(terms), :, None] * terms[:, None, :], axis=0)

"""The kernel of a law and a method for lanes of members, and its tables."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from galvi.arrays import Array, read_only
from galvi.ensembles.laws import Law, iterates_places
from galvi.fast.lanes.group_rows import rows_of_group_work
from galvi.fast.lanes.law_pass import rows_of_work
from galvi.fast.lanes.members.group import group_fields
from galvi.fast.lanes.members.law import law_fields
from galvi.fast.lanes.members.steps import Fields
from galvi.fast.lanes.vectors import LANES
from galvi.fast.law_stepper import component_degrees, orthonormal_complement, outside
from galvi.fast.nystrom_stepper import aligned, aligned_copies, integrals_of
from galvi.fast.symbolic.lane_law import compiled_group_members, compiled_members
from galvi.kernels.lie import product
from galvi.kernels.lie.arithmetic import two_sum
from galvi.method import Galerkin
from galvi.tableau import Tableau

# Laws of few coordinates and stages are compiled for each number of stages: a quarter less time.
NARROW, FEW = 6, 12


@dataclass(frozen=True, eq=False)
class MemberKernel:
    """What runs members of a law with a method.

    function  compiled, of the address of the words in galvi.fast.lanes.members.steps
    fields    of a record
    rows      of work
    tables    tables, complement and growth, as there
    extra     rows of the complement, on a group half of them
    alone     whether places alone are iterated
    memory    (q (n, r), p (n, d)) -> more fields of the records at the start
    """

    function: Callable[[int], None]
    fields: Fields
    rows: int
    tables: tuple[Array, Array, Array]
    extra: int
    alone: bool
    memory: Callable[[Array, Array], dict[str, Array]]

    def work(self, stages: int) -> Array:
        """Scratch for one thread."""
        (found,) = aligned((self.rows, stages, LANES))
        return found


def kernel_of(law: Law, method: Galerkin) -> MemberKernel:
    """The kernel of a law with a method."""
    d, table = law.dimension, method.table
    if not law.layout:
        alone = iterates_places(law, method)
        tables = (
            nystrom_tables(table) if alone else tables_on_space(table, component_degrees(method))
        )
        extra = tables[1].shape[0]
        stages = method.stages if d <= NARROW and method.stages <= FEW else 0
        return MemberKernel(
            compiled_members(law.lines, d, stages, alone), law_fields(d), rows_of_work(d), tables,
            extra, alone, lambda q, p: {},
        )  # fmt: skip
    tables = tables_on_group(table)
    extra = tables[1].shape[0] // 2
    layout = np.array(law.layout)

    def memory(q: Array, p: Array) -> dict[str, Array]:
        remembered, nu, still = np.zeros(q.shape), np.empty(p.shape), np.zeros(d)
        for k, g in enumerate(q):
            product.in_space(layout, g.copy(), p[k].copy(), nu[k])
            product.advance(layout, chart, still, g.copy(), remembered[k], np.zeros(g.size))
        return {"memory": remembered, "nu": nu}

    chart = method.group_chart.number
    function = compiled_group_members(law.lines, law.layout, chart)
    rows = rows_of_group_work(d, extra)
    return MemberKernel(function, group_fields(d, law.entries), rows, tables, extra, False, memory)


@lru_cache(maxsize=32)
def tables_on_space(table: Tableau, degrees: tuple[int, ...] | None) -> tuple[Array, Array, Array]:
    """Tables, complement and growth of a law on R^d with these degrees of its components."""
    s, m = table.slope.shape
    A, B = (matrix.swapaxes(1, 2) for matrix in integrals_of(table))
    coefficients = degrees or (m,)
    complement = np.zeros((0, s))
    if s > min(coefficients):
        complement = np.concatenate([outside(table, k).T for k in coefficients])
    return _in_lines(table, A, B, np.zeros(s), complement)


@lru_cache(maxsize=32)
def nystrom_tables(table: Tableau) -> tuple[Array, Array, Array]:
    """As ``tables_on_space``, for places alone."""
    A, beta = np.stack([table.A.T, table.low_parts[3].T]), np.zeros((2, *table.A.shape))
    beta[:, 0] = table.beta, table.low_parts[2]
    return _in_lines(table, A, beta, table.low_parts[0], np.zeros((0, table.c.size)))


@lru_cache(maxsize=32)
def tables_on_group(table: Tableau) -> tuple[Array, Array, Array]:
    """As ``tables_on_space``, on a group."""
    s, m = table.slope.shape
    A, B = (matrix.swapaxes(1, 2) for matrix in integrals_of(table))
    back, rest = two_sum(B[0], -table.b[:, None])
    low = rest + (B[1] - table.low_parts[1][:, None])
    Y = orthonormal_complement(table)
    means = np.mean(Y * Y, axis=0) * table.b if s > m else np.zeros(s)
    return _in_lines(table, A, np.stack([back, low]), means, np.concatenate([Y, Y * table.b]))


def _in_lines(
    table: Tableau, A: Array, B: Array, means: Array, complement: Array
) -> tuple[Array, Array, Array]:
    """The parts in the order of galvi.fast.lanes.members.steps.Tables."""
    rows = (table.b, table.low_parts[1], means, table.c)
    given = np.concatenate([*A, *B, rows, table.analysis.T, table.extrapolation.T])
    tables, complement = aligned_copies(given, complement)
    return tables, complement, read_only(table.growth)

"""The kernel of a run whose law is known as expressions, by galvi.lanes.loops."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.lie.product import DIMENSION, ENTRIES, ROTATIONS
from galvi.kernels.nystrom.solve import FORCES
from galvi.lanes import group_collocation
from galvi.lanes.collocation import SERIES, V, law_fields, rows_of_work
from galvi.lanes.group_collocation import ETA, VELOCITY, group_fields, rows_of_group_work
from galvi.lanes.layouts import Fields
from galvi.lanes.loops import STEP_OF_LAW, Curves, OneRun, compiled_advance_run
from galvi.run.in_lanes.tables import LawTables, aligned
from galvi.run.request import RunRequest
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, run_plan
from galvi.tracing.lane_law import compiled_law

NO_FACTORS = np.zeros((0, 5), dtype=np.int64)  # of R^d


@dataclass(frozen=True, eq=False)
class LawInLanes:
    """A compiled step of a law in lanes, and the layout of its arrays.

    Attributes
    ----------
    function
        address of the arguments of galvi.lanes.layouts -> None, compiled
    fields
        fields of the record
    rows
        (d, l) -> number of rows of the work array
    seats : array, shape (n, 4)
        see galvi.lanes.loops.OneRun
    rates
        first row, in the work array, of the rates of curves
    velocities
        first row of the velocities, or accelerations, at the stages
    last
        first row of these of the last step
    layout : array, shape (factors, 5)
        layout of a group, see galvi.kernels.lie.product
    """

    function: Callable[[int], None]
    fields: Fields
    rows: Callable[[int, int], int]
    seats: Any
    rates: int
    velocities: int
    last: int
    layout: Any

    @cached_property
    def address(self) -> int:
        """The address of the compiled function."""
        return int(addresses((self.function, STEP_OF_LAW))[0])


def seats_of(fields: Fields, places: Sequence[tuple[str, int, int]]) -> Any:
    """The seats (n, 4) of fields from triples of the name, and the row and column in the state of
    the field's first entry."""
    return np.array(
        [(row, column, fields.first[name], fields.size[name]) for name, row, column in places]
    )


@lru_cache(maxsize=64)
def law_on_space(
    lines: str, d: int, positions_only: bool, lanes: int, one_vector: bool
) -> LawInLanes:
    """The step on R^d of the lines that define a law; arguments of
    galvi.lanes.collocation.generated_step."""
    fields, function = (
        law_fields(d),
        compiled_law("collocation", lines, d, positions_only, lanes, one_vector),
    )
    order = ("q", "q_low", "p", "p_low") if positions_only else ("q", "p", "q_low", "p_low")
    seats = seats_of(fields, [(name, row, 0) for row, name in enumerate(order)])
    return LawInLanes(
        function,
        fields,
        lambda d, extra: rows_of_work(d),
        seats,
        V * d,
        V * d,
        SERIES * d,
        NO_FACTORS,
    )


@lru_cache(maxsize=64)
def law_on_group(
    lines: str, layout: tuple[tuple[int, ...], ...], chart: int, lanes: int, one_vector: bool
) -> LawInLanes:
    """The step on groups in a chart of the lines that define a law; arguments of
    galvi.lanes.group_collocation.generated_step."""
    d = sum(row[DIMENSION] for row in layout)
    fields = group_fields(d, sum(row[ENTRIES] for row in layout))
    function = compiled_law("group_collocation", lines, layout, chart, lanes, one_vector)
    places = [("q", 0, 0), ("p", 1, 0), ("memory", 2, 0), ("nu_low", 3, 0)]
    if any(row[ROTATIONS] for row in layout):  # without rotations the state has no such entries
        places += [("nu", 1, 2 * d), ("low", 3, d)]
    return LawInLanes(
        function,
        fields,
        rows_of_group_work,
        seats_of(fields, places),
        ETA * d,
        VELOCITY * d,
        group_collocation.SERIES * d,
        np.array(layout),
    )


def words_of(
    record: Array, constants: Array, work: Array, tables: LawTables, reals: Array, s: int
) -> Any:
    """The arguments of galvi.lanes.layouts, valid as long as the arrays exist."""
    arrays = record, constants, work, tables.tables, tables.complement, reals
    addresses = [array.ctypes.data for array in arrays]
    return np.array([*addresses, s, tables.growth.size, tables.extra, 0, 0, 0])


class LawKernel:
    """Steps of a law in lanes; it owns the arrays that its addresses point to.

    Parameters
    ----------
    curves
        (fit, line) of galvi.lanes.loops.Curves
    """

    def __init__(
        self,
        law: LawInLanes,
        constants: Array,
        tables: LawTables,
        curves: tuple[Array, Array],
        tolerance: float,
        request: RunRequest,
        work: RunArrays,
    ) -> None:
        record, reals = np.zeros(law.fields.velocities), np.append(tables.growth, tolerance)
        first, places = law.fields.first, (2, work.state.shape[1])
        scratch, before = aligned(
            (law.rows(len(work.stages), tables.extra), tables.nodes.size), places
        )
        law_arguments = words_of(record, constants, scratch, tables, reals, request.method.stages)
        run = OneRun(
            law_arguments,
            record,
            law.seats,
            scratch,
            before,
            law.layout,
            first["q"],
            first["p"],
            first["step"],
            law.rates,
            law.velocities,
            law.last,
        )
        plan, self._progress, self._saved = run_plan(request, work, tolerance)
        self._kernel, self._work = compiled_advance_run(), work
        self._owned = law, constants, tables, reals
        self._arguments = (
            law.address,
            law_arguments.ctypes.data,
            tuple(run),
            tuple(Curves(*curves, tables.nodes)),
            plan,
        )

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        before = self._work.counts[FORCES]
        code = int(self._kernel(*self._arguments, n, self._progress, self._saved))
        self._work.counts[FORCES_IN_LANES] += self._work.counts[FORCES] - before
        return code

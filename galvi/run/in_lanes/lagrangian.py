"""Steps of a Lagrangian on R^d or on a Lie group in vector instructions."""

from __future__ import annotations

from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.groups.group import Rn
from galvi.kernels.compile.function_pointers import addresses
from galvi.kernels.lie.arithmetic import two_sum
from galvi.kernels.nystrom.advance import STREAK
from galvi.kernels.nystrom.solve import FORCES, NEWTON_STREAK
from galvi.lanes.group_law import HISTORY, compiled_advance_group_law
from galvi.lanes.group_rows import PLACE, rows_of_group_work
from galvi.lanes.law import PASS_TYPE, compiled_advance_law
from galvi.lanes.law_pass import rows_of_work
from galvi.lanes.vectors import lanes_for
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import coupled_layout
from galvi.run.in_lanes.nystrom import (
    aligned,
    aligned_copies,
    collocation_tables,
    in_blocks,
    stages_in_lanes,
    words_of,
)
from galvi.run.on_group import CountedByNewton
from galvi.run.request import RunRequest
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, run_plan
from galvi.run.stepper import Kernel, MakeKernel
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn
from galvi.systems.nbody import NBody
from galvi.systems.nbody_on_rn import NBodyOnRn
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau
from galvi.tracing.lane_law import GROUP_PASS, PASS, compiled_law, coupled
from galvi.tracing.laws_of_systems import LawCode, law_of

# In lanes less is left: a free body (degree 6, 6 points, h = 0.2) loses 3.6e-18 of its energy a
# step with 2^-55, and 1.2e-18 with 2^-58.
FINEST_IN_LANES = 2.0**-58
# On R^d less is left for the energy to drift by: an elastic pendulum (degree 8, 9 points, h = 0.03)
# loses 5e-19 of it a step with 2^-55, and at most 2e-20 with 2^-60.
FINEST_ON_RN = 2.0**-60


def lane_law(system: Any, d: int) -> LawCode | None:
    """The law for lanes of a system of d coordinates on R^d, or None."""
    found = traces(system)
    if isinstance(system, NBody) and system.acting.of_velocity:
        system = NBodyOnRn(system, d // system.masses.size)
    group = getattr(system, "group", None)
    on_space = isinstance(group, Rn) or isinstance(system, Canonical)
    return _lane_law(system, d, found) if on_space else None


@lru_cache(maxsize=32)
def _lane_law(system: Any, d: int, found: Traces) -> LawCode | None:
    """The law for lanes of a system, which depends on the traces that were found."""
    return law_of(CanonicalOnRn(system, Rn(d)) if isinstance(system, Canonical) else system)


def has_law(problem: Problem, method: Galerkin) -> bool:
    """Whether the problem's system has a law for lanes that can be iterated with the method.

    Components that its mass couples must have the same degree: a chain of rods with other degrees
    does not contract at any step.
    """
    degrees = component_degrees(method)
    found = lane_law(problem.system, problem.q0.size)
    if found is None or degrees is None:
        return found is not None
    return all(degrees[i] == degrees[j] for i, j in coupled(found[0], len(degrees)))


def component_degrees(method: Galerkin) -> tuple[int, ...] | None:
    """The degree of each component, where the space has several; else None."""
    return getattr(method.space, "degrees", None)


@lru_cache(maxsize=32)
def _compiled(lines: str, d: int, lanes: int, one: bool) -> tuple[int, Any]:
    """The address of a law, and the function, which must exist as long."""
    function = compiled_law(PASS, lines, d=d, lanes=lanes, one=one, alone=False)
    return int(addresses((function, PASS_TYPE))[0]), function


@lru_cache(maxsize=32)
def law_tables(
    table: Tableau, step: float, lanes: int, degrees: tuple[int, ...] | None = None
) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.lanes.law.

    lanes    of a vector
    degrees  (d,) number of coefficients of each component; None where all have the table's
    """
    moves, turns, kicks, ahead, series, growth, fit = collocation_tables(table, step, lanes)
    (s, m), stages = table.slope.shape, stages_in_lanes(table.c.size, lanes)
    coefficients = degrees or (m,)
    P, complement = stages.size, np.zeros((0, stages.size))
    if s > min(coefficients):
        complement = in_blocks([outside(table, k)[stages].T for k in coefficients], P)
    tables = in_blocks(np.concatenate([moves, turns]).reshape(4, s, P), P)
    tables, complement = aligned_copies(tables, complement)
    c = read_only(table.c[stages])
    return kicks, ahead, series, tables, complement, growth, fit, c, growth[:0]


def outside(table: Tableau, coefficients: int) -> Array:
    """C (s, s) of galvi.lanes.law for the space's first functions."""
    root = np.sqrt(table.b)
    slopes = np.linalg.qr(root[:, None] * table.slope[:, :coefficients])[0]
    return np.eye(root.size) - slopes @ slopes.T * root / root[:, None]


class LawKernel:
    """Steps of a Lagrangian on R^d, by galvi.lanes.law.

    It owns what the address of the law and the words of its argument point to.
    """

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, method = request.problem, request.method
        d, s = problem.q0.size, method.stages
        law = lane_law(problem.system, d)
        assert law is not None  # see `group_kernel`
        lines, self._constants = law
        lanes = lanes_for(s)
        self._tables = law_tables(method.table, request.step, lanes, component_degrees(method))
        tables, complement = self._tables[3:5]
        padded = tables.shape[1]
        self._address, self._function = _compiled(lines, d, lanes, padded == lanes)
        self._scratch, self._spare = aligned((rows_of_work(d), padded), (6, max(padded, d, s)))
        self._numbers = np.zeros(4 * d + 4)
        self._words = words_of(
            self._scratch, tables, complement, self._constants, self._numbers, padded, s,
            len(complement),
        )  # fmt: skip
        self._kernel, self._work = compiled_advance_law(), work
        tolerance = max(request.checkpoint.tolerance, FINEST_ON_RN)
        self._plan, self._progress, self._saved = run_plan(request, work, tolerance)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        before = self._work.counts[FORCES]
        code = int(self._kernel(
            self._address, self._words.ctypes.data, self._tables, False, self._plan, n,
            self._progress, self._scratch, self._numbers, self._spare, self._saved,
        ))  # fmt: skip
        self._work.counts[FORCES_IN_LANES] += self._work.counts[FORCES] - before
        return code


def group_law(system: Any) -> LawCode | None:
    """The law for lanes of a system on a group other than R^d, or None."""
    group = getattr(system, "group", None)
    if group is None or isinstance(group, Rn):
        return None
    return _lane_law(system, group.dimension, traces(system))


def has_group_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes on a group other than R^d."""
    return group_law(problem.system) is not None


@lru_cache(maxsize=32)
def _compiled_on_group(
    system: Any, layout: tuple[tuple[int, ...], ...], chart: int, lanes: int, one: bool,
    found: Traces,
) -> tuple[int, Array, Any]:  # fmt: skip
    """The address of the system's law in a chart, its constants, and the function, which must be
    kept.

    layout  of galvi.run.group_system
    lanes  of a vector
    one    for one vector of stages, or for several
    """
    law = _lane_law(system, system.group.dimension, found)
    assert law is not None
    function = compiled_law(GROUP_PASS, law[0], layout=layout, chart=chart, lanes=lanes, one=one)
    return int(addresses((function, PASS_TYPE))[0]), law[1], function


@lru_cache(maxsize=32)
def group_law_tables(
    table: Tableau, step: float, lanes: int
) -> tuple[Array, Array, tuple[Array, ...]]:
    """A table, multiplied by the step, in the layout of galvi.lanes.group_law.

    lanes  of a vector
    """
    moves, turns, kicks, ahead, series, growth, fit = collocation_tables(table, step, lanes)
    (s, m), stages = table.slope.shape, stages_in_lanes(table.c.size, lanes)
    P, terms = stages.size, ahead.shape[0] // s
    Y = orthonormal_complement(table)
    complement, tables = aligned((2 * (s - m), P), ((4 + terms) * P + 3, P))
    complement[: s - m, :s], complement[s - m :, :s] = Y, Y * table.b
    for k, rows in enumerate(np.concatenate([moves, turns]).reshape(4, s, P)):
        tables[k * P : k * P + s] = rows
        if k < 2:
            tables[k * P : k * P + s, s:] = kicks[k][:, None]
    large, low = tables[2 * P : 2 * P + s], tables[3 * P : 3 * P + s]
    large[:], rest = two_sum(large, -kicks[0][:, None])
    low += rest - kicks[1][:, None]
    large[:, s:] = low[:, s:] = 0.0
    tables[4 * P : 4 * P + 2, :s] = kicks
    tables[4 * P + 2, :s] = np.mean(Y * Y, axis=0) * table.b if s > m else 0.0
    for k, rows in enumerate(ahead.reshape(terms, s, P)):
        tables[(4 + k) * P + 3 : (4 + k) * P + 3 + s] = rows
    return tables, complement, (series, growth, fit, read_only(table.c[stages]))


def orthonormal_complement(table: Tableau) -> Array:
    """The functions Y (s - m, s) of galvi.lanes.group_law at the stages."""
    root = np.sqrt(table.b)
    whole = np.linalg.qr(root[:, None] * table.slope, mode="complete")[0]
    return whole[:, table.slope.shape[1] :].T / root


class GroupLawKernel:
    """Steps of a Lagrangian on a group, by galvi.lanes.group_law.

    It owns what the address of the law and the words of its argument point to.
    """

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, method = request.problem, request.method
        system: Any = problem.system
        layout, chart = coupled_layout(system, problem), method.group_chart.number
        lanes = lanes_for(method.stages)
        tables, complement, others = group_law_tables(method.table, request.step, lanes)
        d, padded, extra = problem.v0.size, tables.shape[1], complement.shape[0] // 2
        self._address, constants, function = _compiled_on_group(
            system, tuple(map(tuple, layout.tolist())), chart, lanes, padded == lanes,
            traces(system),
        )  # fmt: skip
        self._scratch, self._spare = aligned(
            (rows_of_group_work(d, extra), padded), (6, max(HISTORY, padded, *work.state.shape))
        )
        self._numbers = np.zeros(3 * d + PLACE + problem.q0.size + 1)
        self._owned = function, tables, complement, constants
        self._words = words_of(
            self._scratch, tables, complement, constants, self._numbers, padded, method.stages,
            extra,
        )  # fmt: skip
        self._kernel, self._work = compiled_advance_group_law(), work
        tolerance = max(request.checkpoint.tolerance, FINEST_IN_LANES)
        plan, self._progress, self._saved = run_plan(request, work, tolerance)
        self._arguments = layout, chart, others, plan

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        before = self._work.counts[FORCES]
        code = int(self._kernel(
            self._address, self._words.ctypes.data, *self._arguments, n, self._progress,
            self._scratch, self._numbers, self._spare, self._saved,
        ))  # fmt: skip
        self._work.counts[FORCES_IN_LANES] += self._work.counts[FORCES] - before
        return code


def group_kernel(request: RunRequest) -> MakeKernel | str:
    """What makes the kernel in lanes of a run on a group, or of a Lagrangian; else why there is
    none."""
    problem, method = request.problem, request.method
    if has_law(problem, method):
        return partial(WithNewton, LawKernel)
    iterates = component_degrees(method) is None and float(np.min(method.table.b)) > 0.0
    if iterates and has_group_law(problem):
        return partial(WithNewton, GroupLawKernel)
    refusal = getattr(problem.system, "untraced", "")
    return "its functions are not known as expressions" + (f" ({refusal})" if refusal else "")


class WithNewton:
    """Steps in lanes; those whose iteration does not converge there, and some after them, by
    Newton's method in the general kernel."""

    def __init__(self, kernel: MakeKernel, request: RunRequest, work: RunArrays) -> None:
        self._in_lanes, self._request, self._work = kernel(request, work), request, work

    @cached_property
    def _general(self) -> Kernel:  # when it is first needed: compiling it takes long
        return CountedByNewton(self._request, self._work)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work = self._work
        if work.solver_state[STREAK]:
            before = work.done
            code = self._general.advance(min(n, int(work.solver_state[STREAK])))
            work.solver_state[STREAK] -= work.done - before
            return code
        code = self._in_lanes.advance(n)
        if code and self._request.checkpoint.solver != "fixed_point":
            work.solver_state[STREAK] = NEWTON_STREAK - 1
            code = self._general.advance(1)
        return code

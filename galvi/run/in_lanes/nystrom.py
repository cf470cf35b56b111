"""Steps of point masses and canonical systems in vector instructions."""

from __future__ import annotations

from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from galvi.arrays import Array, read_only
from galvi.extended_precision import scaled
from galvi.kernels.nystrom.advance import STREAK
from galvi.kernels.nystrom.solve import DIVERGED, FORCES
from galvi.lanes.nbody import compiled_advance
from galvi.lanes.vectors import LANES, lanes_for
from galvi.run.in_lanes.law_kernel import LawKernel, law_on_space
from galvi.run.in_lanes.tables import (
    Form,
    aligned,
    extrapolate_matrix,
    nystrom_tables,
    stages_in_lanes,
)
from galvi.run.request import ROUND_OFF, RunRequest
from galvi.run.run_arrays import FORCES_IN_LANES, RunArrays, run_plan
from galvi.run.stepper import Kernel, MakeKernel
from galvi.run.vector_space import GeneralVectorKernel, kernel_tableau
from galvi.systems.canonical import Canonical
from galvi.systems.nbody import NBody
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau
from galvi.tracing.lane_law import fits, unit_mass_law
from galvi.tracing.laws_of_systems import LawCode, slopes_of

# For one body the error left by the iteration is not random: 16 runs of a pendulum over 1e6 steps
# (degree 8, h = 0.2) have 15 standard errors of drift with a tolerance of 2^-64, and 0.3 with
# 2^-68, for 3 % more time (tests/properties/test_lanes.py).
LANE_TOLERANCE = 2.0**-68


def vector_kernel(request: RunRequest) -> MakeKernel | str:
    """The constructor of the kernel in lanes on a vector space; a clause on the reason where there
    is none."""
    system: Any = request.problem.system
    if isinstance(system, Canonical):
        if _unit_mass_law(system, request.problem.q0.size, traces(system)) is None:
            why = f" ({system.untraced})" if system.untraced else ""
            return f"its force is not known as a short expression{why}"
        return partial(WithGeneral, canonical_kernel)
    if not isinstance(system, NBody) or system.masses.size < 2:
        return "there is no force between bodies"
    if not system.acting.conserve:
        return "its forces depend on velocities"
    return partial(WithGeneral, PointMassKernel)


class WithGeneral:
    """Steps in lanes; a step whose iteration does not converge there is done by the general
    kernel."""

    def __init__(self, kernel: MakeKernel, request: RunRequest, work: RunArrays) -> None:
        self._in_lanes, self._request, self._work = kernel(request, work), request, work

    @cached_property
    def _general(self) -> Kernel:
        return GeneralVectorKernel(self._request, self._work)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work, code = self._work, DIVERGED
        before = work.counts[FORCES]
        if not work.solver_state[STREAK]:
            code = self._in_lanes.advance(n)
        work.counts[FORCES_IN_LANES] += work.counts[FORCES] - before
        return self._general.advance(1) if code else code


class PointMassKernel:
    """Steps of point masses, by galvi.lanes.nbody."""

    def __init__(self, request: RunRequest, work: RunArrays) -> None:
        problem, table = request.problem, request.method.table
        axes, d = (0,) * problem.q0.shape[-1], problem.q0.size
        self._kernel = compiled_advance(len(axes))
        tables, tableau = packed_tables(table, request.step), tuple(kernel_tableau(table))
        plan, self._progress, self._saved = run_plan(request, work, request.checkpoint.tolerance)
        width = tables[1].shape[1]
        self._scratch, self._spare = aligned((6, d, width), (8, max(d, width)))
        system: Any = problem.system
        acting = system.acting
        self._arguments = (
            axes,
            *_masses(system),
            acting.terms,
            acting.poles,
            tableau,
            tables,
            plan,
        )

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        arrays = self._progress, self._scratch, self._spare, self._saved
        return int(self._kernel(*self._arguments, n, *arrays))


@lru_cache(maxsize=32)
def _unit_mass_law(system: Canonical, d: int, system_traces: Traces) -> LawCode | None:
    """The law of unit mass, cached with the system's traces; None where the force is not known as
    an expression that fits."""
    inverse_mass, slopes = system.inverse_mass(d), slopes_of(system)
    coupled = inverse_mass.shape[1] > 1
    if slopes is None or not fits(d, coupled):
        return None
    lines = unit_mass_law(slopes[0], "", d, coupled, 0)
    return lines, np.concatenate([inverse_mass.ravel(), slopes[1]])


def canonical_kernel(request: RunRequest, work: RunArrays) -> LawKernel:
    """The kernel of a canonical system with a force law, in positions alone."""
    system: Any = request.problem.system
    table, d, h = request.method.table, request.problem.q0.size, request.step
    law, s = _unit_mass_law(system, d, traces(system)), table.c.size
    assert law is not None  # see `vector_kernel`
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        fit = h * h * table.C
    curves = read_only(fit), read_only(h * table.velocity_coefficients)
    tolerance = request.checkpoint.tolerance
    lane_tolerance = LANE_TOLERANCE if tolerance == ROUND_OFF else tolerance
    lanes = lanes_for(s)
    tables = nystrom_tables(table, Form(h, lanes))
    step = law_on_space(law[0], d, True, lanes, s <= lanes)
    return LawKernel(step, law[1], tables, curves, lane_tolerance, request, work)


@lru_cache(maxsize=32)
def _masses(system: NBody) -> tuple[Array, Any, Any]:
    """G m (n,), and the indices of the bodies with a mass and of the massless ones."""
    heavy, light = (
        np.flatnonzero(has_this_mass)
        for has_this_mass in (system.masses > 0.0, system.masses == 0.0)
    )
    for bodies in (heavy, light):
        bodies.setflags(write=False)
    return read_only(system.G * system.masses), heavy, light


@lru_cache(maxsize=32)
def packed_tables(table: Tableau, step: float) -> tuple[Array, ...]:
    """A table, multiplied by the step, in the layout of galvi.lanes.nbody."""
    stage_matrices, columns, c = _nystrom_parts(table, step, LANES)
    numbers = (
        np.concatenate(stage_matrices),
        table.analysis.T[:, stages_in_lanes(table.c.size)],
        table.growth,
        columns,
        c,
    )
    return tuple(read_only(np.array(number)) for number in numbers)


def _nystrom_parts(table: Tableau, step: float, lanes: int) -> tuple[Array, Array, Array]:
    """h^2 A^T, then the same after extrapolation by 1, ..., l Legendre polynomials, then its low
    part, (l + 2, s, P); columns h b, h^2 beta, their low parts (s, P); c, its low part (2, P)."""
    stages = stages_in_lanes(table.c.size, lanes)
    high = table.c, table.b, table.beta, table.A
    c, b, beta, A = map(np.stack, zip(high, table.low_parts[:4], strict=True))
    stage_matrices = scaled(A, step, 2)[:, stages].swapaxes(1, 2)
    with np.errstate(all="ignore"):  # a step whose square overflows is reported by the status
        stage_matrices = np.concatenate(
            [stage_matrices[:1], extrapolate_matrix(table, stage_matrices[0]), stage_matrices[1:]]
        )
    columns = np.zeros((table.c.size, stages.size))
    columns[:, :4] = np.stack([*scaled(b, step), *scaled(beta, step, 2)])[[0, 2, 1, 3]].T
    return stage_matrices, columns, c[:, stages]

"""Steps of a Lagrangian on R^d or on a Lie group in vector instructions."""

from __future__ import annotations

from functools import cached_property, lru_cache, partial
from typing import Any

import numpy as np

from galvi.arrays import read_only
from galvi.groups.group import Rn
from galvi.kernels.nystrom.advance import STREAK
from galvi.kernels.nystrom.solve import NEWTON_STREAK
from galvi.lanes.vectors import lanes_for
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.group_system import coupled_layout
from galvi.run.in_lanes.law_kernel import LawKernel, law_on_group, law_on_space
from galvi.run.in_lanes.tables import Form, tables_on_group, tables_on_space
from galvi.run.on_group import NewtonFallback
from galvi.run.request import RunRequest
from galvi.run.run_arrays import RunArrays
from galvi.run.stepper import Kernel, MakeKernel
from galvi.systems.canonical import Canonical
from galvi.systems.canonical_on_rn import CanonicalOnRn
from galvi.systems.nbody import NBody
from galvi.systems.nbody_on_rn import NBodyOnRn
from galvi.systems.traces import Traces, traces
from galvi.tracing.lane_law import coupled_components
from galvi.tracing.laws_of_systems import LawCode, law_of

# Relative change up to which steps on groups are iterated: a free body (degree 6, 6 points, h =
# 0.2) loses 3.6e-18 of its energy a step with 2^-55, and 1.2e-18 with 2^-58.
LEAST_TOLERANCE_ON_GROUP = 2.0**-58
# On R^d it must be smaller: an elastic pendulum (degree 8, 9 points, h = 0.03) loses 5e-19 of its
# energy a step with 2^-55, and at most 2e-20 with 2^-60.
LEAST_TOLERANCE_ON_RN = 2.0**-60


NO_LINE = read_only(np.zeros(0))  # curves whose coefficients depend only on rates have no line


def lane_law(system: Any, d: int) -> LawCode | None:
    """The law for lanes of a system of d coordinates on R^d; None where it has none."""
    system_traces = traces(system)
    if isinstance(system, NBody) and system.acting.of_velocity:
        system = NBodyOnRn(system, d // system.masses.size)
    group = getattr(system, "group", None)
    on_space = isinstance(group, Rn) or isinstance(system, Canonical)
    return _lane_law(system, d, system_traces) if on_space else None


@lru_cache(maxsize=32)
def _lane_law(system: Any, d: int, system_traces: Traces) -> LawCode | None:
    """The law for lanes of a system, cached with its traces."""
    return law_of(CanonicalOnRn(system, Rn(d)) if isinstance(system, Canonical) else system)


def can_use_law(problem: Problem, method: Galerkin) -> bool:
    """Whether the problem's system has a law for lanes that can be iterated with the method.

    Components that its mass couples must have the same degree: a chain of rods with other degrees
    does not contract at any step.
    """
    degrees = component_degrees(method)
    law = lane_law(problem.system, problem.q0.size)
    if law is None or degrees is None:
        return law is not None
    return all(degrees[i] == degrees[j] for i, j in coupled_components(law[0], len(degrees)))


def component_degrees(method: Galerkin) -> tuple[int, ...] | None:
    """The degree of each component; None where the space has one degree for all."""
    return getattr(method.space, "degrees", None)


def law_kernel(request: RunRequest, work: RunArrays) -> LawKernel:
    """The kernel of a Lagrangian on R^d."""
    method, d, h = request.method, request.problem.q0.size, request.step
    law, s = lane_law(request.problem.system, d), method.stages
    assert law is not None  # see `group_kernel`
    lanes, curves = lanes_for(s), (read_only(h * method.table.projection), NO_LINE)
    tables = tables_on_space(method.table, component_degrees(method), Form(h, lanes))
    step = law_on_space(law[0], d, False, lanes, s <= lanes)
    tolerance = max(request.checkpoint.tolerance, LEAST_TOLERANCE_ON_RN)
    return LawKernel(step, law[1], tables, curves, tolerance, request, work)


def group_law(system: Any) -> LawCode | None:
    """The law for lanes of a system on a group other than R^d; None where it has none."""
    group = getattr(system, "group", None)
    if group is None or isinstance(group, Rn):
        return None
    return _lane_law(system, group.dimension, traces(system))


def has_group_law(problem: Problem) -> bool:
    """Whether the problem's system has a law for lanes on a group other than R^d."""
    return group_law(problem.system) is not None


def group_law_kernel(request: RunRequest, work: RunArrays) -> LawKernel:
    """The kernel of a Lagrangian on a group."""
    problem, method, system = request.problem, request.method, request.problem.system
    law, s, h = group_law(system), request.method.stages, request.step
    assert law is not None  # see `group_kernel`
    lanes, curves = lanes_for(s), (read_only(h * method.table.projection), NO_LINE)
    layout = tuple(map(tuple, coupled_layout(system, problem).tolist()))
    step = law_on_group(law[0], layout, method.group_chart.number, lanes, s <= lanes)
    tables = tables_on_group(method.table, Form(h, lanes))
    tolerance = max(request.checkpoint.tolerance, LEAST_TOLERANCE_ON_GROUP)
    return LawKernel(step, law[1], tables, curves, tolerance, request, work)


def group_kernel(request: RunRequest) -> MakeKernel | str:
    """The constructor of the kernel in lanes for a Lagrangian on R^d or another group; a clause on
    the reason where there is none."""
    problem, method = request.problem, request.method
    if can_use_law(problem, method):
        return partial(WithNewton, law_kernel)
    can_iterate = component_degrees(method) is None and float(np.min(method.table.b)) > 0.0
    if can_iterate and has_group_law(problem):
        return partial(WithNewton, group_law_kernel)
    refusal = getattr(problem.system, "untraced", "")
    return "its functions are not known as expressions" + (f" ({refusal})" if refusal else "")


class WithNewton:
    """Steps in lanes; a step whose iteration does not converge there, and NEWTON_STREAK - 1 steps
    after it, are done by Newton's method in the general kernel."""

    def __init__(self, kernel: MakeKernel, request: RunRequest, work: RunArrays) -> None:
        self._in_lanes, self._request, self._work = kernel(request, work), request, work

    @cached_property
    def _general(self) -> Kernel:  # made when first needed, since compiling it takes long
        return NewtonFallback(self._request, self._work)

    def advance(self, n: int) -> int:
        """See `galvi.run.stepper.Kernel`."""
        work = self._work
        if work.solver_state[STREAK]:
            before = work.steps_done
            code = self._general.advance(min(n, int(work.solver_state[STREAK])))
            work.solver_state[STREAK] -= work.steps_done - before
            return code
        code = self._in_lanes.advance(n)
        if code and self._request.checkpoint.solver != "fixed_point":
            work.solver_state[STREAK] = NEWTON_STREAK - 1
            code = self._general.advance(1)
        return code

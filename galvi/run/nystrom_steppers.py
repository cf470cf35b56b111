"""The general kernel for steps on a vector space, and what is tried before it."""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

from galvi.arrays import Array, read_only
from galvi.kernels.compile.function_pointers import interpreted
from galvi.kernels.nystrom import advance
from galvi.kernels.nystrom.reach import compiled_reach, reach
from galvi.kernels.nystrom.solve import AUTO, FIXED_POINT, NEWTON, Force
from galvi.kernels.nystrom.step import NystromTableau
from galvi.run.plan import Call, Run
from galvi.run.run_arrays import RunArrays, run_plan
from galvi.systems.system import ForceKernel
from galvi.tableau import Tableau

# Far below the rounding unit 2^-53: the error left by an iteration is not random and makes the
# energy drift. 32 runs of the outer solar system over 1e6 years (benchmarks/studies/round_off.py,
# degree 8): 23 standard errors of drift with 2^-60, 1.6 with 2^-64, for 3 % more time.
ROUND_OFF = 2.0**-64
SOLVERS = {"auto": AUTO, "fixed_point": FIXED_POINT, "newton": NEWTON}


FAST: list[Callable[[Run, RunArrays], Call | None]] = []  # tried first; galvi.fast registers them


def stepper(run: Run, work: RunArrays) -> Call:
    """A `Call` of the first kernel that does such a run; the general one does all."""
    if run.start.solver != "newton":
        for fast in FAST:
            call = fast(run, work)
            if call is not None:
                return call
    return general_stepper(run, work)


def general_stepper(run: Run, work: RunArrays) -> Call:
    """A `Call` of the general kernel: does n more steps and returns its code."""
    system: Any = run.problem.system
    field, force = _force(system, run.problem.q0.shape[-1])
    kernel = advance.compiled_advance() if field.compiled else interpreted(advance.advance)
    tableau, solver = tuple(kernel_tableau(run.method.table)), SOLVERS[run.start.solver]
    plan, progress, kept = run_plan(run, work, run.start.tolerance)

    def call(todo: int) -> int:
        return int(kernel(force, tableau, plan, solver, todo, progress, kept))

    return call


def reaching(run: Run) -> Callable[..., None]:
    """The kernel of galvi.kernels.nystrom.reach for a run, called with what comes after step."""
    system: Any = run.problem.system
    field, force = _force(system, run.problem.q0.shape[-1])
    kernel = compiled_reach() if field.compiled else interpreted(reach)
    tableau, solver = tuple(kernel_tableau(run.method.table)), SOLVERS[run.start.solver]
    return partial(kernel, force, tableau, solver, run.start.tolerance, run.step)


@lru_cache(maxsize=32)
def _force(system: Any, dimension: int) -> tuple[ForceKernel, tuple[Any, ...]]:
    """The force of a system, which owns the functions, and as the kernel takes it."""
    field = system.force_kernel(dimension)
    return field, tuple(Force(
        field.kind, field.functions, field.slope is not None, field.constants, field.inverse_mass,
        field.width,
    ))  # fmt: skip


@lru_cache(maxsize=32)
def kernel_tableau(table: Tableau) -> NystromTableau:
    """A table in the layout of galvi.kernels.nystrom.step."""

    def transposed(matrix: Array) -> Array:
        return read_only(matrix.T)

    c_low, b_low, beta_low, *_, psi_low, C_low, line_low = table.low_parts
    beta_low = read_only(beta_low + table.b * c_low)
    return NystromTableau(
        table.c, table.b, table.beta, b_low, beta_low, transposed(table.A),
        transposed(table.psi), table.velocity_coefficients, table.C, transposed(table.C),
        transposed(table.analysis), transposed(table.extrapolation), table.growth,
        transposed(psi_low), C_low, line_low, c_low,
    )  # fmt: skip

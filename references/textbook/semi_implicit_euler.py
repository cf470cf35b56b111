"""Semi-implicit symplectic Euler, order 1, with forces that depend on the velocity (M 6.2).

v' = v + h a(q, v, t),   q' = q + h v'

h, t0                     step, time of the start
q, v (d,)                 state, advanced in place
first, last, total        steps done, to be done in this call, in the whole run
saved_q, saved_v (n, d)   states kept: every `every` steps and the last
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any, cast

import numpy as np
from numba import types

from galvi import Canonical, NBody, Problem, Trajectory
from galvi.arrays import Array
from galvi.groups.rn import Rn
from galvi.kernels.compile import interpreted as interpretation
from galvi.kernels.compile.array_types import MATRIX, VECTOR
from galvi.kernels.compile.jit import compiled_for, jit
from galvi.kernels.forces import force_kinds
from galvi.kernels.forces.accelerations import accelerations, apply_inverse_mass
from galvi.kernels.forces.lagrangian_derivatives import NO_FORCE, Law, external_force
from galvi.systems.canonical_on_rn import CanonicalOnRn
from galvi.systems.lagrangian_kernel import LagrangianKernel
from references.as_trajectory import Failure, outcome
from references.contender import require
from references.newton import is_forced
from references.setting import check_keys, described, fixed_steps

CHUNK = 100_000  # steps between two looks at Ctrl-C
STATE, ROWS, WHOLE, REAL = VECTOR, MATRIX, types.int64, types.float64
UNFORCED = NO_FORCE, force_kinds.no_constants()
SIGNATURE = WHOLE(
    WHOLE, types.int64[::1], STATE, ROWS, WHOLE, STATE, STATE, STATE, REAL, REAL, WHOLE, WHOLE,
    WHOLE, WHOLE, ROWS, ROWS,
)  # fmt: skip


@jit
def advance(
    kind, functions, constants, inverse_mass, pushed, push_constants, q, v, t0, h, first, last,
    total, every, saved_q, saved_v,
):  # fmt: skip
    """Steps first .. last; returns the number of the step that failed, 0 when none did."""
    d = q.size
    Q = np.empty((d, 1))
    a = np.empty((d, 1))
    added = np.empty((2, d))
    push_back = np.zeros((d, 1))
    t = np.empty(1)
    for k in range(first, last):
        t[0] = t0 + k * h
        Q[:, 0] = q
        accelerations(kind, functions, constants, inverse_mass, Q, t, a)
        if pushed != NO_FORCE:
            added[:, :] = 0.0
            law = Law(functions, 0, False, 0, constants, pushed, push_constants)
            external_force(law, q, v, t[0], added)
            push_back[:, 0] = -added[1, :]
            apply_inverse_mass(inverse_mass, push_back)
        residue = 0.0
        for i in range(d):
            v[i] += h * (a[i, 0] + push_back[i, 0])
            q[i] += h * v[i]
            residue += (q[i] - q[i]) + (v[i] - v[i])
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1
        if (k + 1) % every == 0 or k + 1 == total:
            row = (k + every) // every
            saved_q[row, :] = q
            saved_v[row, :] = v
    return 0


@cache
def compiled() -> Callable[..., Any]:
    """One compilation, kept on disk, for every law and every user's jitted functions."""
    source: Any = advance
    kernel: Callable[..., Any] = compiled_for(source, SIGNATURE)
    return kernel


@cache
def interpreted() -> Callable[..., Any]:
    """The same source run by the interpreter, for forces that cannot be compiled."""
    return interpretation.interpreted(advance)


@dataclass(frozen=True)
class SemiImplicitEuler:
    """The force at the old place and velocity, the place by the new one; setting: step, save_every.

    M's reference of low order; without a velocity in the force it is `SYMPLECTIC_EULER`.
    """

    name: str = "semi-implicit Euler"
    order: int = 1
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Any system on a vector space with L = v.M v / 2 - V, whatever acts on it."""
        return isinstance(problem.system, (Canonical, NBody))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; compiled when all forces are, else interpreted. See `Contender`."""
        require(self, problem)
        check_keys(setting, ("step", "save_every"))
        steps = fixed_steps(duration, setting)
        times = steps.times(problem.t0)
        field = problem.system.field(problem.q0.shape[-1])
        forced = forced_field(problem) if is_forced(problem) else None
        pushed, numbers = (forced.force_kind, forced.force_constants) if forced else UNFORCED
        functions, jitted = (forced or field).functions, (forced or field).compiled
        advance = compiled() if jitted else interpreted()
        q, v = problem.q0.flatten(), problem.v0.flatten()
        saved: list[Array] = [np.full((len(times), q.size), np.nan) for _ in "qv"]
        saved[0][0], saved[1][0] = q, v
        every = int(steps.saved[1])
        failed = done = 0
        while done < steps.count and not failed:
            last = min(done + CHUNK, steps.count)
            with np.errstate(all="ignore"):  # the kernel looks for non-finite states itself
                failed = advance(
                    field.kind, functions, field.constants, field.inverse_mass, pushed, numbers,
                    q, v, problem.t0, steps.step, done, last, steps.count, every, *saved,
                )  # fmt: skip
            done = failed - 1 if failed else last
        return outcome(
            problem,
            described(self.name, setting),
            times,
            *saved,
            counts={"steps": done, "force_evaluations": done + (failed > 0)},
            step=steps.step,
            failure=_failure(failed, steps.saved, times) if failed else None,
        )


def forced_field(problem: Problem) -> LagrangianKernel:
    """Whose two functions are the system's force and the external one."""
    return CanonicalOnRn(cast(Canonical, problem.system), Rn(problem.q0.size)).lagrangian_kernel()


def _failure(failed: int, saved: Any, times: Array) -> Failure:
    row = int(np.searchsorted(saved, failed))
    return Failure(
        row=row,
        step=failed,
        why=f"Step {failed}, towards t = {times[row]:.6g}, gave a non-finite state: the step is "
        "too large. Choose a smaller step, or end the run earlier.",
    )


SEMI_IMPLICIT_EULER = SemiImplicitEuler()

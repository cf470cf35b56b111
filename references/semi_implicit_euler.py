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
from typing import Any

import numpy as np
from numba import types

from galvi import Canonical, NBody, Problem, Trajectory
from galvi.arrays import Array
from galvi.forces.known_force import KnownForce
from galvi.kernels import interpreted as interpretation
from galvi.kernels import laws
from galvi.kernels.accelerations import accelerations, apply_inverse_mass
from galvi.kernels.jit import compiled_for, jit
from galvi.kernels.slopes import LAW_TYPE, no_law
from galvi.systems.compiles import compiles
from references.contender import require
from references.outcome import Failure, outcome
from references.second_law import is_forced
from references.setting import check_keys, described, fixed_steps

CHUNK = 100_000  # steps between two looks at Ctrl-C
STATE, ROWS, WHOLE, REAL = laws.VECTOR, laws.MATRIX, types.int64, types.float64
FREE, FORCED, TIMED, KNOWN = 0, 1, 2, 3
ARGUMENTS = {FREE: (STATE, STATE), FORCED: (STATE, STATE), TIMED: (STATE, STATE, REAL)}
SIGNATURE = WHOLE(
    WHOLE, laws.LAW, laws.GRADIENT_TYPE, laws.TIMED_GRADIENT_TYPE, STATE, ROWS,
    WHOLE, types.FunctionType(STATE(*ARGUMENTS[FORCED])),
    types.FunctionType(STATE(*ARGUMENTS[TIMED])), LAW_TYPE, STATE,
    STATE, STATE, REAL, REAL, WHOLE, WHOLE, WHOLE, WHOLE, ROWS, ROWS,
)  # fmt: skip


@jit
def no_force(q, v):
    """Stand-in for a force(q, v), never called."""
    return np.zeros(v.size)


@jit
def no_timed_force(q, v, t):
    """Stand-in for a force(q, v, t), never called."""
    return np.zeros(v.size)


@jit
def advance(
    kind, law, gradient, timed_gradient, constants, inverse_mass, forced, force, timed_force,
    push, push_constants, q, v, t0, h, first, last, total, every, saved_q, saved_v,
):  # fmt: skip
    """Steps first .. last; returns the number of the step that failed, 0 when none did."""
    d = q.size
    Q = np.empty((d, 1))
    a = np.empty((d, 1))
    pushed = np.zeros((d, 1))
    added = np.empty((2, d))
    t = np.empty(1)
    for k in range(first, last):
        t[0] = t0 + k * h
        Q[:, 0] = q
        accelerations(kind, law, gradient, timed_gradient, constants, inverse_mass, Q, t, a)
        if forced != FREE:
            added[:, :] = 0.0
            if forced == KNOWN:
                push(q, v, t[0], push_constants, added)
            elif forced == TIMED:
                added[1, :] = timed_force(q.copy(), v.copy(), t[0])
            else:
                added[1, :] = force(q.copy(), v.copy())
            pushed[:, 0] = -added[1, :]
            apply_inverse_mass(inverse_mass, pushed)
        residue = 0.0
        for i in range(d):
            v[i] += h * (a[i, 0] + pushed[i, 0])
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
        kind, forces, jitted = _forces(problem)
        advance = compiled() if field.compiled and jitted else interpreted()
        q, v = problem.q0.flatten(), problem.v0.flatten()
        saved: list[Array] = [np.full((len(times), q.size), np.nan) for _ in "qv"]
        saved[0][0], saved[1][0] = q, v
        every = int(steps.saved[1])
        failed = done = 0
        while done < steps.count and not failed:
            last = min(done + CHUNK, steps.count)
            with np.errstate(all="ignore"):  # the kernel looks for non-finite states itself
                failed = advance(
                    field.kind, field.law, field.gradient, field.timed_gradient, field.constants,
                    field.inverse_mass, kind, *forces, q, v, problem.t0, steps.step, done, last,
                    steps.count, every, *saved,
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


def _forces(problem: Problem) -> tuple[int, tuple[Any, ...], bool]:
    """Which kind the external force is of, what the kernel is given, and whether it compiles."""
    system: Any = problem.system
    none, unknown = (no_force, no_timed_force), (no_law, laws.no_constants())
    if not is_forced(problem):
        return FREE, (*none, *unknown), True
    if isinstance(system.force, KnownForce):
        known = system.force.push()
        return KNOWN, (*none, known.add, known.constants), True
    kind = TIMED if system.timed_force else FORCED
    forces = (no_force, system.force) if system.timed_force else (system.force, no_timed_force)
    return kind, (*forces, *unknown), compiles(system.force, ARGUMENTS[kind], STATE)


def _failure(failed: int, saved: Any, times: Array) -> Failure:
    row = int(np.searchsorted(saved, failed))
    return Failure(
        row=row,
        step=failed,
        why=f"Step {failed}, towards t = {times[row]:.6g}, gave a non-finite state: the step is "
        "too large. Choose a smaller step, or end the run earlier.",
    )


SEMI_IMPLICIT_EULER = SemiImplicitEuler()

"""Steps in a clock of systems that are driven or damped: their energy E and time t change too.

    t' = g,    E' = g (F . v - dL/dt),    both collocated at the stages

beside the Lagrangian g (L(q, q'/g, t) + E) with the force g F. Given t and E at the stages, a step
is one of the engines of that Lagrangian; they follow by iteration. With Gauss s and degree s, or
Lobatto s + 1 and degree s, this is a (partitioned) Runge-Kutta method of order 2 s; other methods
are refused.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, cast

import numpy as np
from numpy.polynomial import legendre

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves
from galvi.kernels.nystrom.solve import DIVERGED, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss, lobatto
from galvi.run.clocked.general import added, chart_of, counted, lagrangian_of, slopes_in_clock
from galvi.run.clocked.plan import NO_COUNTS, Advanced, Motion, Taken, joined
from galvi.run.engine_choice import engine_for
from galvi.run.interruption import uninterrupted
from galvi.run.loop import run_steps
from galvi.run.plan import Run
from galvi.spaces.polynomials import Polynomials
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian

PASSES = 60
SETTLED = 8.0 * 2.0**-53  # change of t and E, relative to their sizes, at which a step is done
NOISE = 1e-9  # below which changes that no longer shrink are rounding
NUDGE = 2.0**-4  # of the step in time, to differ L by t


class AtStages:
    """Times and energies (s,) at the stages of the step that is being solved, at shares c of it."""

    def __init__(self, c: Array, t: float, energy: float) -> None:
        self.c, self.step = c, 1.0
        self.t, self.energy = np.full(c.size, t), np.full(c.size, energy)

    def at(self, tau: float) -> tuple[float, float]:
        """t and E at the stage next to a time in tau since the step's start."""
        stage = int(np.argmin(np.abs(self.c * self.step - tau)))
        return float(self.t[stage]), float(self.energy[stage])


def motion_of_driven(
    problem: Problem, method: Galerkin, energy: float, solver: str, tolerance: float
) -> Motion:
    """The motion of a system with an external force or explicit time."""
    s, degree = method.stages, method.space.degree
    collocated = method.rule == gauss(degree) or method.rule == lobatto(degree + 1)
    if not collocated or method.space != Polynomials(degree):
        raise ValueError(
            f"with an external force or explicit time a clock needs Polynomials(s) with gauss(s) "
            f"or lobatto(s + 1), which collocate t and the energy; received {method.name}."
        )
    table, rate = method.table, method.clock.rate(problem)
    told = AtStages(table.c, problem.t0, energy)
    base = lagrangian_of(problem.system, problem)
    inner = _inner(problem, base, method.clock, told)
    plain = Galerkin(method.space, method.rule, method.group_chart)
    engine = engine_for(inner, plain)
    within = _integral(table.analysis, table.c)

    def start(q: Array, v: Array) -> Checkpoint:
        here = Problem(inner.system, q.reshape(inner.q0.shape), rate(q.ravel()) * v.ravel())
        return Checkpoint(0, *engine.start(here, plain), solver, tolerance, curves=True)

    def one(state: Checkpoint, h: float) -> tuple[Any, Array, Array | None]:
        """The inner run of a step, g at its stages, and t and E at its end; None if it failed."""
        t, low, e, e_low = state.clock.tolist()
        g = np.full(s, float(rate(state.state[0, : problem.q0.size])))
        power, told.step, change = np.zeros(s), h, np.inf
        begin = Checkpoint(
            0, state.state, state.stages, state.solver_state, solver, tolerance, curves=True
        )
        for _ in range(PASSES):
            told.t, told.energy = t + (low + h * (within @ g)), e + (e_low + h * (within @ power))
            run = uninterrupted(run_steps(engine, Run(inner, plain, h, 1, begin), watched=False))
            if run.counts["steps"] == 0:
                return run, g, None
            curves, index = cast(Curves, run.curves), np.zeros(s, dtype=np.int64)
            places = curves.places(index, table.c)
            new = np.array([float(rate(q.reshape(-1))) for q in places])
            u = curves.velocities(index, table.c)
            pairs = zip(places, u / new[:, None], told.t, strict=True)
            new_power = new * np.array([_power(base, q, v, x, h * g[0]) for q, v, x in pairs])
            before = change
            change = float(
                np.max(np.abs(new - g)) / np.max(np.abs(new))
                + np.max(np.abs(new_power - power)) / (np.max(np.abs(new_power)) or 1.0)
            )
            g, power = new, new_power
            if change <= SETTLED or before <= change < NOISE:
                changes = h * np.array([table.b @ g, table.b @ power])
                ends = [added(state.clock[k : k + 2], [changes[k // 2]])[0] for k in (0, 2)]
                return run, g, np.concatenate(ends)
        return run, g, None

    def advance(state: Checkpoint, h: float, n: int, time: float | None, keep: bool) -> Advanced:
        rows: list[Taken] = []
        reason = ""
        for _ in range(n):
            run, g, clock = one(state, h)
            if clock is None:
                reason = run.status.partition(": ")[2] or (
                    "the energy and the time at the stages did not settle. Use a smaller step"
                )
                break
            if time is not None and (clock[0] - time) * h > 0.0:
                break
            end = run.checkpoint
            state = replace(
                end, first=state.first + 1, clock=clock, energies=state.energies, curves=None
            )
            kept = run.curves.coefficients[: 1 if keep else 0]
            q, p = run.q[1:].reshape(1, -1), run.p[1:].reshape(1, -1)
            rows.append(Taken(q, p, None, clock[None, :2], kept, g[None], counted(run)))
        code = DIVERGED if reason else SOLVED
        if not rows:
            d, m = problem.v0.size, method.space.dimension - 1
            shapes = (0, problem.q0.size), (0, d), (0, 2), (0, d, m), (0, s)
            q, p, t, coefficients, rates = map(np.zeros, shapes)
            return Advanced(
                Taken(q, p, None, t, coefficients, rates, NO_COUNTS), state, code, reason
            )
        return Advanced(joined(rows), state, code, reason)

    def at(q: Array, v: Array, t: float) -> Checkpoint:
        here = float(base.energy(q.reshape(inner.q0.shape), v.ravel(), t))
        return replace(start(q, v), clock=np.array([t, 0.0, here, 0.0]))

    return Motion(advance, at, rate, chart_of(problem, plain), "clock")


def _inner(problem: Problem, base: Lagrangian, clock: Any, told: AtStages) -> Problem:
    """The problem in tau, from 0 on in each step; t and E are those told."""
    rate, slope, timed = clock.rate(problem), clock.slope(problem), base.explicit_time
    shape = problem.q0.shape if len(base.group.shape) == 2 else (problem.q0.size,)
    q0, v0 = problem.q0.reshape(shape), problem.v0.ravel()
    known = base.euclidean_slopes(q0, v0, problem.t0)
    by_chain_rule = slopes_in_clock(base, cast(Callable[..., Array], known), rate, slope)

    def function(q: Any, u: Any, tau: float) -> Any:
        t, energy = told.at(float(tau))
        g = rate(q.reshape(-1))
        return g * (base.function(q, u / g, *((t,) if timed else ())) + energy)

    def slopes(q: Array, u: Array, tau: float) -> Array:
        t, energy = told.at(tau)
        return by_chain_rule(q, u, energy, *((t,) if timed else ()))

    def force(q: Array, u: Array, tau: float) -> Array:
        t, _ = told.at(tau)
        g = rate(q.reshape(-1))
        return np.asarray(g * force_at(base, q, u / g, t))

    pushed = base.force is not None
    system = Lagrangian(
        function, base.group, slopes if known else None, force if pushed else None,
        explicit_time=True, timed_force=pushed, check=False,
    )  # fmt: skip
    return Problem(system, q0, rate(q0.reshape(-1)) * v0)


def _power(base: Lagrangian, q: Array, v: Array, t: float, dt: float) -> float:
    """F . v - dL/dt at one state; differences over a part of dt."""
    found = float(np.dot(force_at(base, q, v, t).ravel(), v.ravel()))
    if not base.explicit_time:
        return found
    for k, weight in enumerate(WEIGHTS, start=1):
        far = k * NUDGE * dt
        change = float(base.function(q, v, t + far)) - float(base.function(q, v, t - far))
        found -= weight * change / (NUDGE * dt)
    return found


def _integral(analysis: Array, c: Array) -> Array:
    """(s, s) integrals from 0 to c_i of the polynomials that interpolate at the stages."""
    whole = legendre.legint(analysis, lbnd=-1.0, axis=0)
    return 0.5 * legendre.legvander(2.0 * c - 1.0, len(whole) - 1) @ whole

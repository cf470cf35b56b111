"""Steps in a clock of systems that are driven or damped: their energy E and time t change too.

    t' = g,    E' = g (F . v - dL/dt),    both collocated at the stages

beside the Lagrangian g (L(q, q'/g, t) + E) with the force g F. With Gauss s and degree s, or
Lobatto s + 1 and degree s, this is a (partitioned) Runge-Kutta method of order 2 s; other methods
are refused. With Gauss and a constant mass it is collocation of

    q' = g v,    p' = g (dL/dq + F) - (H - E) dg/dq,    p = M v,

solved by fixed-point passes. Elsewhere, and where these do not settle, a step is one of the engines
of that Lagrangian with t and E given at the stages, which follow by iteration.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.polynomial import legendre

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.curves.curves import Curves
from galvi.kernels.nystrom.advance import HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import DIVERGED, SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss, lobatto
from galvi.run.clocked.general import (
    IN_GENERAL,
    added,
    chart_of,
    lagrangian_of,
    refuse_massless,
    slopes_in_clock,
)
from galvi.run.clocked.plan import NO_COUNTS, Advanced, Motion, Taken, joined
from galvi.run.general import inertial_formulation
from galvi.run.in_lanes.engine import INERTIAL
from galvi.run.request import RunRequest
from galvi.run.stepper import solve_steps
from galvi.spaces.polynomials import Polynomials
from galvi.systems.canonical import Canonical
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody

PASSES = 60
SETTLED = 8.0 * 2.0**-53  # relative change, see `Settling`, at which a step is done
NOISE, IDLE = 1e-9, 3  # below it so many changes that are none the smaller are rounding
NUDGE = 2.0**-4  # of the step in time, to differ L by t
UNSETTLED = "the energy and the time at the stages did not settle. Use a smaller step"


class Step(NamedTuple):
    """One step: the state after it, its curve (1, d, m), g at its stages (s,), t and E at its end
    with their low parts (4,), and its counts (4,)."""

    end: Checkpoint
    coefficients: Array
    rates: Array
    clock: Array
    counts: Array


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
    refuse_massless(problem)
    if not collocated or method.space != Polynomials(degree):
        raise ValueError(
            f"with an external force or explicit time a clock needs Polynomials(s) with gauss(s) "
            f"or lobatto(s + 1), which collocate t and the energy; received {method.name}."
        )
    table, rate = method.table, method.clock.rate(problem)
    told = AtStages(table.c, problem.t0, energy)
    base = lagrangian_of(problem.system, problem)
    shape = problem.q0.shape if len(base.group.shape) == 2 else (problem.q0.size,)
    known = base.euclidean_slopes(problem.q0.reshape(shape), problem.v0.ravel(), problem.t0)
    inner = _inner(problem, base, method.clock, told, known)
    plain = Galerkin(method.space, method.rule, method.group_chart)
    engine = inertial_formulation(inner, plain)
    within = _integral(table.analysis, table.c)
    by_passes, constant = None, isinstance(problem.system, Canonical | NBody)
    if constant and known and solver != "newton" and method.rule == gauss(degree):
        by_passes = _passes(problem, method, base, known, tolerance)
    if solver == "fixed_point" and by_passes is None:
        raise ValueError(
            f"with an external force or explicit time the solver fixed_point needs a constant mass "
            f"and gauss(s) in a clock; received a {type(problem.system).__name__} system and "
            f"{method.name}. Use the solver auto."
        )

    def start(q: Array, v: Array) -> Checkpoint:
        here = Problem(inner.system, q.reshape(inner.q0.shape), rate(q.ravel()) * v.ravel())
        return Checkpoint(0, *engine.start(here, plain), solver, tolerance, curves=True)

    def one(state: Checkpoint, h: float) -> Step | str:
        """A step; why there is none."""
        if by_passes and (found := by_passes(state, h)):
            return found
        if solver == "fixed_point":
            return f"{UNSETTLED}, or the solver auto"
        t, low, e, e_low = state.clock.tolist()
        g = np.full(s, float(rate(state.state[0, : problem.q0.size])))
        power, told.step, settling = np.zeros(s), h, Settling()
        begin = Checkpoint(
            0, state.state, state.stages, state.solver_state, solver, tolerance, curves=True
        )
        for _ in range(PASSES):
            told.t, told.energy = t + (low + h * (within @ g)), e + (e_low + h * (within @ power))
            run, code = solve_steps(INERTIAL, RunRequest(inner, plain, h, 1, begin))
            if code:
                return run.failure(code)
            work = run.work
            curves, index = cast(Curves, run.curves), np.zeros(s, dtype=np.int64)
            places = curves.places(index, table.c)
            new = np.array([float(rate(q.reshape(-1))) for q in places])
            v = curves.velocities(index, table.c) / new[:, None]
            pushes = [force_at(base, q, x, t) for q, x, t in zip(places, v, told.t, strict=True)]
            rows = zip(places, v, told.t, pushes, strict=True)
            new_power = new * np.array([_power(base, *row, h * g[0]) for row in rows])
            size = (abs(e) + abs(float(work.saved_v[-1] @ v[-1].ravel()))) / abs(h)
            change = _change(new, g) + _change(new_power, power, size)
            g, power = new, new_power
            if settling.after(change):
                clock = _later(state.clock, h * float(table.b @ g), h * float(table.b @ power))
                counts = work.counts[:4].astype(np.float64)
                end = replace(
                    begin, state=work.state, stages=work.stages, solver_state=work.solver_state
                )
                return Step(end, curves.coefficients, g, clock, counts)
        return UNSETTLED

    def advance(state: Checkpoint, h: float, n: int, time: float | None, keep: bool) -> Advanced:
        rows: list[Taken] = []
        reason, r, d = "", problem.q0.size, problem.v0.size
        for _ in range(n):
            found = one(state, h)
            if isinstance(found, str):
                reason = found
                break
            if time is not None and (found.clock[0] - time) * h > 0.0:
                break
            state = replace(
                found.end, first=state.first + 1, clock=found.clock, energies=state.energies,
                curves=None,
            )  # fmt: skip
            q, p = state.state[:1, :r], state.state[1:2, :d]
            kept = found.coefficients[: 1 if keep else 0]
            clock = found.clock[None]
            rows.append(
                Taken(q, p, None, clock[:, :2], kept, found.rates[None], found.counts, clock[:, 2])
            )
        code = DIVERGED if reason else SOLVED
        if not rows:
            m = method.space.dimension - 1
            shapes = (0, r), (0, d), (0, 2), (0, d, m), (0, s)
            q, p, t, coefficients, rates = map(np.zeros, shapes)
            none = Taken(q, p, None, t, coefficients, rates, NO_COUNTS, np.zeros(0))
            return Advanced(none, state, code, reason)
        return Advanced(joined(rows), state, code, reason)

    def at(q: Array, v: Array, t: float) -> Checkpoint:
        here = float(base.energy(q.reshape(inner.q0.shape), v.ravel(), t))
        return replace(start(q, v), clock=np.array([t, 0.0, here, 0.0]))

    return Motion(advance, at, rate, chart_of(problem, plain), IN_GENERAL)


def _passes(
    problem: Problem, method: Galerkin, base: Lagrangian, known: Callable[..., Array],
    tolerance: float,
) -> Callable[[Checkpoint, float], Step | None]:  # fmt: skip
    """Steps by fixed-point passes, of a constant mass with Gauss; None where they do not settle.

    known  the slopes of L
    """
    table, system, shape = method.table, cast(Any, problem.system), problem.q0.shape
    rate, slope = method.clock.rate(problem), method.clock.slope(problem)
    d, s, timed = problem.q0.size, method.stages, base.explicit_time
    A, ahead = table.integral.T, (table.extrapolation @ table.analysis[: table.growth.size]).T

    def rates_at(
        q: Array, p: Array, t: float, energy: float, dt: float
    ) -> tuple[float, Array, Array, float]:
        """g, q', p' and E' at one stage."""
        v, g = system.velocity(p.reshape(shape)).ravel(), float(rate(q))
        when = (t,) if timed else ()
        push, fall = force_at(base, q, v, t), np.ravel(known(q, v, *when))[d:]
        excess = float(p @ v) - float(base.function(q, v, *when)) - energy
        return g, g * v, g * (fall + push) - excess * slope(q), g * _power(base, q, v, t, push, dt)

    def step(state: Checkpoint, h: float) -> Step | None:
        start, (t, low, e, e_low) = state.state, state.clock.tolist()
        q, p = start[0, :d, None], start[1, :d, None]
        last = state.solver_state[HOLDS] == LAST_STEP
        ways = state.stages @ ahead if last else state.stages.copy()
        g = np.array([float(rate(x)) for x in (q + h * (ways @ A)).T])
        turns, power, settling = np.zeros((d, s)), np.zeros(s), Settling(tolerance)
        for k in range(PASSES):
            Q, P = q + h * (ways @ A), p + (start[3, :d, None] + h * (turns @ A))
            times, energies = t + (low + h * (g @ A)), e + (e_low + h * (power @ A))
            if not np.all(np.isfinite([Q, P])):
                return None
            rows = zip(Q.T, P.T, times.tolist(), energies.tolist(), strict=True)
            columns = zip(*(rates_at(*row, h * float(g[0])) for row in rows), strict=True)
            found = [np.array(column).T for column in columns]
            twice = np.sum(P * found[1], axis=0) / found[0]  # the kinetic energy
            size = (abs(e) + float(np.max(np.abs(twice)))) / abs(h)
            change = sum(map(_change, found[:3], (g, ways, turns)))
            change += _change(found[3], power, size)
            g, ways, turns, power = found
            counts = (k + 1) * np.array([1.0, s, 0.0, 0.0])
            if settling.after(change):
                break
        else:
            return None
        end = np.zeros(start.shape)
        end[0, :d] = start[0, :d] + h * (ways @ table.b)
        kick = start[3, :d] + h * (turns @ table.b)
        end[1, :d] = start[1, :d] + kick
        end[3, :d] = kick - (end[1, :d] - start[1, :d])
        holds = state.solver_state.copy()
        holds[HOLDS] = LAST_STEP
        clock = _later(state.clock, h * float(table.b @ g), h * float(table.b @ power))
        after = replace(state, state=end, stages=ways, solver_state=holds)
        return Step(after, h * (ways @ table.projection.T)[None], g, clock, counts)

    return step


def _change(new: Array, old: Array, size: float = 0.0) -> float:
    """The largest change, relative to the largest entry or to a larger size."""
    return float(np.max(np.abs(new - old)) / (max(float(np.max(np.abs(new))), size) or 1.0))


class Settling:
    """Whether the passes of a step have settled, from how much each of them changed."""

    def __init__(self, tolerance: float = 0.0) -> None:
        self.least, self.idle, self.enough = np.inf, 0, max(SETTLED, tolerance)

    def after(self, change: float) -> bool:
        """Whether no further pass is needed."""
        self.idle = 0 if change < self.least else self.idle + 1
        self.least = min(change, self.least)
        return self.least <= self.enough or (self.idle >= IDLE and self.least < NOISE)


def _later(clock: Array, since: float, gained: float) -> Array:
    """The time and the energy at a step's end, with their low parts, (4,)."""
    return np.concatenate([added(clock[:2], [since])[0], added(clock[2:], [gained])[0]])


def _inner(
    problem: Problem, base: Lagrangian, clock: Any, told: AtStages,
    known: Callable[..., Array] | None,
) -> Problem:  # fmt: skip
    """The problem in tau, from 0 on in each step; t and E are those told.

    known  the slopes of L, or None
    """
    rate, slope, timed = clock.rate(problem), clock.slope(problem), base.explicit_time
    shape = problem.q0.shape if len(base.group.shape) == 2 else (problem.q0.size,)
    q0, v0 = problem.q0.reshape(shape), problem.v0.ravel()
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


def _power(base: Lagrangian, q: Array, v: Array, t: float, push: Array, dt: float) -> float:
    """F . v - dL/dt at one state; differences over a part of dt."""
    found = float(np.dot(push.ravel(), v.ravel()))
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

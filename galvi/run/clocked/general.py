"""Steps in a clock of any system: those of the Lagrangian g (L(q, q'/g) + E) in tau."""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any, cast

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import AnyClock, Rate
from galvi.curves.curves import Curves, GroupChart, IdentityChart, LocalChart
from galvi.environment import FAST
from galvi.groups.group import Rn
from galvi.kernels.forces.celestial import NUMBERS, OTHER, SOURCE, WEIGHT, pole_pull, power_pull
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.plan import Advanced, Motion, Taken
from galvi.run.general import inertial_formulation
from galvi.run.in_lanes.engine import INERTIAL
from galvi.run.request import RunRequest, from_start
from galvi.run.stepper import Declined, solve_steps
from galvi.systems.canonical import Canonical
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody


@singledispatch
def lagrangian_of(system: Any, problem: Problem) -> Lagrangian:
    """A system as a Lagrangian of flat configurations, or of matrices, without checks."""
    return cast(Lagrangian, system.lagrangian)


@lagrangian_of.register
def _(system: Lagrangian, problem: Problem) -> Lagrangian:
    return system


@lagrangian_of.register
def _(system: Canonical, problem: Problem) -> Lagrangian:
    def L(q: Any, v: Any, *t: Any) -> Any:
        return 0.5 * (v @ system.momentum(v)) - system.potential(q, *t)

    def slopes(q: Any, v: Any, *t: Any) -> Array:
        return np.concatenate([system.momentum(v), -system.potential_gradient(q, *(t or (0.0,)))])

    return Lagrangian(
        L, Rn(problem.q0.size), slopes, system.force, explicit_time=system.explicit_time,
        timed_force=system.timed_force, check=False,
    )  # fmt: skip


@lagrangian_of.register
def _(system: NBody, problem: Problem) -> Lagrangian:
    size, acting = problem.q0.shape[1], system.acting
    masses = np.repeat(system.masses, size)
    n = system.masses.size
    pairs = [(i, j, float(system.G * system.masses[i] * system.masses[j]))
             for i in range(n) for j in range(i + 1, n)]  # fmt: skip

    def L(q: Any, v: Any) -> Any:
        found: Any = 0.5 * (v @ (masses * v))
        for i, j, mass in pairs:
            square: Any = 0.0
            for k in range(size):
                gap = q[i * size + k] - q[j * size + k]
                square = square + gap * gap
            found = found + mass / np.sqrt(square)
        for k, row in enumerate(acting.terms):
            first, second = (int(row[column]) * size for column in (SOURCE, OTHER))
            way: Any = [q[second + x] - q[first + x] for x in range(size)]
            law: Any = pole_pull if k < acting.poles else power_pull
            found = found - row[WEIGHT] * law([*way, 0.0][:3], row[NUMBERS:].tolist())[3]
        return found

    def slopes(q: Any, v: Any) -> Array:
        pull = system.fall(q.reshape(-1, size)).ravel()
        return masses * np.concatenate([v, pull]).reshape(2, -1)

    def force(q: Any, v: Any, t: float) -> Array:
        return masses * acting.rest(q.reshape(-1, size), v.reshape(-1, size), t).ravel()

    return Lagrangian(
        L, Rn(problem.q0.size), lambda q, v: slopes(q, v).ravel(),
        None if acting.conserve else force, timed_force=not acting.conserve, check=False,
    )  # fmt: skip


def in_clock(problem: Problem, clock: AnyClock, energy: float) -> Problem:
    """The problem in tau. Its functions are called, with slopes where these are known, if they
    cannot be traced."""
    base, rate = lagrangian_of(problem.system, problem), clock.rate(problem)
    L, slope = base.function, clock.slope(problem)

    def function(q: Any, u: Any) -> Any:
        g = rate(q.reshape(-1))
        return g * (L(q, u / g) + energy)

    shape = problem.q0.shape if len(base.group.shape) == 2 else (problem.q0.size,)
    q0, u0 = problem.q0.reshape(shape), rate(problem.q0.ravel()) * problem.v0.ravel()
    found = Problem(Lagrangian(function, base.group, check=False), q0, u0, problem.t0)
    if not cast(Lagrangian, found.system).untraced and FAST:
        return found
    known = base.euclidean_slopes(q0, problem.v0.ravel(), problem.t0)
    if known is None:
        return found
    by_chain_rule = slopes_in_clock(base, known, rate, slope)
    system = Lagrangian(
        function, base.group, lambda q, u: by_chain_rule(q, u, energy), check=False
    )  # fmt: skip
    return Problem(system, q0, u0, problem.t0)


def slopes_in_clock(
    base: Lagrangian, known: Callable[..., Array], rate: Rate, slope: Callable[[Array], Array]
) -> Callable[..., Array]:
    """(q, u, E, and the time if L takes it) -> the slopes of g (L(q, u/g) + E) by u and q: dL/dv,
    and g dL/dq - (H - E) dg/dq.

    known  the slopes of L
    """
    d = base.group.dimension

    def slopes(q: Array, u: Array, energy: float, *t: float) -> Array:
        flat = q.reshape(-1)
        g = rate(flat)
        both = np.array(known(q, u / g, *t), dtype=np.float64)
        excess = float(both[:d] @ u) / g - float(base.function(q, u / g, *t)) - energy
        both[d:] = g * both[d:] - excess * slope(flat)
        return both

    return slopes


def motion_in_general(
    problem: Problem, method: Galerkin, energy: float, solver: str, tolerance: float
) -> Motion:
    """The motion of a system that conserves its energy, by the engines of its Lagrangian in tau."""
    clock = cast(AnyClock, method.clock)
    refuse_massless(problem)
    inner = in_clock(problem, clock, energy)
    plain = Galerkin(method.space, method.rule, method.group_chart)
    rate, s = clock.rate(problem), method.stages
    if solver == "fixed_point" and isinstance(_offer(inner, plain, solver), Declined):
        raise ValueError(
            "in this clock the solver fixed_point needs functions that can be traced. Use the "
            "solver auto."
        )

    def rates(curves: Curves, n: int) -> Array:
        index, nodes = np.repeat(np.arange(n), s), np.tile(method.table.c, n)
        places = curves.places(index, nodes).reshape(n * s, problem.q0.size)
        if clock.vectorized:
            return np.asarray(rate(places.T)).reshape(n, s)
        return np.array([float(rate(q)) for q in places]).reshape(n, s)

    def advance(state: Checkpoint, h: float, n: int, time: float | None, keep: bool) -> Advanced:
        begin = Checkpoint(0, state.state, state.stages, state.solver_state, solver, tolerance)
        run, code = solve_steps(INERTIAL, RunRequest(inner, plain, h, n, begin))
        done = run.done
        found = rates(cast(Curves, run.curves), done)
        # One after another: the bits of a product of matrices depend on their sizes.
        t = added(
            state.clock[:2], h * sum(b * g for b, g in zip(method.table.b, found.T, strict=True))
        )
        if time is not None and (past := np.flatnonzero((t[:, 0] - time) * h > 0.0)).size:
            if past[0] == 0:
                return Advanced(_taken(run, found, t, keep, 0), state, SOLVED)
            return advance(state, h, int(past[0]), None, keep)
        end = run.work
        last = t[-1] if done else state.clock[:2]
        after = Checkpoint(
            state.first + done, end.state, end.stages, end.solver_state, solver, tolerance,
            clock=np.append(last, state.clock[2:]),
        )  # fmt: skip
        reason = run.failure(code) if code else ""
        return Advanced(_taken(run, found, t, keep, done), after, code, reason)

    def at(q: Array, v: Array, t: float) -> Checkpoint:
        flat = q.ravel()
        here = Problem(inner.system, q.reshape(inner.q0.shape), rate(flat) * v.ravel(), problem.t0)
        start = inertial_formulation(here, plain).start(here, plain)
        return Checkpoint(0, *start, solver, tolerance, clock=np.array([t, 0.0, energy, 0.0]))

    return Motion(advance, at, rate, chart_of(problem, plain), IN_GENERAL)


IN_GENERAL = "its steps are those of the general kernel, in transformed time"


def _offer(problem: Problem, method: Galerkin, solver: str) -> Any:
    return INERTIAL[0].offers(RunRequest(problem, method, 1.0, 1, from_start(solver)))


def refuse_massless(problem: Problem) -> None:
    """ValueError for point masses some of which have no mass."""
    if isinstance(problem.system, NBody) and problem.system.has_massless:
        raise ValueError(
            "massless bodies have no Lagrangian of their own; in a clock they need lanes: "
            "Polynomials(s) with gauss(s), DynamicalTime(), the solver auto, no tolerance, and no "
            "forces but those with an energy. Use these, or give them small masses."
        )


def chart_of(problem: Problem, method: Galerkin) -> LocalChart:
    """The chart of the curves."""
    group = getattr(problem.system, "group", None)
    if group is None:
        return IdentityChart(problem.q0.shape)
    return GroupChart(group, method.group_chart)


def _taken(run: Any, rates: Array, t: Array, keep: bool, n: int) -> Taken:
    rows, work = slice(1, n + 1), run.work
    coefficients = work.coefficients[: n if keep else 0]
    return Taken(
        work.saved_q[rows], work.saved_v[rows], None, t[:n], coefficients, rates[:n],
        work.counts[:4].astype(np.float64),
    )  # fmt: skip


def added(start: Array, changes: Any) -> Array:
    """(n, 2) sums with their low parts, of a number and its low part (2,) and changes (n,)."""
    found, (total, low) = np.empty((len(changes), 2)), start.tolist()
    for k, change in enumerate(np.asarray(changes).tolist()):
        low += change
        new = total + low
        low -= new - total
        total = new
        found[k] = total, low
    return found

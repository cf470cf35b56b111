"""Steps in a clock, of problems for which it has no lanes: equal steps in transformed time.

With u = dq/dtau, the energy E and an external force F, these are steps of

    L_tau(q, u) = g (L(q, u/g, t) + E), with the force g F,    t' = g,    E' = g (F . v - dL/dt)

Without a force and explicit time E stays as it is, and t is a quadrature of g after the steps,
which are done by the lanes of equal steps where L_tau can be traced, else by the general kernel.
Otherwise the problem is driven: t and E are collocated at the stages. With Gauss s and degree s, or
Lobatto s + 1 and degree s, this is a (partitioned) Runge-Kutta method of order 2 s; other methods
are refused. A step is done by passes until t and E converge; in each pass the kernel solves for the
curve. With Gauss and a constant mass this is the collocation of

    q' = g v,    p' = g (dL/dq + F) - (H - E) dg/dq,    p = M v

so that a pass improves q, p, t and E at once. A step of a driven pendulum is then 2.5 times as
fast, one of the outer planets with drag 50 times.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from itertools import accumulate
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import AnyClock
from galvi.curves.curves import GroupChart, IdentityChart
from galvi.environment import FAST
from galvi.kernels.nystrom.advance import HOLDS, LAST_STEP
from galvi.kernels.nystrom.solve import DIVERGED, GOING, SOLVED, decide
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss, lobatto
from galvi.run.clocked.lagrangians import lagrangian_of
from galvi.run.clocked.motion import NO_COUNTS, Advanced, ClockSteps, Motion, join_steps
from galvi.run.energies import has_no_force
from galvi.run.equal_steps import EQUAL_STEPS
from galvi.run.general import inertial_formulation
from galvi.run.request import RunRequest, from_start
from galvi.run.run_arrays import COUNT_NAMES
from galvi.run.stepper import Declined, solve_steps
from galvi.spaces.polynomials import Polynomials
from galvi.systems.canonical import Canonical
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.forces.external_force import force_at
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.nbody import NBody

STAGE_PASSES = 60  # largest number of passes over the stages of a step
TIME_DIFFERENCE = 2.0**-4  # share of a step in time, by which t is shifted to difference L
UNSETTLED = "the energy and the time at the stages did not settle. Use a smaller step"


class StageClock:
    """Times and energies at the stages of the step that is being solved.

    Parameters
    ----------
    nodes : array, shape (s,)
        nodes of the rule in [0, 1]

    Attributes
    ----------
    values : array, shape (2, s)
        times, energies
    """

    def __init__(self, nodes: Array, t: float, energy: float) -> None:
        self.nodes = nodes
        self.set(np.outer([t, energy], np.ones(nodes.size)), 1.0)

    def set(self, values: Array, step: float) -> None:
        """Set the times and energies (2, s) of a step of length ``step`` in tau."""
        self.values, self.step = values, step

    def at(self, tau: float = 0.0) -> tuple[float, float]:
        """E and t at the stage nearest to a time in tau since the step's start."""
        stage = int(np.argmin(np.abs(self.nodes * self.step - float(tau))))
        return float(self.values[1, stage]), float(self.values[0, stage])


class LagrangianInTau:
    """L_tau, its slopes and its force as functions of (q, u), and of tau where E and t change.

    Attributes
    ----------
    base
        the Lagrangian L
    base_slopes
        its slopes; None where they are not known
    start
        q and u at the start
    """

    def __init__(self, problem: Problem, clock: AnyClock, stages: StageClock) -> None:
        self.base, self.stages = lagrangian_of(problem.system, problem), stages
        self.rate, self.slope = clock.rate(problem), clock.slope(problem)
        q, v = problem.q0.reshape(self.base.group.shape), problem.v0.ravel()
        self.start = q, self.rate(q.reshape(-1)) * v
        self.base_slopes: Any = self.base.euclidean_slopes(q, v, problem.t0)

    def value(self, q: Any, u: Any, *tau: float) -> Any:
        """L_tau."""
        energy, *t = self.stages.at(*tau)[: 1 + self.base.explicit_time]
        g = self.rate(q.reshape(-1))
        return g * (self.base.function(q, u / g, *t) + energy)

    def slopes(self, q: Array, u: Array, *tau: float) -> Array:
        """The derivatives (2 d,) of L_tau: dL/dv with respect to u, g dL/dq - (H - E) dg/dq with
        respect to q."""
        energy, *t = self.stages.at(*tau)[: 1 + self.base.explicit_time]
        flat, d = q.reshape(-1), self.base.group.dimension
        g = self.rate(flat)
        slopes = np.array(self.base_slopes(q, u / g, *t), dtype=np.float64)
        excess = float(slopes[:d] @ u) / g - float(self.base.function(q, u / g, *t)) - energy
        slopes[d:] = g * slopes[d:] - excess * self.slope(flat)
        return slopes

    def force(self, q: Array, u: Array, tau: float) -> Array:
        """g F, (d,)."""
        g = self.rate(q.reshape(-1))
        return np.asarray(g * force_at(self.base, q, u / g, self.stages.at(tau)[1]))

    def by_time(self, q: Array, v: Array, t: float, dt: float) -> float:
        """dL/dt at one state, by differences over a part of dt."""
        if not self.base.explicit_time:
            return 0.0
        L, time_shift = self.base.function, TIME_DIFFERENCE * dt
        ends = [L(q, v, t + k * time_shift) - L(q, v, t - k * time_shift) for k in (1, 2, 3, 4)]
        return float(np.dot(WEIGHTS, ends)) / time_shift


def problem_in_tau(in_tau: LagrangianInTau, driven: bool, t0: float) -> Problem:
    """The problem in tau. It starts at t0, or at 0 in each step where it is driven. Its functions
    are called, with slopes where these are known, if it is driven or they cannot be traced."""
    base, value = in_tau.base, in_tau.value
    if not driven:
        inner = Problem(Lagrangian(value, base.group, check=False), *in_tau.start, t0)
        if (FAST and not cast(Lagrangian, inner.system).untraced) or in_tau.base_slopes is None:
            return inner
    slopes = in_tau.slopes if in_tau.base_slopes is not None else None
    force = in_tau.force if base.force is not None else None
    return Problem(
        Lagrangian(
            value,
            base.group,
            slopes,
            force,
            explicit_time=driven,
            timed_force=force is not None,
            check=False,
        ),
        *in_tau.start,
        0.0 if driven else t0,
    )


class TransformedTime:
    """The motion of a problem in a method's clock, in transformed time.

    Attributes
    ----------
    driven
        whether the energy may change
    stages
        times and energies at the stages; those of the start where the energy does not change
    inner
        the problem in tau
    plain
        the method without its clock
    formulation
        the formulation of that problem and method
    integral : array, shape (s, s)
        for a driven problem, the matrix from values at the stages to the integrals, from 0 to each
        node, of the polynomial through them
    at_once
        whether steps of a driven problem are tried by passes over the whole state first

    Raises
    ------
    ValueError
        For massless bodies, and for a method or solver that is not available in transformed time.
    """

    def __init__(
        self, problem: Problem, method: Galerkin, energy: float, solver: str, tolerance: float
    ) -> None:
        self.driven = not has_no_force(problem.system)
        _refuse(problem, method if self.driven else None)
        if self.driven:
            self.integral = Galerkin(Polynomials(method.stages), method.rule).table.integral
        self.problem, self.energy, self.solver, self.tolerance = problem, energy, solver, tolerance
        clock, self.table = cast(AnyClock, method.clock), method.table
        self.stages = StageClock(self.table.c, problem.t0, energy)
        self.in_tau = LagrangianInTau(problem, clock, self.stages)
        self.rate, self.vectorized = self.in_tau.rate, clock.vectorized
        self.inner = problem_in_tau(self.in_tau, self.driven, problem.t0)
        self.plain = Galerkin(method.space, method.rule, method.group_chart)
        self.formulation = inertial_formulation(self.inner, self.plain)
        has_constant_mass = isinstance(problem.system, Canonical | NBody)
        can_iterate = has_constant_mass and method.rule == gauss(method.stages)
        if not self.driven:
            request = RunRequest(self.inner, self.plain, 1.0, 1, from_start("fixed_point"))
            can_iterate = any(not isinstance(x.offer(request), Declined) for x in EQUAL_STEPS)
        if solver == "fixed_point" and not can_iterate:
            raise ValueError(_no_fixed_point(problem, method, self.driven))
        in_lanes = not self.driven and can_iterate
        engine = "the lanes of equal steps" if in_lanes else "the general kernel"
        self.reason = f"in transformed time, by {engine}"
        self.at_once = can_iterate and solver != "newton"

    def at(self, q: Array, v: Array, t: float) -> Checkpoint:
        """See `Motion.at`."""
        energy, q = self.energy, q.reshape(self.inner.q0.shape)
        if self.driven:
            energy = float(self.in_tau.base.energy(q, v.ravel(), t))
            self.stages.set(np.outer([t, energy], np.ones(self.table.c.size)), 1.0)
        u = self.rate(q.ravel()) * v.ravel()
        moved = Problem(self.inner.system, q, u, self.inner.t0)
        start = self.formulation.initial_state(moved, self.plain)
        clock = np.array([t, 0.0, energy, 0.0])
        return Checkpoint(0, *start, self.solver, self.tolerance, clock=clock)

    def advance(
        self, state: Checkpoint, h: float, n: int, time: float | None, keep: bool
    ) -> Advanced:
        """See `galvi.run.clocked.motion.Advance`."""
        if not self.driven:
            return self._block(state, h, n, time, keep)
        (m, s), r, d = self.table.C.shape, self.problem.q0.size, self.problem.v0.size
        q, p, t, curves, rates = (np.zeros((0, *x)) for x in ((r,), (d,), (2,), (d, m), (s,)))
        none = np.zeros(0)
        steps, reason = [ClockSteps(q, p, None, t, curves, rates, NO_COUNTS, none, none)], ""
        for _ in range(n):
            advanced = self._by_passes(state, h) if self.at_once else UNSETTLED
            if isinstance(advanced, str) and self.solver != "fixed_point":
                advanced = self._by_kernel(state, h)
            if isinstance(advanced, str):
                reason = advanced
                break
            if time is not None and (advanced.after.clock[0] - time) * h > 0.0:
                break
            steps.append(advanced.steps if keep else advanced.steps._replace(coefficients=curves))
            state = advanced.after
        return Advanced(join_steps(steps), state, DIVERGED if reason else SOLVED, reason)

    def _block(
        self, state: Checkpoint, h: float, n: int, time: float | None, keep: bool
    ) -> Advanced:
        """Up to n steps by the engines of equal steps, with t by quadrature and a constant E."""
        begin = state.state, state.stages, state.solver_state
        start = Checkpoint(0, *begin, self.solver, self.tolerance, curves=True)
        stepper, code = solve_steps(EQUAL_STEPS, RunRequest(self.inner, self.plain, h, n, start))
        work = stepper.work
        coefficients = work.coefficients[: work.steps_done]
        curves, stages = self._curves(work.bases[: work.steps_done], coefficients, h)
        rates = self._rates(curves.positions(*stages)).reshape(work.steps_done, self.table.c.size)
        # Summed one by one, since the last bits of a product of matrices depend on their sizes.
        lengths = h * sum(b * g for b, g in zip(self.table.b, rates.T, strict=True))
        t = running_sums(state.clock[:2], lengths)
        steps_past = np.flatnonzero((t[:, 0] - time) * h > 0.0) if time is not None else np.zeros(0)
        if steps_past.size and steps_past[0]:
            return self._block(state, h, int(steps_past[0]), None, keep)
        steps_done = 0 if steps_past.size else work.steps_done
        steps = ClockSteps(
            work.saved_q[1 : steps_done + 1],
            work.saved_moving[1 : steps_done + 1],
            None,
            t[:steps_done],
            coefficients[: steps_done if keep else 0],
            rates[:steps_done],
            NO_COUNTS if steps_past.size else work.counts[: len(COUNT_NAMES)].astype(np.float64),
            state.first + np.arange(1.0, steps_done + 1.0),
        )
        if steps_past.size:
            return Advanced(steps, state, SOLVED)
        after = replace(
            state,
            first=state.first + steps_done,
            state=read_only(work.state),
            stages=read_only(work.stages),
            solver_state=work.solver_state,
            clock=np.append(t[-1] if steps_done else state.clock[:2], state.clock[2:]),
        )
        return Advanced(steps, after, code, stepper.failure(code) if code else "")

    def _by_kernel(self, state: Checkpoint, h: float) -> Advanced | str:
        """One step of a driven problem by passes over y = (t, E), in each of which the engine
        solves for the curve; a sentence on the reason where the step fails."""
        q0, attempts = state.state[:1, : self.problem.q0.size], []

        def slopes(y: Array) -> tuple[Array, float]:
            self.stages.set(y.T, h)
            attempts.append(self._block(state, h, 1, None, True))
            step = attempts[-1].steps
            if attempts[-1].reason:
                return np.full(y.shape, np.nan), 0.0
            curves, stages = self._curves(q0, step.coefficients, h)
            q, g = curves.positions(*stages), step.rates[0]
            v = curves.velocities(*stages) / g[:, None]
            return self._forces_and_rates(q, v, g, h)[1], float(step.p[0] @ v[-1])

        guess = np.outer(np.ones(self.table.c.size), [self._rates(q0)[0], 0.0])
        end = self._collocated(slopes, state.clock.reshape(2, 2).T, guess, h)
        last, after, _, reason = attempts[-1]
        if end is None:
            return reason or UNSETTLED
        clock, counts = end[0].T.ravel(), [attempt.steps.counts for attempt in attempts]
        last = last._replace(t=clock[None, :2], counts=np.sum(counts, axis=0), energy=clock[2:3])
        return Advanced(last, replace(after, clock=clock), SOLVED)

    def _by_passes(self, state: Checkpoint, h: float) -> Advanced | str:
        """One step of a driven problem of constant mass by passes over y = (q, p, t, E); a sentence
        on the reason where the step fails.

        The rows of the state are q, p and their low parts; steps by the kernel have no low part of
        q.
        """
        table, d, clock = self.table, self.problem.v0.size, state.clock.reshape(2, 2).T
        u = state.stages.T
        if state.solver_state[HOLDS] == LAST_STEP:
            u = table.extrapolation @ (table.analysis[: table.growth.size] @ u)
        rates = np.outer(np.ones(len(u)), [self._rates(state.state[0])[0], 0.0])
        guess = np.hstack([u, np.zeros_like(u), rates])
        y = np.hstack([state.state.reshape(2, 2 * d), clock])
        end = self._collocated(partial(self._slopes, h), y, guess, h)
        if end is None:
            return f"{UNSETTLED}, or the solver auto"
        (y, slopes, passes), solver_state = end, state.solver_state.copy()
        arrays, u, solver_state[HOLDS] = y[:, :-2].reshape(4, d), slopes[:, :d].T, LAST_STEP
        after = replace(
            state,
            first=state.first + 1,
            state=arrays,
            stages=u,
            solver_state=solver_state,
            clock=y[:, -2:].T.ravel(),
        )
        steps = ClockSteps(
            arrays[:1],
            arrays[1:2],
            None,
            after.clock[None, :2],
            h * (u @ table.projection.T)[None],
            slopes[None, :, -2],
            passes * np.array([1.0, len(slopes), 0.0, 0.0]),
            np.array([after.first]),
            after.clock[2:3],
        )
        return Advanced(steps, after, SOLVED)

    def _slopes(self, h: float, y: Array) -> tuple[Array, float]:
        """y' (s, 2 d + 2) at the stages of a step of constant mass, and p . v at the last one."""
        d, system = self.problem.v0.size, cast(Any, self.problem.system)
        q, p = y[:, :d], y[:, d:-2]
        self.stages.set(y[:, -2:].T, h)
        v = system.velocity(p.reshape(-1, *self.problem.v0.shape)).reshape(p.shape)
        g = self._rates(q)
        u = g[:, None] * v
        forces, rates = self._forces_and_rates(q, v, g, h)
        rows = zip(q, u, h * self.table.c, strict=True)
        momentum_slopes = np.array([self.in_tau.slopes(*row)[d:] for row in rows])
        return np.hstack([u, momentum_slopes + g[:, None] * forces, rates]), float(p[-1] @ v[-1])

    def _forces_and_rates(self, q: Array, v: Array, g: Array, h: float) -> tuple[Array, Array]:
        """F (s, d), and (t', E') (s, 2), at the stages of a step."""
        in_tau, states = self.in_tau, list(zip(q, v, self.stages.values[0].tolist(), strict=True))
        forces = np.array([force_at(in_tau.base, *state) for state in states])
        by_time = np.array([in_tau.by_time(*state, h * g[0]) for state in states])
        return forces, np.column_stack([g, g * (np.sum(forces * v, axis=1) - by_time)])

    def _collocated(
        self, slopes: Callable[[Array], tuple[Array, float]], y: Array, guess: Array, h: float
    ) -> tuple[Array, Array, int] | None:
        """y (2, k) after a step with its low part, y' (s, k) at the stages, and the number of
        passes; None if the passes do not converge.

        Parameters
        ----------
        slopes
            y (s, k) -> y' (s, k), and p . v at the last stage; the last columns of y are t and E
        y : array, shape (2, k)
            y before the step, and its low part
        guess : array, shape (s, k)
            first guess of y'
        """
        (start, low), slopes_before = y, guess
        history, d = np.array([np.inf, 1.0, np.inf, 0.0]), start.size // 2 - 1
        for passes in range(1, STAGE_PASSES + 1):
            stages = start + (low + h * (self.integral @ slopes_before))
            if not np.all(np.isfinite(stages)):
                return None
            new_slopes, twice_kinetic = slopes(stages)
            size = (abs(start[-1]) + abs(twice_kinetic)) / abs(h)
            parts = (slice(d), 0.0), (slice(d, -2), 0.0), (-2, 0.0), (-1, size)
            change = sum(
                relative_change(new_slopes[:, k], slopes_before[:, k], floor) for k, floor in parts
            )
            code, slopes_before = decide(change, self.tolerance, history), new_slopes
            if code == SOLVED:
                increment = low + h * (self.table.b @ new_slopes)
                end = start + increment
                return np.stack([end, increment - (end - start)]), new_slopes, passes
            if code != GOING:
                break
        return None

    def _curves(self, bases: Array, x: Array, h: float) -> tuple[Any, tuple[Any, Array]]:
        """The curves of steps in tau, and the indices of the steps and fractions of their
        stages."""
        curves = self.formulation.curves(self.inner, self.plain, h, self.inner.t0, bases, x)
        n, c = len(x), self.table.c
        return curves, (np.repeat(np.arange(n), c.size), np.tile(c, n))

    def _rates(self, q: Array) -> Array:
        """g (k,) at configurations (k, ...)."""
        flat = q.reshape(-1, self.problem.q0.size)
        if self.vectorized:
            return np.asarray(self.rate(flat.T))
        return np.array([float(self.rate(row)) for row in flat])


def motion_in_transformed_time(
    problem: Problem, method: Galerkin, energy: float, solver: str, tolerance: float
) -> Motion:
    """The motion of a problem in a method's clock, in transformed time.

    Parameters
    ----------
    energy
        E of the clock
    """
    motion = TransformedTime(problem, method, energy, solver, tolerance)
    group, chart = getattr(problem.system, "group", None), IdentityChart(problem.q0.shape)
    of_curves = chart if group is None else GroupChart(group, method.group_chart)
    return Motion(motion.advance, motion.at, motion.rate, of_curves, motion.reason)


def relative_change(new: Array, last: Array, size: float) -> float:
    """The largest change, relative to the larger of ``size`` and the largest new entry."""
    change, entry = (float(np.max(np.abs(x), initial=0.0)) for x in (new - last, new))
    return change / (max(entry, size) or 1.0)


def running_sums(start: Array, changes: Any) -> Array:
    """The running sums (n, 2), with low parts, of changes (n,) added to a number and its low part
    (2,)."""

    def plus(last: tuple[float, float], change: float) -> tuple[float, float]:
        total, low = last[0], last[1] + change
        return total + low, low - ((total + low) - total)

    sums = accumulate(np.asarray(changes).tolist(), plus, initial=tuple(start.tolist()))
    return np.array(list(sums)[1:]).reshape(-1, 2)


def _refuse(problem: Problem, driven_by: Galerkin | None) -> None:
    """ValueError for point masses some of which are massless, and for a method of a driven problem
    that does not collocate t and E."""
    if isinstance(problem.system, NBody) and problem.system.has_massless:
        raise ValueError(
            "massless bodies have no Lagrangian of their own; in a clock they need lanes: "
            "Polynomials(s) with gauss(s), DynamicalTime(), the solver auto, no tolerance, and no "
            "forces but those with an energy. Use these, or give them small masses."
        )
    if driven_by is None:
        return
    degree = driven_by.space.degree
    collocated = driven_by.rule == gauss(degree) or driven_by.rule == lobatto(degree + 1)
    if not collocated or driven_by.space != Polynomials(degree):
        raise ValueError(
            f"with an external force or explicit time a clock needs Polynomials(s) with gauss(s) "
            f"or lobatto(s + 1), which collocate t and the energy; received {driven_by.name}."
        )


def _no_fixed_point(problem: Problem, method: Galerkin, driven: bool) -> str:
    """The message that refuses fixed-point iteration."""
    if not driven:
        return (
            "in this clock the solver fixed_point needs functions that can be traced. Use the "
            "solver auto."
        )
    return (
        f"with an external force or explicit time the solver fixed_point needs a constant mass "
        f"and gauss(s) in a clock; received a {type(problem.system).__name__} system and "
        f"{method.name}. Use the solver auto."
    )

"""The motion of point masses in a clock, by `galvi.lanes.clocks.advance`."""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Any, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.clocks.clock import DynamicalTime
from galvi.curves.curves import IdentityChart
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.kernels.forces.celestial import WEIGHT
from galvi.kernels.forces.celestial import pulls as pulls_of
from galvi.kernels.nystrom.solve import DIVERGED, NOT_FINITE
from galvi.lanes.clocks.advance import compiled_advance_clock
from galvi.lanes.clocks.rows import COLUMNS, PRODUCT, PRODUCT_LOW
from galvi.lanes.vectors import lanes_for
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.rules.rule import gauss
from galvi.run.clocked.motion import Advanced, ClockSteps, Motion
from galvi.run.in_lanes.tables import aligned, stages_in_lanes, with_low_part
from galvi.run.request import ROUND_OFF
from galvi.run.stepper import Declined
from galvi.spaces.polynomials import Polynomials
from galvi.systems.nbody import NBody
from galvi.tableau import Tableau

MAX_STAGES = 32
REASON = "point masses in galvi.DynamicalTime() have lanes"
# The iteration stops where a further pass would change slopes by less than this, relative to their
# sizes: sixteen times as much makes K = g (H - E0) drift, less only costs passes.
CLOCK_TOLERANCE = 2.0**-56
# Relative changes below this that do not shrink are rounding. In a quarter of all steps the passes
# end in a cycle of two states. Which of these comes last depends on the sign of the guess's error,
# so that K drifts by 2e-17 of g |E0| a step, or as much the other way with one pass more. Their
# mean has no drift, to 3e-18 (docs/why.md, "In a clock").
CLOCK_ROUNDING = 1e-14
FAILURES = {
    DIVERGED: "the iteration did not converge. Use a smaller step",
    NOT_FINITE: "the state became infinite or NaN. Use a smaller step",
}
# Share of the second largest mass below which a body is light: its pairs enter the clock as a given
# function of tau, since its mass would divide the rounding of H - E0 (at 1e-4 up to 3,000 times the
# error, at 1e-9 no step is solved). See galvi.lanes.clocks.advance.
LIGHT = 0.02
CENTRE_AT_REST = 2.0**-20  # share of the largest velocity, up to which the centre counts as at rest


def motion_in_lanes(problem: Problem, method: Galerkin, energy: float | None) -> Motion | Declined:
    """The motion of point masses in `galvi.DynamicalTime`; `Declined` for other problems and
    methods.

    Parameters
    ----------
    energy
        E of the clock; None: the energy at the start, in double-double
    """
    system, s = problem.system, method.stages
    if method.clock != DynamicalTime() or not isinstance(system, NBody) or system.pairs == 0:
        return Declined("the clock's lanes are for point masses in galvi.DynamicalTime()")
    if not system.acting.conserve:
        return Declined("the forces depend on velocities or the time")
    if s > MAX_STAGES or method.space != Polynomials(s) or method.rule != gauss(s):
        return Declined(
            f"the clock's lanes are for Polynomials(s) with gauss(s), s at most {MAX_STAGES}"
        )
    return _motion(problem, method, energy)


@lru_cache(maxsize=32)
def _motion(problem: Problem, method: Galerkin, energy: float | None) -> Motion:
    """`motion_in_lanes`, after its checks."""
    system, s = cast(NBody, problem.system), method.stages
    shape, d, lanes = problem.q0.shape, problem.q0.size, lanes_for(s)
    dimension = shape[1]
    masses = masses_in_clock(system, dimension)
    mean = mean_velocity(system, problem.v0)
    width, m = stages_in_lanes(s, lanes).size, method.space.dimension - 1
    form = (*((0,) * n for n in (dimension, lanes)), s, width)
    kernel = compiled_advance_clock(dimension, lanes)
    gaps = dimension * (len(masses[1]) + len(masses[4]))
    scratch = (8, d, width), (6, width), (4, width), (gaps,), (4,)

    def advance(state: Checkpoint, h: float, n: int, time: float | None, keep: bool) -> Advanced:
        q, stages, clock = state.state.copy(), state.stages.copy(), state.clock.copy()
        solver_state, steps_and_passes = state.solver_state.copy(), np.zeros(2, dtype=np.int64)
        shapes = (n, d), (n, d), (n, 2), (n if keep else 0, d, m), (n, s)
        records: list[Any] = [np.empty(shape) for shape in shapes]
        code = int(kernel(
            form, (*masses, mean), clock_tables(method.table, h, lanes), n,
            np.nan if time is None else time, CLOCK_TOLERANCE, CLOCK_ROUNDING, q, stages,
            solver_state, clock, tuple(aligned(*scratch)), steps_and_passes, tuple(records),
        ))  # fmt: skip
        places, v, t, coefficients, rates = (array[: steps_and_passes[0]] for array in records)
        p = system.momentum(v.reshape(-1, *shape)).reshape(-1, d)
        number = state.first + np.arange(1.0, steps_and_passes[0] + 1.0)
        counts = steps_and_passes[1] * np.array([1.0, s, 0.0, 0.0])
        steps = ClockSteps(places, p, v, t, coefficients, rates, counts, number)
        after = Checkpoint(
            state.first + int(steps_and_passes[0]),
            q,
            stages,
            solver_state,
            state.solver,
            state.tolerance,
            clock=clock,
        )
        return Advanced(steps, after, code, FAILURES.get(code, "") if code else "")

    def single_steps(states: list[Checkpoint], lengths: Array) -> tuple[Array, Array, Array, Any]:
        ends, t, codes = np.empty((2, len(states), d)), np.empty((len(states), 2)), []
        none, scratch_arrays, rates = (
            np.zeros((0, d, m)),
            tuple(aligned(*scratch)),
            np.empty((1, s)),
        )
        for k, (begin, h) in enumerate(zip(states, lengths.tolist(), strict=True)):
            state_copies = begin.state.copy(), begin.stages.copy(), begin.solver_state.copy()
            record = ends[0, k : k + 1], ends[1, k : k + 1], t[k : k + 1], none, rates
            codes.append(kernel(
                form, (*masses, mean), clock_tables(method.table, h, lanes), 1, np.nan,
                CLOCK_TOLERANCE, CLOCK_ROUNDING, *state_copies, begin.clock.copy(), scratch_arrays,
                np.zeros(2, dtype=np.int64), record,
            ))  # fmt: skip
        return ends[0], ends[1], t.sum(axis=1), np.array(codes)

    def at(q: Array, v: Array, t: float) -> Checkpoint:
        state = np.zeros((4, d))
        state[0], state[2] = q.ravel(), v.ravel()
        total = start if energy is None else np.array([energy * system.G, 0.0])
        clock_energy = energy_in_moving_frame(
            total, system.G * system.masses, v.reshape(shape), mean
        )
        clock = np.concatenate([[t, 0.0], clock_energy])
        none = np.zeros((2 * d, s)), np.zeros(3, dtype=np.int64)
        return Checkpoint(0, state, *none, "auto", ROUND_OFF, clock=clock)

    begin = np.zeros((4, *shape))
    begin[0], begin[2] = problem.q0, problem.v0
    start = energy_of(masses, begin)
    rate = method.clock.rate(problem)
    return Motion(advance, at, rate, IdentityChart(shape), REASON, single_steps=single_steps)


def mean_velocity(system: NBody, v: Array) -> Array:
    """The velocity (dimension,) of the centre of mass. Components up to CENTRE_AT_REST of the
    largest velocity are 0: subtracting a number near the last bit of v rounds the same way in every
    step."""
    mean = system.masses @ v / system.masses.sum()
    return read_only(np.where(np.abs(mean) > CENTRE_AT_REST * np.max(np.abs(v)), mean, 0.0))


@lru_cache(maxsize=32)
def masses_in_clock(system: NBody, dimension: int) -> tuple[Array, Any, Any, Array, Array, int]:
    """The masses of a system, and the terms of its forces, as the kernel takes them."""
    M = system.G * system.masses
    first, second = np.triu_indices(M.size, 1)
    enters = M[first] + M[second] > 0.0
    first, second = first[enters], second[enters]
    with extended_precision():
        product, low = with_low_part(decimals(M[first]) * decimals(M[second]))
    sums, heavy = M[first] + M[second], (M > 0.0) & (LIGHT * np.sort(M)[-2] <= M)
    pace_sums = np.where(heavy[first] & heavy[second], sums, 0.0)
    pairs = np.stack([M[second], M[first], product, low, sums, pace_sums], axis=1)
    inverse_masses = np.where(heavy, 1.0 / np.where(heavy, M, 1.0), 0.0)
    starts, seconds = np.searchsorted(first, np.arange(M.size + 1)), dimension * second
    for indices in (seconds, starts):
        indices.setflags(write=False)
    terms, poles = system.acting.terms.copy(), system.acting.poles
    terms[:, WEIGHT] *= system.G
    bodies = read_only(np.stack([0.5 * M, inverse_masses]))
    return read_only(pairs.ravel()), seconds, starts, bodies, read_only(terms), poles


def energy_of(masses: tuple[Array, Any, Any, Array, Array, int], state: Array) -> Array:
    """G times the energy and its low part, from the state (4, bodies, dimension)."""
    pairs, seconds, starts, bodies, terms, poles = masses
    first = np.repeat(np.arange(len(starts) - 1), np.diff(starts))
    second = seconds // state.shape[2]
    with extended_precision():
        q, v = (decimals(state[k]) + decimals(state[k + 1]) for k in (0, 2))
        product, low = pairs.reshape(-1, COLUMNS)[:, PRODUCT : PRODUCT_LOW + 1].T
        squares = np.sum((q[first] - q[second]) ** 2, axis=1)
        pulls = (decimals(product) + decimals(low)) / [square.sqrt() for square in squares]
        acting_energy = decimals(pulls_of(terms, poles, state[0] + state[1])[1])
        return with_low_part(np.sum(decimals(bodies[0]) @ v**2) - np.sum(pulls) + acting_energy)


def energy_in_moving_frame(energy: Array, M: Array, v: Array, mean: Array) -> Array:
    """An energy and its low part in a frame that moves with the velocity ``mean``."""
    if not np.any(mean):
        return energy
    with extended_precision():
        masses, frame = decimals(M), decimals(mean)
        momentum = masses @ decimals(v)
        kinetic = np.sum(masses) * np.sum(frame * frame) / 2
        return with_low_part(np.sum(decimals(energy)) - frame @ momentum + kinetic)


@lru_cache(maxsize=32)
def clock_tables(table: Tableau, step: float, lanes: int) -> tuple[Array, ...]:
    """mu^T, extrapolation, h b and coefficients from slopes, as the kernel takes them."""
    mu, ahead, fit = _tables_without_step(table, lanes)
    parts, s = np.zeros((1, mu.shape[1])), table.c.size
    parts[0, :s] = step * table.b
    parts[0, s // 2] += step - math.fsum(parts[0])
    return mu, ahead, read_only(parts), fit


@lru_cache(maxsize=32)
def _tables_without_step(table: Tableau, lanes: int) -> tuple[Array, ...]:
    """The tables of `clock_tables` that do not depend on the step."""
    s = table.c.size
    mu, extrapolation = (np.zeros((s, stages_in_lanes(s, lanes).size)) for _ in range(2))
    with extended_precision():
        b = decimals(table.b) + decimals(table.low_parts[1])
        exact = rounded((decimals(table.integral) + decimals(table.low_parts[4])) / b)
    larger = np.abs(exact) > np.abs(exact.T)
    mu[:, :s] = np.where(larger, exact, 1.0 - exact.T).T
    mu[np.arange(s), np.arange(s)] = 0.5
    guess = table.extrapolation @ table.analysis[: table.growth.size]
    extrapolation[:, :s] = (table.b[:, None] * guess / table.b).T
    return read_only(mu), read_only(extrapolation), read_only(table.projection / table.b)

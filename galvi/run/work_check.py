"""Judges a run with forces by its energy less their work.

In some steps, the first ones among them, the work is integrated along the step's curve with more
nodes than the rule has. With the rule's own, Gauss's method keeps a quadratic energy less the work
of any force, for any step, as it keeps quadratic invariants: that would say nothing. And between
the watched states the energy may not change by more than forces can have done: AMPLE times the
time by the largest power seen so far in that direction, which for a damper is none upwards.

A difference is measured by the largest of the kinetic energies, the range of the potential energy
and the work of a step, so far. A run is ruined by a step that changes the energy by more than the
steps before, without that work.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.polynomial.legendre import leggauss

from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.kernels.energy_errors import HIGHEST, LOWEST, MEASURE, ROUND_OFF, SMALL, WORST
from galvi.problem import Problem, WithFunctions
from galvi.run.energies import (
    States,
    energies,
    kick_energy,
    noise,
    start_energies,
    working_force,
)
from galvi.run.energy_check import (
    Judgement,
    near_velocities,
    raised_at,
    states_of,
    steps_of,
    watched_rows,
)
from galvi.run.plan import NEVER, Engine, Run, RunArrays
from galvi.run.singular_mass import BALL_JOINT, SINGULAR, is_singular
from galvi.systems.lagrangian import Lagrangian, velocity_at
from galvi.systems.multibody import Multibody
from galvi.tableau import Tableau
from galvi.trajectory import Trajectory

AMPLE = 4.0
LOOKED_AT, BEGIN, STATES = 10, 2, 64  # steps, the first of them, watched states
LITTLE = 1e-3
MORE = 3  # nodes more than a method's rule has
FAST, SHORT = 4, 2.0**-6  # steps in which fast damping is sought, and a step that resolves it
Redo = Callable[[Run], Trajectory]


class Change(NamedTuple):
    """What a step, or all steps up to a state, did.

    step       number of the (last) step
    kinetic    (2,) at its ends, for a state twice its own
    potential  (2,)
    work       of a step's forces; else 0
    error      of the energy less the work
    ruining    the part of it that no error of the work explains
    """

    step: int
    kinetic: Array
    potential: Array
    work: float
    error: float
    ruining: float


def has_work(system: Any) -> bool:
    """Whether a system has forces whose work is known: not those on point masses."""
    if not isinstance(system, WithFunctions) or system.explicit_time:
        return False
    return working_force(system) is not None


def judge_work(engine: Engine, run: Run, work: RunArrays, redo: Redo) -> Judgement:
    """The judgement of a run so far, with forces that do work.

    redo  does a run of one step again
    """
    energies_so_far = run.start.energies
    if work.done == 0 or work.watch == NEVER:
        return Judgement(energies=energies_so_far)
    with np.errstate(all="ignore"):
        try:
            states = _watched(engine, run, work)
            steps = _steps(engine, run, work, states, redo)
            powers = _powers_along(run, steps)
            changes = [*_of_steps(run, steps, powers), *_of_states(run, work, states, powers)]
            found, worst = _judged(run, sorted(changes, key=lambda change: change.step))
            fast = undamped(engine, run, steps, states, redo)
        except Exception as error:  # of a user's function
            return Judgement(energies=energies_so_far, unjudged=raised_at(error, work.done))
        return _explained(run, found, worst, fast, states)


class Steps(NamedTuple):
    """Some steps, n of them, and their curves at m nodes.

    numbers      (n,) since the problem's start
    t            (n,) times at which they begin
    begins, ends states there, with the velocities of their momenta, from which those of a stiff
                 step's curve are far
    q, v         (n, m, ...) and (n, m, d) along the curves
    """

    numbers: Any
    t: Array
    begins: States
    ends: States
    q: Array
    v: Array


def _steps(engine: Engine, run: Run, work: RunArrays, states: States, redo: Redo) -> Steps:
    """Some steps: of curves that were kept, or done again from watched states."""
    problem, start, tau = run.problem, run.start, 0.5 * (_nodes(run.method.stages)[0] + 1.0)
    if start.keeps_curves and start.save_every == 1:
        begin = run.begin
        curves = engine.curves(problem, run.method, run.step, begin, work.bases, work.coefficients)
        few = _some(work.done)
        numbers, index = start.first + few, np.repeat(few, tau.size)
        q, v = (
            curves.places(index, np.tile(tau, few.size)),
            curves.velocities(index, np.tile(tau, few.size)),
        )
        rows = np.hstack([work.saved_q, work.saved_v])
        sides = [states_of(engine, problem, rows[few + k]) for k in range(2)]
    else:
        known = np.append(start.first, steps_of(start, work)[:-1])
        few = _some(known.size)
        again = [_again(engine, run, states, known, k, redo) for k in few.tolist()]
        done = [k for k, one in enumerate(again) if one.success and one.curves is not None]
        numbers, runs = known[few[done]], [again[k] for k in done]
        index = np.zeros(tau.size, dtype=np.intp)
        q, v = (
            np.concatenate([getattr(one.curves, part)(index, tau) for one in runs])
            for part in ("places", "velocities")
        )
        sides = [
            States(*(np.stack([part[k] for part in parts]) for parts in (
                [one.q for one in runs], [one.p for one in runs],
                [one.p.reshape(2, -1) for one in runs], [one.t for one in runs],
            )))
            for k in range(2)
        ]  # fmt: skip
    n, times = len(numbers), problem.t0 + numbers * run.step
    v = v.reshape(n, tau.size, -1)
    near = [v[:, 0], v[:, -1]]
    begins, ends = (
        side._replace(v=_velocities(problem, side, one, times))
        for side, one in zip(sides, near, strict=True)
    )
    return Steps(numbers + 1, times, begins, ends, q.reshape(n, tau.size, *problem.q0.shape), v)


def _again(engine: Engine, run: Run, states: States, known: Any, k: int, redo: Redo) -> Trajectory:
    """The step from a watched state."""
    q, v = states.q[k], states.v[k].reshape(run.problem.v0.shape)
    t = run.problem.t0 + int(known[k]) * run.step
    return _one_step(engine, run, run.problem.moved(q, v, t), run.step, True, redo)


def _velocities(problem: Problem, states: States, near: Array, t: Array) -> Array:
    """The velocities (n, d) of momenta, each near one."""
    system = problem.system
    if not isinstance(system, Lagrangian):
        return system.velocity(states.p).reshape(near.shape)
    if isinstance(system, Multibody):
        pairs = zip(states.q, states.p, strict=True)
        return np.stack([np.linalg.solve(system.tree.mass(q), p) for q, p in pairs])
    rows = zip(states.q, states.p, t, near, strict=True)
    return np.stack([system.velocity(p, q, s, v) for q, p, s, v in rows])


@lru_cache(maxsize=32)
def _nodes(stages: int) -> tuple[Array, Array]:
    """Nodes in (-1, 1) and weights of a finer rule than a method's."""
    nodes, weights = leggauss(stages + MORE)
    return read_only(nodes), read_only(weights)


def _one_step(
    engine: Engine, run: Run, here: Problem, step: float, curves: bool, redo: Redo
) -> Trajectory:
    begin = engine.start(here, run.method)
    start = Checkpoint(0, *begin, "auto", run.start.tolerance, save_every=1, curves=curves)
    return redo(Run(here, run.method, step, 1, start))


def _some(n: int) -> Any:
    """Numbers below n, the first ones among them."""
    spread = np.linspace(0, n - 1, LOOKED_AT - BEGIN).astype(np.int64)
    return np.unique(np.append(np.arange(min(n, BEGIN)), spread))


def _watched(engine: Engine, run: Run, work: RunArrays) -> States:
    """The state at the begin of a run, and the watched ones."""
    problem, r, d = run.problem, run.problem.q0.size, run.problem.v0.size
    state, rows = run.start.state, watched_rows(engine, run, work)
    first = np.concatenate([state[0, :r], state[engine.velocity_row, :d]])
    seen = states_of(engine, problem, np.vstack([first, rows[:, : r + d]]))
    if isinstance(problem.system, Lagrangian):
        near = near_velocities(problem, run.method, rows)
        v = problem.system.velocity(seen.p[0], seen.q[0], problem.t0, near[0])
        seen = seen._replace(v=np.vstack([v, near]))
    return seen


def _powers_along(run: Run, steps: Steps) -> Array:
    """The powers (n, m) of the forces along the steps' curves."""
    tau = 0.5 * (_nodes(run.method.stages)[0] + 1.0)
    times = steps.t[:, None] + tau * run.step
    flat = steps.q.reshape(-1, *run.problem.q0.shape), steps.v.reshape(times.size, -1)
    return _powers(run.problem, *flat, times.ravel()).reshape(times.shape)


def _of_steps(run: Run, steps: Steps, powers: Array) -> Iterator[Change]:
    """What steps did, by the work along their curves."""
    work = powers @ (0.5 * run.step * _nodes(run.method.stages)[1])
    kinetic, potential = (
        np.stack(sides, axis=1)
        for sides in zip(
            *(energies(run.problem, side, forces=True) for side in (steps.begins, steps.ends)),
            strict=True,
        )
    )
    for k, number in enumerate(steps.numbers.tolist()):
        gained = float(np.diff(kinetic[k])[0] + np.diff(potential[k])[0])
        error = abs(gained - work[k])
        yield Change(number, kinetic[k], potential[k], work[k], error, min(error, abs(gained)))


def _of_states(run: Run, work: RunArrays, states: States, along: Array) -> Iterator[Change]:
    """By how much the energies at watched states differ from that at the begin, without what the
    forces can have done, by the powers there and ``along`` some steps."""
    problem, start = run.problem, run.start
    numbers = np.append(start.first, steps_of(start, work))
    few = np.unique(np.linspace(0, len(numbers) - 1, STATES).astype(np.int64))
    states, numbers = States(*(part[few] for part in states)), numbers[few]
    times = problem.t0 + numbers * run.step
    sign = np.sign(run.step)
    powers, along = sign * _powers(problem, states.q, states.v, times), sign * along
    kinetic, potential = energies(problem, states, forces=True)
    total, lasted = kinetic + potential, np.abs(times - times[0])
    can_gain, can_lose = (
        AMPLE * lasted * np.maximum.accumulate(np.maximum(here, np.max(there, initial=0.0)))
        for here, there in ((powers, along), (-powers, -along))
    )
    changed = total - total[0]
    errors = np.maximum(np.maximum(changed - can_gain, -changed - can_lose), 0.0)
    for k in range(1, len(numbers)):
        error = float(errors[k])
        twice = np.repeat(kinetic[k], 2), np.repeat(potential[k], 2)
        yield Change(int(numbers[k]), *twice, 0.0, error, error)


def _powers(problem: Problem, q: Array, v: Array, t: Array) -> Array:
    """The power (n,) of the forces that have no potential, at n states."""
    shaped = v.reshape(len(v), *problem.v0.shape)
    rows = zip(q, shaped, t, strict=True)
    return np.array([np.sum(force_on(problem.system, x, w, s) * w) for x, w, s in rows])


def force_on(system: Any, q: Array, v: Array, t: float) -> Array:
    """The force without potential at one state, of the shape of v."""
    force = working_force(system)
    found = force(q, v, float(t)) if system.timed_force else force(q, v)
    return np.asarray(found, dtype=np.float64).reshape(v.shape)


def _judged(run: Run, changes: list[Change]) -> tuple[Judgement, int]:
    """The judgement of all changes, in order, and the step of the largest one."""
    so_far, start = run.start.energies, start_energies(run.problem, forces=True)
    known = (so_far if so_far.size else start.fresh).copy()
    measure, ruined, share, worst, at = float(known[MEASURE]), None, 0.0, 0.0, 0
    floor, kick = -1.0, -1.0
    for change in changes:
        known[LOWEST] = min(known[LOWEST], *change.potential)
        known[HIGHEST] = max(known[HIGHEST], *change.potential)
        sizes = *np.abs(change.kinetic), known[HIGHEST] - known[LOWEST], abs(change.work)
        largest, error = float(max(measure, *sizes)), change.error
        if error > max(ROUND_OFF * float(np.sum(sizes)), SMALL * largest):
            if floor < 0.0:
                floor, kick = noise(run.problem), _kick(run)
            error = 0.0 if error <= floor else error
        if not error > SMALL * largest:
            measure = max(measure, largest)
        elif ruined is None and not change.ruining <= max(measure, kick):
            ruined = change.step
        if largest > 0.0 and error / largest > share:
            share, worst, at = error / largest, error, change.step
    if known[WORST] > known[MEASURE] > 0.0:  # before this run
        ruined = 0
    known[MEASURE], known[WORST] = measure, max(worst, float(known[WORST]))
    unknown = any(np.isnan(change.error) for change in changes)
    return Judgement(share, measure, ruined, unknown, read_only(known)), at


def _kick(run: Run) -> float:
    """The kinetic energy that the forces at the start, and the potential, give in a step at rest:
    a coarse step from there may err by as much."""
    problem, system = run.problem, cast(Any, run.problem.system)
    q, v, t = problem.q0, problem.v0, problem.t0
    force = force_on(system, q, v, t)
    rate = np.linalg.solve(_mass(problem, q, v, t), np.ravel(force)).reshape(v.shape)
    return 0.5 * run.step**2 * float(np.sum(force * rate)) + kick_energy(problem, run.step)


def _explained(
    run: Run, found: Judgement, worst: int, fast: Undamped | None, states: States
) -> Judgement:
    """A judgement in words, with what is fast or singular."""
    before, clauses, remedy = run.start.first - run.before, [], ""
    if found.error > SMALL:
        clauses.append(
            f"in step {worst - before} the energy and the work of the forces differ by "
            f"{found.error:.2g} of the largest energy so far"
        )
    if fast is not None:
        clauses.append(
            f"damping is {abs(run.step) * fast.rate:,.0f} times as fast as a step, which leaves "
            f"velocities off by about {fast.share:.1g} of the largest in step {fast.step - before}"
        )
        remedy = f"Use a step of {run.method.stages / fast.rate:.1g} or less"
    also = SINGULAR if clauses and is_singular(run.problem, states.q) else ""
    error = max(found.error, fast.share if fast is not None else 0.0)
    remedy = BALL_JOINT if also else remedy
    return found._replace(error=error, off="; ".join(clauses), also=also, remedy=remedy)


class Undamped(NamedTuple):
    """Velocities that are faster damped than a step resolves.

    rate   the largest rate of the damping
    share  about the error of a velocity after a step, over its largest in the run, or LITTLE of
           that with all kinetic energy
    step   number of that step
    """

    rate: float
    share: float
    step: int


def undamped(engine: Engine, run: Run, steps: Steps, states: States, redo: Redo) -> Undamped | None:
    """Velocities that a method leaves where damping takes them within a step; None where they are
    not excited.

    Near a state v' = -M^-1 D (v - w), D = -df/dv. Modes of a rate r with h r above the number of
    stages are not resolved: their part of v - w changes by R(-h r), see ``growth``, and not by
    exp(-h r). It is that of -v' / r, from a step that resolves it.
    """
    problem, found, h = run.problem, None, abs(run.step)
    system: Any = problem.system
    largest, fastest = (
        np.max(np.abs(energies(problem, states)[0])),
        np.max(np.abs(states.v), axis=0),
    )
    few: Any = np.unique(np.linspace(0, len(steps.t) - 1, FAST).astype(np.int64))
    for k in few if len(steps.t) else ():
        t, q, v = steps.t[k], steps.begins.q[k], steps.begins.v[k].reshape(problem.v0.shape)
        rates, modes = damping_rates(problem, q, v, t)
        fast = h * rates > run.method.stages
        if not fast.any():
            continue
        rate = float(rates.max())
        here, short = problem.moved(q, v, t), math.copysign(SHORT / rate, run.step)
        after = _one_step(engine, run, here, short, False, redo)
        there = velocity_at(system, after.q[-1], after.p[-1], t, v.ravel())
        parts = np.linalg.solve(modes, np.ravel(v - there) / short)
        left = [growth(run.method.table, h * r) - math.exp(-h * r) for r in rates[fast]]
        off = np.real(modes[:, fast] @ (left * parts[fast] / rates[fast]))
        alone = np.sqrt(2.0 * largest / np.diag(_mass(problem, q, v, t)))
        share = float(np.max(np.abs(off) / np.maximum(fastest, LITTLE * alone)))
        if share > SMALL and (found is None or share > found.share):
            found = Undamped(rate, share, int(steps.numbers[k]))
    return found


def damping_rates(problem: Problem, q: Array, v: Array, t: float) -> tuple[Array, Array]:
    """The rates (d,) at which forces damp velocities at a state, and their modes, as columns: those
    of M^-1 D, D = -df/dv."""
    system = problem.system
    n, size = v.size, float(np.max(np.abs(v))) or 1.0
    damping = np.empty((n, n))
    for k in range(n):
        nudge = np.zeros(n)
        nudge[k] = 2.0**-10 * size
        ahead, behind = (
            force_on(system, q, v + sign * nudge.reshape(v.shape), t) for sign in (1.0, -1.0)
        )
        damping[:, k] = np.ravel(behind - ahead) / (2.0 * nudge[k])
    rates = np.linalg.solve(_mass(problem, q, v, t), damping)
    if not np.isfinite(rates).all():
        return np.zeros(n), np.eye(n)
    values, modes = np.linalg.eig(rates)
    return values.real, modes


def _mass(problem: Problem, q: Array, v: Array, t: float) -> Array:
    """The mass matrix (d, d) at a state."""
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        return system.mass(q, v, t)
    return system.momentum(np.eye(v.size).reshape(-1, *v.shape)).reshape(v.size, v.size).T


def growth(table: Tableau, z: float) -> float:
    """R(-z): by what a step multiplies a velocity that is damped at the rate z / h."""
    b, psi, slope, end = table.b, table.psi, table.slope, table.end
    matrix = (slope - z * psi).T @ (b[:, None] * slope) + z * np.outer(end, b @ slope)
    y = np.linalg.solve(matrix, end)
    return float(1.0 - z * (b @ slope @ y))

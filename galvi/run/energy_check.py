"""Judges a run by its energy, which every system conserves whose forces have a potential.

The measure of an error is the larger of the kinetic energy at the start and the range of the
potential energy over the steps up to the last good one, whose error is below 1 % of that measure.
So a fall of any depth is measured by its depth, but a run that goes astray not by where it went: a
step whose error exceeds the measure of the steps before it is not good. If no step is good and the
run starts at rest, the measure is the kinetic energy that the force at the start gives in a step,
or the potential energy that is lost on that way if it is less, since a coarse step may come to rest
again. A run is ruined by steps whose error exceeds its measure. What a change of the position by
its round-off would do to the energy is not an error.

Energies are evaluated at each step of up to 127, at 16 to 2047 evenly spread steps of a longer run,
whichever states it keeps, and at its end; where a run is ruined, also at the kept states
before that. An error that comes and goes between two of these steps is not seen.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array, read_only
from galvi.checkpoint import NOTHING, Checkpoint
from galvi.kernels.energy_errors import SMALL, energy_errors
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.energies import (
    Raised,
    States,
    conserves_energy,
    energies,
    kick_energy,
    noise,
    start_energies,
    velocities_at_the_end,
)
from galvi.run.gimbal_lock import BALL_JOINT, LOCKED, is_locked
from galvi.run.request import RunRequest
from galvi.run.run_arrays import NEVER, RunArrays
from galvi.run.stepper import Formulation
from galvi.systems.lagrangian import Lagrangian

VELOCITIES = 2  # the row of the state that has them
REST = 1e-9  # share of what a step gives below which a kinetic energy is none


class Judgement(NamedTuple):
    """What the energies say of a run.

    error     largest error of the energy so far, over its measure
    measure   that measure
    ruined    number, since the problem's start, of the first step seen to be ruined; None: none is
    unknown   whether the energy is not a number at some step; if it was one at the start, such a
              step is ruined
    energies  (4,) of the steps so far, for `Checkpoint`: least and greatest potential energy,
              measure, largest error
    unjudged  why the energy of some steps is not known, as a clause; "" where that of all is
    said      what else is wrong, in clauses, and the remedy; "": that of `galvi.run.status`
    """

    error: float = 0.0
    measure: float = 0.0
    ruined: int | None = None
    unknown: bool = False
    energies: Array = NOTHING
    unjudged: str = ""
    said: tuple[str, ...] = ()
    remedy: str = ""


def judge(engine: Formulation, run: RunRequest, work: RunArrays) -> Judgement:
    """The judgement of a run so far; nothing of a system that does not conserve its energy.

    Steps at which the user's functions raise are left out, and ``unjudged`` names the first one.
    """
    problem, start = run.problem, run.start
    if work.done == 0 or work.watch == NEVER or not conserves_energy(problem.system):
        return Judgement(energies=start.energies)
    with np.errstate(all="ignore"):
        try:
            energy, kinetic, fresh = start_energies(problem, forces=True)
        except Exception as error:
            return Judgement(energies=start.energies, unjudged=raised_at(error, problem.t0))
        known = (energy, kinetic, start.energies if start.energies.size else fresh)
        found = _judged(engine, run, work, watched_rows(engine, run, work), known)
        locked = is_locked(problem, *saved_states(engine, run, work), run.step)
        return found._replace(said=(LOCKED,), remedy=BALL_JOINT) if locked else found


def _judged(
    engine: Formulation,
    run: RunRequest,
    work: RunArrays,
    rows: Array,
    known: tuple[float, float, Array],
) -> Judgement:
    """As ``judge``, in full, of the states ``rows``."""
    problem, start = run.problem, run.start
    steps, seen = steps_of(start, work), states_of(engine, problem, rows)
    if isinstance(problem.system, Lagrangian):
        seen = seen._replace(v=near_velocities(problem, run.method, rows))

    def judged(sharp: bool, floor: float = 0.0, kick: float = 0.0) -> Judgement:
        raised: Raised = {}
        kinetic, potential = energies(problem, seen, sharp, raised, forces=True)
        if not raised:
            return judgement(steps, kinetic, potential, *known, floor, kick)
        told = np.array([k for k in range(len(steps)) if k not in raised], dtype=np.int64)
        found = Judgement(energies=start.energies)
        if told.size:
            found = judgement(steps[told], kinetic[told], potential[told], *known, floor, kick)
        first = min(raised)
        time = problem.t0 + int(steps[first]) * run.step
        return found._replace(unjudged=raised_at(raised[first], time))

    found = judged(False)
    if found.error <= SMALL and not found.unknown:
        return found
    try:
        floor, kick = noise(problem), kick_energy(problem, run.step)
    except Exception as error:
        return Judgement(energies=start.energies, unjudged=raised_at(error, problem.t0))
    found = judged(True, floor, kick)
    if found.ruined is None or found.ruined <= start.first:
        return found
    kept_steps, kept = _kept_before(engine, run, work, found.ruined, steps, seen)
    if len(kept_steps) == 0:
        return found
    limit = max(found.measure, floor)
    off = np.abs(
        np.sum(energies(problem, kept, sharp=True, raised={}, forces=True), axis=0) - known[0]
    )
    first = kept_steps[off > limit]
    earliest = int(first[0]) if first.size else found.ruined
    return found._replace(ruined=earliest)


def raised_at(error: Exception, time: float) -> str:
    return f"at t = {time:.10g}, where it raised {in_words(error)}"


def in_words(error: Exception) -> str:
    """The kind of an exception, and its message on one line."""
    reason = " ".join(str(error).split())
    return f"{type(error).__name__}{': ' if reason else ''}{reason}"


def judgement(
    steps: Array, kinetic: Array, potential: Array, energy: float, kinetic_at_start: float,
    so_far: Array, floor: float = 0.0, kick: float = 0.0,
) -> Judgement:  # fmt: skip
    """The judgement of T and V at ``steps``, (n,) each, after the steps ``so_far``.

    energy  that of the start
    floor   errors up to which are round-off
    kick    kinetic energy that the force at the start gives in a step
    """
    known, error = so_far.copy(), np.empty(len(kinetic))
    largest = energy_errors(
        np.ascontiguousarray(kinetic), np.ascontiguousarray(potential), energy, kinetic_at_start,
        floor, known, error,
    )  # fmt: skip
    lowest, highest, measure, worst = known.tolist()
    record = measure
    if measure <= kinetic_at_start <= REST * kick:
        measure = kick
    first = None
    if not largest <= measure:
        ruined = steps[(error > measure) | (np.isnan(error) & np.isfinite(energy))]
        first = int(ruined[0]) if ruined.size else None
    if worst > measure:
        first = 0
    worst = largest if largest > worst else float(np.fmax(np.fmax.reduce(error), worst))
    share = 0.0 if worst == 0.0 else worst / measure if measure > 0.0 else np.inf
    kept = read_only(np.array([lowest, highest, record, worst]))
    return Judgement(share, measure, first, math.isnan(largest), kept)


def saved_states(engine: Formulation, run: RunRequest, work: RunArrays) -> tuple[Array, Array]:
    """The saved configurations (n, ...) and momenta."""
    shape = (-1, *run.problem.q0.shape)
    return work.saved_q.reshape(shape), engine.momenta(run.problem, work.saved_v)


def watched_rows(engine: Formulation, run: RunRequest, work: RunArrays) -> Array:
    """The watched rows, and the last state in the row after them."""
    first, r, d = run.start.first, run.problem.q0.size, run.problem.v0.size
    last = first + work.done
    n = (last >> work.watch) - (first >> work.watch)
    if n == 0 or last & ((1 << work.watch) - 1) != 0:
        row = work.seen[n]
        row[:r], row[r : r + d] = work.state[0, :r], work.state[engine.velocity_row, :d]
        if row.size > r + d:
            row[r + d :] = work.stages.ravel()
        n += 1
    return work.seen[:n]


def near_velocities(problem: Problem, method: Galerkin, seen: Array) -> Array:
    """Velocities (n, d) of a Lagrangian at the ends of the steps, from those at the stages."""
    d = problem.v0.size
    stages = seen[:, problem.q0.size + d :].reshape(len(seen), d, method.stages)
    return velocities_at_the_end(method.table, stages)


def steps_of(start: Checkpoint, work: RunArrays) -> Any:
    """The numbers of the steps of ``watched_rows``, since the problem's start."""
    last = start.first + work.done
    steps = np.arange((start.first >> work.watch) + 1, (last >> work.watch) + 1) << work.watch
    return steps if len(steps) and steps[-1] == last else np.append(steps, last)


def _kept_before(
    engine: Formulation, run: RunRequest, work: RunArrays, ruined: int, steps: Any, seen: States
) -> tuple[Any, States]:
    """The kept states between the last seen one before step ``ruined`` and that one, and their
    steps."""
    problem, start = run.problem, run.start
    before = max([start.first, *steps[steps < ruined].tolist()])
    kept = start.first + work.saved_steps
    rows = np.flatnonzero((kept > before) & (kept <= min(ruined, start.first + work.done)))
    states = states_of(engine, problem, np.hstack([work.saved_q[rows], work.saved_v[rows]]))
    if isinstance(problem.system, Lagrangian):
        near = np.broadcast_to(seen.v[steps == ruined], (len(rows), problem.v0.size))
        states = states._replace(v=near)
    return kept[rows], states


def states_of(engine: Formulation, problem: Problem, rows: Array) -> States:
    """The states of rows (n, r + d or more), without the velocities of a Lagrangian."""
    n, r, d = len(rows), problem.q0.size, problem.v0.size
    v = rows[:, r : r + d]
    p = engine.momenta(problem, v)
    if engine.velocity_row != VELOCITIES and not isinstance(problem.system, Lagrangian):
        v = problem.system.velocity(p)
    return States(rows[:, :r].reshape(n, *problem.q0.shape), p, v, np.full(n, problem.t0))

"""Judges a run by its energy, which every system without driving and damping conserves.

The measure of an error is the larger of the kinetic energy at the start and the range of the
potential energy over the steps up to the last good one, whose error is below 1 % of that measure.
So a fall of any depth is measured by its depth, but a run that goes astray not by where it went: a
step whose error exceeds the measure of the steps before it is not good. If no step is good and the
run starts at rest, the measure is the kinetic energy that the force at the start gives in a step,
since a coarse step may come to rest again. A run is ruined by steps whose error exceeds its
measure. What a change of the position by its round-off would do to the energy is not an error.

Energies are evaluated at each step of up to 127, at 16 to 2000 evenly spread steps of a longer run,
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
from galvi.run.engine import Engine
from galvi.run.run_arrays import NEVER, RunArrays
from galvi.systems.lagrangian import Lagrangian

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
    """

    error: float = 0.0
    measure: float = 0.0
    ruined: int | None = None
    unknown: bool = False
    energies: Array = NOTHING
    unjudged: str = ""


@np.errstate(all="ignore")
def judge(
    engine: Engine, problem: Problem, method: Galerkin, step: float, start: Checkpoint,
    work: RunArrays,
) -> Judgement:  # fmt: skip
    """The judgement of a run so far; nothing of a system that does not conserve its energy.

    Steps at which the user's functions raise are left out, and ``unjudged`` names the first one.
    """
    if work.done == 0 or work.watch == NEVER or not conserves_energy(problem.system):
        return Judgement(energies=start.energies)
    seen = _seen(engine, problem, method, step, start, work)
    try:
        kinetic, potential = start_energies(problem)
    except Exception as error:
        return Judgement(energies=start.energies, unjudged=_raised(error, 0))
    so_far = start.energies
    if so_far.size == 0:
        so_far = np.array([potential, potential, abs(kinetic), 0.0])
    known = (kinetic + potential, abs(kinetic))

    def judged(sharp: bool, *limits: float) -> Judgement:
        raised: Raised = {}
        states = (seen.steps, *energies(problem, seen, sharp, raised))
        if not raised:
            return judgement(*states, *known, so_far, *limits)
        told = np.array([k for k in range(len(seen.steps)) if k not in raised], dtype=np.int64)
        found = Judgement(energies=start.energies)
        if told.size:
            steps, kinetic, potential = (each[told] for each in states)
            found = judgement(steps, kinetic, potential, *known, so_far, *limits)
        first = min(raised)
        step = int(seen.steps[first]) - start.first
        return found._replace(unjudged=_raised(raised[first], step))

    found = judged(False)
    if found.error <= SMALL and not found.unknown:
        return found
    try:
        floor, kick = noise(problem), kick_energy(problem, step)
    except Exception as error:
        return Judgement(energies=start.energies, unjudged=_raised(error, 0))
    found = judged(True, floor, kick)
    if found.ruined is None or found.ruined <= start.first:
        return found
    kept = _kept_before(engine, problem, method, step, start, work, found.ruined, seen)
    if len(kept.steps) == 0:
        return found
    limit = max(found.measure, floor)
    off = np.abs(np.sum(energies(problem, kept, sharp=True, raised={}), axis=0) - known[0])
    first = kept.steps[off > limit]
    earliest = int(first[0]) if first.size else found.ruined
    return found._replace(ruined=earliest)


def _raised(error: Exception, step: int) -> str:
    reason = " ".join(str(error).split())
    kind = type(error).__name__
    return f"at step {step}, where it raised {kind}{': ' if reason else ''}{reason}"


def judgement(
    steps: Array, kinetic: Array, potential: Array, energy: float, kinetic_at_start: float,
    so_far: Array, floor: float = 0.0, kick: float = 0.0,
) -> Judgement:  # fmt: skip
    """The judgement of T and V at ``steps``, (n,) each, after the steps ``so_far``.

    energy  that of the start
    floor   errors up to which are round-off
    kick    kinetic energy that the force at the start gives in a step
    """
    known, error = so_far.copy(), np.empty(len(steps))
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


def _seen(
    engine: Engine, problem: Problem, method: Galerkin, step: float, start: Checkpoint,
    work: RunArrays,
) -> States:  # fmt: skip
    """The watched states and the last one."""
    last = start.first + work.done
    first, end = (start.first >> work.watch) + 1, (last >> work.watch) + 1
    steps, r, d = np.arange(first, end) << work.watch, problem.q0.size, problem.v0.size
    seen = work.seen[: end - first]
    if end == first or (end - 1) << work.watch != last:
        steps = np.append(steps, last)
        state = [work.state[0, :r], work.state[engine.velocity_row, :d], work.stages.ravel()]
        seen = np.vstack([seen, np.concatenate(state)[: seen.shape[1]]])
    near = seen[:, r + d :]
    if _has_stages(problem):
        near = velocities_at_the_end(method, near.reshape(len(steps), d, method.stages))
    return _states(engine, problem, step, steps, seen[:, :r], seen[:, r : r + d], near)


def _kept_before(
    engine: Engine, problem: Problem, method: Galerkin, step: float, start: Checkpoint,
    work: RunArrays, ruined: int, seen: States,
) -> States:  # fmt: skip
    """The kept states between the last seen one before step ``ruined`` and that one."""
    before = max([start.first, *seen.steps[seen.steps < ruined].tolist()])
    steps = start.first + work.saved_steps
    rows = np.flatnonzero((steps > before) & (steps <= min(ruined, start.first + work.done)))
    near = np.empty((0, 0))
    if _has_stages(problem):
        near = np.broadcast_to(seen.v[seen.steps == ruined], (len(rows), problem.v0.size))
    return _states(engine, problem, step, steps[rows], work.saved_q[rows], work.saved_v[rows], near)


def _has_stages(problem: Problem) -> bool:
    return isinstance(problem.system, Lagrangian)


def _states(
    engine: Engine, problem: Problem, step: float, steps: Any, q: Array, v: Array, near: Array
) -> States:
    return States(
        steps, q.reshape(-1, *problem.q0.shape), engine.momenta(problem, v),
        problem.t0 + steps * step, near,
    )  # fmt: skip

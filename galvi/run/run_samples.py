"""The samples of a run of equal steps by which its energy is assessed, and the report on it.

Energies are evaluated at each step of a run of at most 127 steps, at 16 to 2047 evenly spread steps
of a longer run, whichever states it keeps, and at its end; where a run is ruined, also at the saved
states between the ruined sample and the one before. An error that comes and goes between two of
these steps is not noticed.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.checkpoint import Checkpoint
from galvi.kernels.nystrom.advance import UNWATCHED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.energies import States, conserves_energy, velocities_at_the_end
from galvi.run.energy_assessment import EnergyReport, Samples, assess_energy
from galvi.run.gimbal_lock import BALL_JOINT, LOCKED, is_locked
from galvi.run.request import RunRequest
from galvi.run.run_arrays import RunArrays
from galvi.run.stepper import Formulation
from galvi.systems.lagrangian import Lagrangian

VELOCITIES = 2  # row of the velocities in the state of vector spaces and moving frames


def assess_run(formulation: Formulation, request: RunRequest, work: RunArrays) -> EnergyReport:
    """The energy report of a run; one without an assessment where the run has no watched steps, or
    its system does not conserve its energy."""
    problem, start = request.problem, request.checkpoint
    if work.steps_done == 0 or work.watch == UNWATCHED or not conserves_energy(problem.system):
        return EnergyReport(energies=start.energies)
    samples = samples_of(formulation, request, work)
    report = assess_energy(
        problem,
        samples,
        start.energies,
        lambda: request.step,
        lambda ruined: _kept_before(formulation, request, work, ruined, samples),
    )
    locked = is_locked(problem, lambda: saved_states(formulation, request, work), request.step)
    if locked:
        report = report._replace(clauses=(LOCKED,), remedy=BALL_JOINT, any_step=True)
    return report


def samples_of(formulation: Formulation, request: RunRequest, work: RunArrays) -> Samples:
    """The samples after the watched steps and after the last step."""
    problem, rows = request.problem, watched_rows(formulation, request, work)
    states = states_of(formulation, problem, rows)
    if isinstance(problem.system, Lagrangian):
        states = states._replace(v=near_velocities(problem, request.method, rows))
    steps = steps_of(request.checkpoint, work)
    return Samples(steps, states._replace(t=problem.t0 + steps * request.step))


def saved_states(
    formulation: Formulation, request: RunRequest, work: RunArrays
) -> tuple[Array, Array]:
    """The saved configurations and momenta, (n, ...) each."""
    shape = (-1, *request.problem.q0.shape)
    return work.saved_q.reshape(shape), formulation.momenta(request.problem, work.saved_moving)


def watched_rows(formulation: Formulation, request: RunRequest, work: RunArrays) -> Array:
    """The rows of the watched states and, unless its step is watched, of the last state, which is
    written into the spare row of ``work.watched_states``."""
    first, r, d = request.checkpoint.first, request.problem.q0.size, request.problem.v0.size
    last = first + work.steps_done
    n = (last >> work.watch) - (first >> work.watch)
    if n == 0 or last & ((1 << work.watch) - 1) != 0:
        row = work.watched_states[n]
        row[:r], row[r : r + d] = work.state[0, :r], work.state[formulation.velocity_row, :d]
        if row.size > r + d:
            row[r + d :] = work.stages.ravel()
        n += 1
    return work.watched_states[:n]


def near_velocities(problem: Problem, method: Galerkin, rows: Array) -> Array:
    """Velocities (n, d) of a Lagrangian at the ends of the steps, from those at the stages."""
    d = problem.v0.size
    stages = rows[:, problem.q0.size + d :].reshape(len(rows), d, method.stages)
    return velocities_at_the_end(method.table, stages)


def steps_of(start: Checkpoint, work: RunArrays) -> Any:
    """The numbers, since the problem's start, of the steps that end at the ``watched_rows``."""
    last = start.first + work.steps_done
    begin, end = start.first >> work.watch, -(-last >> work.watch)
    return np.minimum(np.arange(begin + 1, end + 1) << work.watch, last)


def _kept_before(
    formulation: Formulation, request: RunRequest, work: RunArrays, ruined: int, samples: Samples
) -> Samples:
    """The samples at the saved states after the last sample before step ``ruined``, up to it."""
    problem, start, steps = request.problem, request.checkpoint, samples.steps
    before = max([start.first, *steps[steps < ruined].tolist()])
    numbers = start.first + work.saved_steps
    rows = np.flatnonzero(
        (numbers > before) & (numbers <= min(ruined, start.first + work.steps_done))
    )
    states = states_of(
        formulation, problem, np.hstack([work.saved_q[rows], work.saved_moving[rows]])
    )
    if isinstance(problem.system, Lagrangian):
        velocities = np.broadcast_to(
            samples.states.v[steps == ruined], (len(rows), problem.v0.size)
        )
        states = states._replace(v=velocities)
    return Samples(numbers[rows], states._replace(t=problem.t0 + numbers[rows] * request.step))


def states_of(formulation: Formulation, problem: Problem, rows: Array) -> States:
    """The states of rows (n, r + d or more), all at t0, without the velocities of a Lagrangian."""
    n, r, d = len(rows), problem.q0.size, problem.v0.size
    v = rows[:, r : r + d]
    p = formulation.momenta(problem, v)
    if formulation.velocity_row != VELOCITIES and not isinstance(problem.system, Lagrangian):
        v = problem.system.velocity(p)
    return States(rows[:, :r].reshape(n, *problem.q0.shape), p, v, np.full(n, problem.t0))

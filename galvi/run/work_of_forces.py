"""Assesses a run of equal steps with forces by its energy less their work.

In some steps, the first two among them, the work is integrated along the step's curve with more
nodes than the rule has: a difference from the change of the energy shows that the step does not
resolve its curve. This test is blind where the energy is quadratic and the damping linear: both
rules are exact there, and Gauss's method keeps such an energy less the work of any force, for any
step. So the rates of damping are examined too: a fast one changes a velocity in a step by R(-h r),
see ``growth``, instead of by exp(-h r). Where dampers are the only forces without potential, the
energy of the watched states must neither rise nor fall by more than the dampers can take.

A difference is measured by the largest kinetic energy, range of the potential energy or work of a
step, up to that step. A run is ruined by a step that changes the energy by more than this measure
of all steps before it and by more than the work in the direction of the change.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np
from numpy.polynomial.legendre import leggauss

from galvi.arrays import Array, read_only
from galvi.kernels.energy_errors import ENERGY_ROUND_OFF, REST_SHARE, TOLERATED_SHARE
from galvi.kernels.nystrom.advance import UNWATCHED
from galvi.problem import Problem, WithFunctions
from galvi.run.energies import States, energies, force_on, mass_matrix, working_force
from galvi.run.energy_assessment import EnergyReport, assess_steps, description_of
from galvi.run.gimbal_lock import BALL_JOINT, LOCKED, is_locked
from galvi.run.request import RunRequest, from_start
from galvi.run.run_arrays import RunArrays
from galvi.run.run_samples import (
    near_velocities,
    saved_states,
    states_of,
    steps_of,
    watched_rows,
)
from galvi.run.stepper import Formulation
from galvi.systems.lagrangian import Lagrangian, velocity_at
from galvi.systems.multibody import Multibody
from galvi.tableau import Tableau
from galvi.trajectory import Trajectory

EXAMINED_STEPS = 6  # largest number of steps in which the work is integrated
FIRST_STEPS = 2  # the first of these are the first steps of the run
STEPS_WITH_RATES = 2  # largest number of examined steps in which rates of damping are computed
WORK_STATES = 64  # watched states whose energies are compared where dampers act alone
STATES_WITH_DAMPING = 8  # states of these at which rates of damping are computed
DISSIPATION_MARGIN = 10.0  # ratio of the largest accepted to the estimated loss of energy
EXTRA_NODES = 3  # nodes beyond those of a method's rule
RESOLVED_STEP = 2.0**-6  # a step that resolves a rate, times that rate
RUINED_EARLIER = "the steps before these had ruined it"
Redo = Callable[[RunRequest], Trajectory]


def has_work(system: Any) -> bool:
    """Whether a system has forces whose work can be integrated; False for point masses and for
    systems with explicit time."""
    if not isinstance(system, WithFunctions) or system.explicit_time:
        return False
    return working_force(system) is not None


def assess_work(
    formulation: Formulation, request: RunRequest, work: RunArrays, redo: Redo
) -> EnergyReport:
    """The energy report of a run whose forces do work.

    Parameters
    ----------
    redo
        request of one step -> its run
    """
    so_far = request.checkpoint.energies
    if work.steps_done == 0 or work.watch == UNWATCHED:
        return EnergyReport(energies=so_far)
    with np.errstate(all="ignore"):
        try:
            states = _watched_states(formulation, request, work)
            steps = _examine_steps(formulation, request, work, states, redo)
            unresolved = unresolved_rate(formulation, request, steps, states, redo)
            numbers, table = map(
                np.hstack, zip(*_changes(request, work, steps, states), strict=True)
            )
            order = np.argsort(numbers, kind="stable")
            in_order = np.ascontiguousarray(table[:, order])
            report = assess_steps(request.problem, numbers[order], in_order, so_far, request.step)
            locked = is_locked(
                request.problem, lambda: saved_states(formulation, request, work), request.step
            )
        except Exception as error:  # of a user's function
            unassessed = f"with the work of its forces, which raised {description_of(error)}"
            return EnergyReport(energies=so_far, unassessed=unassessed)
        return _with_clauses(request, report, unresolved, locked)


class Steps(NamedTuple):
    """n steps of a run, and their curves at m nodes.

    Attributes
    ----------
    numbers : array, shape (n,)
        numbers of the steps since the problem's start, from 1
    t : array, shape (n,)
        times at which they begin
    begins, ends
        states at their starts and ends. Their velocities belong to the momenta: those of a stiff
        step's curve are far from them
    q : array, shape (n, m, ...)
        configurations on the curves
    v : array, shape (n, m, d)
        velocities on the curves
    """

    numbers: Any
    t: Array
    begins: States
    ends: States
    q: Array
    v: Array


def _examine_steps(
    formulation: Formulation, request: RunRequest, work: RunArrays, states: States, redo: Redo
) -> Steps:
    """The examined steps: on curves that were kept, or repeated from watched states."""
    problem, start, tau = (
        request.problem,
        request.checkpoint,
        0.5 * (_nodes(request.method.stages)[0] + 1.0),
    )
    if start.keeps_curves and start.save_every == 1:
        begin = request.begin_time
        curves = formulation.curves(
            problem, request.method, request.step, begin, work.bases, work.coefficients
        )
        examined = _examined_indices(work.steps_done)
        numbers, index = start.first + examined, np.repeat(examined, tau.size)
        fractions = np.tile(tau, examined.size)
        q, v = curves.positions(index, fractions), curves.velocities(index, fractions)
        rows = np.hstack([work.saved_q, work.saved_moving])
        at_begin, at_end = (states_of(formulation, problem, rows[examined + k]) for k in range(2))
    else:
        first_steps = np.append(start.first, steps_of(start, work)[:-1])
        examined = _examined_indices(first_steps.size)
        repeated = [
            _repeat_step(formulation, request, states, first_steps, k, redo)
            for k in examined.tolist()
        ]
        solved_indices = [
            k for k, run in enumerate(repeated) if run.success and run.curves is not None
        ]
        numbers, runs = first_steps[examined[solved_indices]], [repeated[k] for k in solved_indices]
        if not runs:
            return _no_steps(problem, tau.size)
        index = np.zeros(tau.size, dtype=np.intp)
        q, v = (
            np.concatenate([getattr(run.curves, part)(index, tau) for run in runs])
            for part in ("positions", "velocities")
        )
        at_begin, at_end = (
            States(
                np.stack([run.q[k] for run in runs]),
                np.stack([run.p[k] for run in runs]),
                np.stack([run.p[k].ravel() for run in runs]),
                np.array([run.t[k] for run in runs]),
            )
            for k in range(2)
        )
    n, times = len(numbers), problem.t0 + numbers * request.step
    v = v.reshape(n, tau.size, -1)
    begins, ends = (
        side._replace(v=_velocities(problem, side, guess, times))
        for side, guess in ((at_begin, v[:, 0]), (at_end, v[:, -1]))
    )
    return Steps(numbers + 1, times, begins, ends, q.reshape(n, tau.size, *problem.q0.shape), v)


def _no_steps(problem: Problem, nodes: int) -> Steps:
    d, shape = problem.v0.size, problem.q0.shape
    no_states = States(
        np.zeros((0, *shape)), np.zeros((0, *problem.p0.shape)), np.zeros((0, d)), np.zeros(0)
    )
    return Steps(
        np.zeros(0, dtype=np.int64),
        np.zeros(0),
        no_states,
        no_states,
        np.zeros((0, nodes, *shape)),
        np.zeros((0, nodes, d)),
    )


def _repeat_step(
    formulation: Formulation,
    request: RunRequest,
    states: States,
    first_steps: Any,
    k: int,
    redo: Redo,
) -> Trajectory:
    """The run of one step from watched state ``k``."""
    q, v = states.q[k], states.v[k].reshape(request.problem.v0.shape)
    t = request.problem.t0 + int(first_steps[k]) * request.step
    return _one_step(formulation, request, request.problem.moved(q, v, t), request.step, True, redo)


def _one_step(
    formulation: Formulation,
    request: RunRequest,
    problem: Problem,
    step: float,
    curves: bool,
    redo: Redo,
) -> Trajectory:
    start = from_start("auto", request.checkpoint.tolerance, curves=curves)
    return redo(RunRequest(problem, request.method, step, 1, start))


def _velocities(problem: Problem, states: States, guess: Array, t: Array) -> Array:
    """The velocities (n, d) of the states' momenta, solved for from guesses (n, d)."""
    system = problem.system
    if not isinstance(system, Lagrangian):
        return system.velocity(states.p).reshape(guess.shape)
    if isinstance(system, Multibody):
        pairs = zip(states.q, states.p, strict=True)
        velocities = [np.linalg.solve(system.tree.mass(q), p) for q, p in pairs]
        return np.array(velocities).reshape(guess.shape)
    rows = zip(states.q, states.p, t, guess, strict=True)
    return np.array([system.velocity(p, q, s, v) for q, p, s, v in rows]).reshape(guess.shape)


@lru_cache(maxsize=32)
def _nodes(stages: int) -> tuple[Array, Array]:
    """Nodes in (-1, 1) and weights of Gauss's rule with EXTRA_NODES more nodes than ``stages``."""
    nodes, weights = leggauss(stages + EXTRA_NODES)
    return read_only(nodes), read_only(weights)


def _examined_indices(n: int) -> Any:
    """At most EXAMINED_STEPS indices below n: the first FIRST_STEPS, and evenly spread ones."""
    spread = np.linspace(0, n - 1, EXAMINED_STEPS - FIRST_STEPS).astype(np.int64)
    return np.unique(np.append(np.arange(min(n, FIRST_STEPS)), spread))


def _watched_states(formulation: Formulation, request: RunRequest, work: RunArrays) -> States:
    """The first state of a run and the watched ones."""
    problem, r, d = request.problem, request.problem.q0.size, request.problem.v0.size
    rows, first = (
        watched_rows(formulation, request, work),
        np.append(work.saved_q[0], work.saved_moving[0]),
    )
    states = states_of(formulation, problem, np.vstack([first, rows[:, : r + d]]))
    if not isinstance(problem.system, Lagrangian):
        return states
    end_velocities = near_velocities(problem, request.method, rows)
    v = problem.v0[None] if request.checkpoint.first == 0 else end_velocities[:1]
    if request.checkpoint.first > 0:
        v = _velocities(
            problem, States(*(part[:1] for part in states)), end_velocities[:1], states.t[:1]
        )
    return states._replace(v=np.vstack([v, end_velocities]))


def _changes(
    request: RunRequest, work: RunArrays, steps: Steps, states: States
) -> Iterator[tuple[Array, Array]]:
    """Pairs of the numbers of steps (n,) and the table (8, n) of their errors, see
    galvi.kernels.energy_errors: changes of the energy less the work. An error ruins by its part
    beyond the work in the direction of the change, unless that work is the larger."""
    nodes, weights = _nodes(request.method.stages)
    times = steps.t[:, None] + 0.5 * (nodes + 1.0) * request.step
    states_in_rows = steps.q.reshape(-1, *request.problem.q0.shape), steps.v.reshape(times.size, -1)
    powers = _powers(request.problem, *states_in_rows, times.ravel()).reshape(times.shape)
    work_done = powers @ (0.5 * request.step * weights)
    (T_0, V_0), (T_1, V_1) = (
        energies(request.problem, states, include_forces=True)
        for states in (steps.begins, steps.ends)
    )
    energy_changes = T_1 + V_1 - T_0 - V_0
    errors, work_with_change = (
        np.abs(energy_changes - work_done),
        np.fmax(0.0, work_done * np.sign(energy_changes)),
    )
    errors_beyond_work = np.minimum(errors, np.abs(energy_changes) - work_with_change)
    sizes = np.fmax(np.maximum(np.abs(T_0), np.abs(T_1)), np.abs(work_done))
    potentials = np.sort([V_0, V_1], axis=0)
    yield (
        steps.numbers,
        _error_table(
            errors,
            np.where(errors_beyond_work <= work_with_change, 0.0, errors_beyond_work),
            sizes,
            *potentials,
        ),
    )
    if isinstance(request.problem.system, Multibody) and request.problem.system.is_damped_alone:
        yield _changes_between_states(request, work, states)


def _error_table(errors: Array, ruining: Array, sizes: Array, *potentials: Array) -> Array:
    return np.array([errors, ruining, sizes, *potentials, ENERGY_ROUND_OFF * sizes, sizes, sizes])


def _changes_between_states(
    request: RunRequest, work: RunArrays, states: States
) -> tuple[Array, Array]:
    """Numbers of steps (n,) and the table (8, n) of the errors from the first state to watched ones
    of a run in which only dampers take energy: its rise, or its fall beyond DISSIPATION_MARGIN
    times what the fastest damping takes from the largest kinetic energy. Other forces may do work
    between the examined steps, so that their runs have no such bound."""
    problem, start = request.problem, request.checkpoint
    numbers = np.append(start.first, steps_of(start, work))
    chosen = np.unique(np.linspace(0, len(numbers) - 1, WORK_STATES).astype(np.int64))
    states, numbers = States(*(part[chosen] for part in states)), numbers[chosen]
    kinetic, potential = energies(problem, states, include_forces=True)
    rates = [
        float(np.max(damping_rates(problem, states.q[k], states.v[k], 0.0)[0]))
        for k in np.unique(np.linspace(0, len(numbers) - 1, STATES_WITH_DAMPING).astype(np.int64))
    ]
    elapsed = np.abs(numbers - numbers[0]) * abs(request.step)
    largest_losses = (
        DISSIPATION_MARGIN * 2.0 * max(rates) * np.maximum.accumulate(np.abs(kinetic)) * elapsed
    )
    rises = np.sign(request.step) * (kinetic + potential - kinetic[0] - potential[0])
    errors = np.maximum(np.maximum(rises, -rises - largest_losses), 0.0)
    table = _error_table(errors, errors, np.abs(kinetic), potential, potential)
    return numbers[1:], table[:, 1:]


def _powers(problem: Problem, q: Array, v: Array, t: Array) -> Array:
    """The power (n,) of the forces without potential at n states."""
    velocities = v.reshape(len(v), *problem.v0.shape)
    rows = zip(q, velocities, t, strict=True)
    return np.array([np.sum(force_on(problem.system, x, w, s) * w) for x, w, s in rows])


class Unresolved(NamedTuple):
    """A velocity that forces change faster than a step resolves.

    Attributes
    ----------
    rate
        rate of its damping; negative where it grows
    share
        its approximate error after a step, over its largest value in the run
    step
        number of that step since the problem's start, from 1
    """

    rate: float
    share: float
    step: int


def unresolved_rate(
    formulation: Formulation, request: RunRequest, steps: Steps, states: States, redo: Redo
) -> Unresolved | None:
    """The velocity whose damping is too fast for the steps and leaves the largest error; None where
    no such error exceeds TOLERATED.

    Near a state v' = -M^-1 D (v - w), D = -df/dv. Modes of a rate r with |h r| above the number of
    stages are not resolved: their part of v - w changes by R(-h r), see ``growth``, and not by
    exp(-h r). That part is the mode's part of -v' / r, where v' comes from a step that resolves the
    fastest rate; it is 0 once v has become w.
    """
    problem, worst = request.problem, None
    system: Any = problem.system
    largest = float(np.max(np.abs(energies(problem, states)[0])))
    fastest = np.max(np.abs(states.v), axis=0)
    chosen = np.unique(np.linspace(0, len(steps.t) - 1, STEPS_WITH_RATES).astype(np.int64))
    for k in chosen if len(steps.t) else ():
        t, q, v = steps.t[k], steps.begins.q[k], steps.begins.v[k].reshape(problem.v0.shape)
        rates, modes = damping_rates(problem, q, v, t)
        is_fast = np.abs(request.step * rates) > request.method.stages
        if not is_fast.any():
            continue
        rate = float(rates[np.argmax(np.abs(rates))])
        start_of_step, short_step = (
            problem.moved(q, v, t),
            math.copysign(RESOLVED_STEP / rate, request.step),
        )
        after = _one_step(formulation, request, start_of_step, short_step, False, redo)
        velocity_after = velocity_at(system, after.q[-1], after.p[-1], t, v.ravel())
        parts = np.linalg.solve(modes, np.ravel(v - velocity_after) / short_step)
        factor_errors = [
            growth(request.method.table, request.step * r) - math.exp(min(-request.step * r, 700.0))
            for r in rates[is_fast]
        ]
        error = np.real(modes[:, is_fast] @ (factor_errors * parts[is_fast] / rates[is_fast]))
        largest_speeds = np.sqrt(2.0 * largest / np.diag(mass_matrix(problem, q, v, t)))
        share = float(np.max(np.abs(error) / np.maximum(fastest, REST_SHARE * largest_speeds)))
        if share > TOLERATED_SHARE and (worst is None or share > worst.share):
            worst = Unresolved(rate, share, int(steps.numbers[k]))
    return worst


def damping_rates(problem: Problem, q: Array, v: Array, t: float) -> tuple[Array, Array]:
    """The rates (d,) at which forces damp velocities at a state, and their modes as columns (d, d):
    real parts of the eigenvalues of M^-1 D, D = -df/dv, and its eigenvectors. Rates are 0 where
    that matrix is not finite."""
    system = problem.system
    v = v.reshape(problem.v0.shape)
    n, size = v.size, float(np.max(np.abs(v))) or 1.0
    damping = np.empty((n, n))
    for k in range(n):
        nudge = np.zeros(n)
        nudge[k] = 2.0**-10 * size
        force_ahead, force_behind = (
            force_on(system, q, v + sign * nudge.reshape(v.shape), t) for sign in (1.0, -1.0)
        )
        damping[:, k] = np.ravel(force_behind - force_ahead) / (2.0 * nudge[k])
    rates = np.linalg.solve(mass_matrix(problem, q, v, t), damping)
    if not np.isfinite(rates).all():
        return np.zeros(n), np.eye(n)
    eigenvalues, modes = np.linalg.eig(rates)
    return eigenvalues.real, modes


def growth(table: Tableau, z: float) -> float:
    """R(-z), the factor by which a step of length h changes a velocity damped at the rate z / h."""
    b, psi, slope, end = table.b, table.psi, table.slope, table.end
    matrix = (slope - z * psi).T @ (b[:, None] * slope) + z * np.outer(end, b @ slope)
    y = np.linalg.solve(matrix, end)
    return float(1.0 - z * (b @ slope @ y))


def _with_clauses(
    request: RunRequest, report: EnergyReport, unresolved: Unresolved | None, locked: bool
) -> EnergyReport:
    """The report with its clauses and remedy: energy, unresolved damping, gimbal lock."""
    begin, clauses, remedy = request.problem.t0, [], ""
    if report.ruined == 0:
        clauses.append(RUINED_EARLIER)
    elif report.error > TOLERATED_SHARE:
        which = "before it" if report.ruined == report.worst else "up to there"
        end = begin + cast(int, report.worst) * request.step
        clauses.append(
            f"in the step to t = {end:.10g} the energy and the work of the forces differ by "
            f"{report.error:.2g} times the largest energy {which}"
        )
    if unresolved is not None:
        rate_times_step = abs(request.step * unresolved.rate)
        step_share = (
            f"{rate_times_step:.2g}" if rate_times_step < 100.0 else f"{rate_times_step:,.0f}"
        )
        verb = "damped" if unresolved.rate * request.step > 0.0 else "increased"
        fraction = f"about {unresolved.share:.1g} of" if unresolved.share < 1.0 else "more than"
        clauses.append(
            f"forces have {verb} a velocity in 1/{step_share} of a step, which leaves it wrong by "
            f"{fraction} its largest value in the step to "
            f"t = {begin + unresolved.step * request.step:.10g}"
        )
        remedy = (
            f"Use a step of {rounded_down(request.method.stages / abs(unresolved.rate)):g} or less"
        )
    if locked:
        clauses.append(LOCKED)
        remedy = BALL_JOINT
    return report._replace(error=0.0, clauses=tuple(clauses), remedy=remedy, any_step=locked)


def rounded_down(x: float) -> float:
    """A positive number rounded down to two significant digits."""
    power = 10.0 ** (math.floor(math.log10(x)) - 1)
    return float(f"{math.floor(x / power * (1.0 + 1e-12)) * power:.2g}")

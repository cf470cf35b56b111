"""One run in a clock: its motion, its trajectory and how it ended."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.checkpoint import Checkpoint
from galvi.curves.clock_curves import ClockCurves, RedoneClockCurves
from galvi.environment import FAST
from galvi.kernels.energy_errors import TOLERATED
from galvi.kernels.forces.passages import FOUND
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.driven import motion_of_driven
from galvi.run.clocked.general import motion_in_general
from galvi.run.clocked.in_lanes import motion_in_lanes
from galvi.run.clocked.loop import Loop
from galvi.run.clocked.plan import NO_COUNTS, Motion, Taken, costly_pair, joined
from galvi.run.energies import States, asks_functions, has_no_force, start_energies
from galvi.run.energy_assessment import EnergyReport, Samples, assess_energy
from galvi.run.interruption import Interrupted, defer_interrupts
from galvi.run.loop import step_in_batches
from galvi.run.nystrom_engine import ROUND_OFF
from galvi.run.plan import COUNTED
from galvi.run.point_masses.encounters import (
    STATES,
    MasslessError,
    massless_error,
    unresolved_passage,
)
from galvi.run.same_functions import of_run
from galvi.run.status import energy_clause, off_without_mass
from galvi.systems.lagrangian import velocity_at
from galvi.systems.nbody import NBody
from galvi.trajectory import COMPLETED, Trajectory

TOO_LONG = "the step is too large for the clock"


def motion_of(
    problem: Problem, method: Galerkin, solver: str, tolerance: float, energy: float | None = None
) -> Motion:
    """The motion of a problem in a method's clock; ValueError where it has none.

    energy  that the clock is told; None: that of the start
    """
    method.clock.rate(problem)
    total = start_energies(problem).total
    if not math.isfinite(total):
        raise ValueError(
            f"a clock needs a finite energy at the start; received {total}. Start elsewhere."
        )
    if FAST and solver != "newton" and tolerance == ROUND_OFF:
        found = motion_in_lanes(problem, method, energy)
        if found is not None:
            return found
    told = total if energy is None else energy
    if not has_no_force(problem.system):
        return motion_of_driven(problem, method, told, solver, tolerance)
    return motion_in_general(problem, method, told, solver, tolerance)


def run_in_clock(
    problem: Problem, method: Galerkin, step: float, start: Checkpoint, steps: int | None,
    time: float | None, *, first: Trajectory | None = None, progress: bool | None = None,
    interrupted: Callable[[], bool] | None = None, before: int = 0,
) -> Trajectory:  # fmt: skip
    """The trajectory of up to ``steps`` steps, which ends at ``time`` if that is given.

    first   the run that is continued: its last state is the first of this one
    before  steps of a longer run that precede these, which its status counts
    """
    motion = motion_of(problem, method, start.solver, start.tolerance)
    state = start if start.state.size else replace(
        motion.at(problem.q0, problem.v0, problem.t0), solver=start.solver,
        tolerance=start.tolerance, save_every=start.save_every, curves=start.curves,
    )  # fmt: skip
    loop = Loop(problem, method, step, motion, state, time)
    most = input_checks.LARGEST if steps is None else steps
    with np.errstate(all="ignore"), defer_interrupts() as pressed:  # what is not finite is said
        stopped = interrupted or pressed
        code = step_in_batches(
            loop.call, lambda code: code, loop, most, progress, lambda: loop.over or stopped()
        )
        run = _trajectory(loop, code, steps, first, before)
        if pressed() and not run.interrupted:
            raise Interrupted(run)
    system: Any = problem.system
    if asks_functions(system) or getattr(system, "explicit_time", False):
        run._judge()  # now: what the functions refer to may change
    return run


def _trajectory(
    loop: Loop, code: int, steps: int | None, first: Trajectory | None, before: int
) -> Trajectory:
    """The trajectory of a loop whose last call returned ``code``, to be judged when asked."""
    problem, start, h = loop.problem, loop.start, loop.step
    end, share = loop.to_time() if loop.reached else (None, 0.0)
    if end is not None:
        loop.note_passages(end)
    parts, numbers = list(loop.kept), [np.zeros(1), *(start.first + n for n in loop.numbers)]
    number = start.first + loop.done
    if end is not None:
        parts.append(end.rows([0]))
        numbers.append(np.array([number + share]))
    elif loop.done and not (numbers[-1].size and numbers[-1][-1] == number):
        parts.append(cast(Taken, loop.last))
        numbers.append(np.array([number]))
    tau = np.concatenate(numbers) * h
    begin = problem.q0, problem.p0, problem.v0, problem.t0
    if first is not None:
        tau[0] = cast(Array, first.tau)[-1]
        begin = first.q[-1], first.p[-1], first.v[-1], float(first.t[-1])
    massless = isinstance(problem.system, NBody) and problem.system.has_massless
    q, p, v = (np.reshape(x, (1, -1)) for x in begin[:3])
    clock = np.array([[begin[3], 0.0]])
    head = Taken(q, p, v if massless else None, clock, np.zeros((0, *problem.v0.shape)),
                 np.zeros((1, loop.method.stages)), NO_COUNTS)  # fmt: skip
    whole = joined([head, *(part._replace(coefficients=head.coefficients) for part in parts)])
    times = whole.t[:, 0]
    if loop.reached and loop.done + (end is not None):
        times[-1] = loop.time
    counts = {"steps": loop.done, **dict(zip(COUNTED, map(int, loop.counts), strict=True))}
    if isinstance(problem.system, NBody):
        counts["pair_evaluations"] = counts["force_evaluations"] * problem.system.pairs
    curves, last = loop.curves(end, share), float(times[-1])
    run = Trajectory(
        problem=problem,
        t=read_only(times),
        q=read_only(whole.q.reshape(-1, *problem.q0.shape)),
        p=read_only(whole.p.reshape(-1, *problem.v0.shape)),
        counts=counts,
        step=h,
        method=loop.method,
        curves=curves,
        again=None
        if curves is not None
        else RedoneClockCurves(
            problem,
            loop.method,
            h,
            tuple(loop.known),
            last,
            of_run(problem, whole.q, whole.p, times, loop.method.clock, False),
        ),
        interrupted=not (loop.over or loop.reached) and code == SOLVED and loop.done != steps,
        velocities=read_only(cast(Array, whole.v).reshape(-1, *problem.v0.shape))
        if massless
        else None,
        engine=loop.motion.engine,
        tau=read_only(tau),
    )
    run._judge_later(lambda: _ending(loop, run, steps, end, before))
    return run


def _ending(
    loop: Loop, run: Trajectory, steps: int | None, end: Taken | None, before: int
) -> Mapping[str, Any]:
    """The fields of a trajectory that tell how it ended."""
    start, remedy = loop.start, "Use a smaller step or a higher degree."
    report, driven = _assessed(loop, end), not has_no_force(loop.problem.system)
    where = f"after {before + loop.done} steps, at t = {float(run.t[-1]):.10g}"
    failed: int | None = loop.done + 1
    if loop.reason:
        status = f"Stopped {where}: {loop.reason.rstrip('.')}."
        status += (
            f" Note that {_units(loop.problem, loop.method)}." if before + loop.done == 0 else ""
        )
    elif run.interrupted:
        status = f"Interrupted {where}; what was computed is kept."
    elif loop.time is not None and not loop.reached:
        status = (
            f"Stopped {where}: the bound of {steps} steps was reached before t = "
            f"{loop.time:.10g}. Give more steps, or a larger step."
        )
    else:
        passage = unresolved_passage(loop.problem, None, loop.passage)
        reasons = list(filter(None, [_doubts(report, driven), passage]))
        if not reasons:
            reasons = off_without_mass(loop.problem, _massless_error(loop, run))
        failed, wrong = None, "; ".join(reasons)
        status = f"Completed, but {wrong}. {remedy}" if wrong else COMPLETED
        if report.ruined is not None:
            failed = max(report.ruined - start.first, 1)
            status = f"Ruined from step {before + failed} on: {wrong}. {remedy}"
    if isinstance(run.curves, ClockCurves) and (back := run.curves.steps_backwards()).size:
        status += f" The time does not grow along step {before + int(back[0]) + 1}: {TOO_LONG}."
    if report.unassessed:
        status += f" Its energy could not be judged {report.unassessed}."
    said = [loop.motion.remark]
    if isinstance(loop.problem.system, NBody) and loop.seen and not loop.reason:
        q = np.concatenate([part.q for part in loop.seen])
        said.append(costly_pair(loop.problem, q))
    last = replace(loop.state, energies=report.energies, passage=read_only(loop.passage[:FOUND]),
                   save_every=start.save_every,
                   curves=start.curves, solver=start.solver, tolerance=start.tolerance)  # fmt: skip
    return {"success": failed is None, "status": " ".join([status, *filter(None, said)]),
            "failed_step": failed, "checkpoint": last}  # fmt: skip


def _massless_error(loop: Loop, run: Trajectory) -> MasslessError | None:
    """What a step does to bodies without mass, at some of the kept states; None without any."""
    if not (isinstance(loop.problem.system, NBody) and loop.problem.system.has_massless):
        return None

    last, none = loop.state, np.zeros_like
    last = replace(last, stages=none(last.stages), solver_state=none(last.solver_state))

    def state_at(q: Array, v: Array, t: float) -> Checkpoint:
        state = np.zeros_like(last.state)
        state[0], state[2] = q.ravel(), v.ravel()
        return replace(last, state=state, clock=np.array([t, 0.0, *last.clock[2:]]))

    def ends(states: list[Checkpoint], n: int) -> Array:
        lengths = np.full(len(states), -loop.step / n)
        for _ in range(n):
            q, v, times, codes = cast(Any, loop.motion.each)(states, lengths)
            q[codes != SOLVED] = np.nan
            states = [state_at(*row) for row in zip(q, v, times, strict=True)]
        return np.stack([q, v]).reshape(2, -1, *loop.problem.q0.shape)

    rows = np.unique(np.linspace(0, len(run.t) - 1, STATES + 1).round().astype(int))
    states = [state_at(*row) for row in zip(run.q[rows], run.v[rows], run.t[rows], strict=True)]
    return massless_error(loop.problem, ends, states, STATES)


def _assessed(loop: Loop, end: Taken | None) -> EnergyReport:
    """What the energies of some steps say."""
    problem, start = loop.problem, loop.start
    parts, places = list(loop.seen), list(loop.places)
    if end is not None:
        parts, places = [*parts, end.rows([0])], [*places, [loop.done + 1]]
    elif loop.done % loop.stride:
        parts, places = [*parts, cast(Taken, loop.last)], [*places, [loop.done]]
    if not parts:
        return EnergyReport(energies=start.energies)
    taken, steps = joined(parts), start.first + np.concatenate(places)
    n, t, v = len(steps), taken.t[:, 0], taken.v
    q, p = taken.q.reshape(n, *problem.q0.shape), taken.p.reshape(n, *problem.v0.shape)
    if v is None:
        with np.errstate(all="ignore"):
            v = velocity_at(problem.system, q, p, t, problem.v0).reshape(n, -1)
    samples = Samples(steps, States(q, p, v, t), taken.energy)
    return assess_energy(
        problem,
        samples,
        start.energies,
        lambda: float(loop.motion.rate(problem.q0.ravel())) * loop.step,
    )


def _doubts(report: EnergyReport, driven: bool) -> str:
    """What a report says of a run; with ``driven``, of the energy less the work of forces."""
    if report.unknown:
        return "the energy is not a number"
    if not report.error > TOLERATED:
        return ""
    differ = f"the energy and the work of the forces differ by {report.error:.2g} times the largest"
    return f"{f'{differ} energy' if driven else energy_clause(report)}: the step is too large"


def check_step(problem: Problem, method: Galerkin, step: float) -> None:
    """ValueError for a clock without a g at the start, or a step that cannot be one of its."""
    g = float(method.clock.rate(problem)(problem.q0.ravel()))
    if not (math.isfinite(g) and g > 0.0):
        raise ValueError(
            f"a clock must be positive and finite; received {g} at the start. Start elsewhere."
        )
    if problem.t0 + step * g == problem.t0:
        raise ValueError(
            f"step must change the time; received {step!r} at t0 = {problem.t0!r}, where times are "
            f"{math.ulp(problem.t0):.1e} apart. Shift t0 towards 0, or use a larger step."
        )
    longest = getattr(method.clock, "longest", math.inf)
    if abs(step) > longest:
        raise ValueError(
            f"step must be at most {longest:g}: {_units(problem, method)}, so that a revolution is "
            f"2 pi; received {step!r}. Use 0.3 to 0.6 for degree 8."
        )


def _units(problem: Problem, method: Galerkin) -> str:
    g = float(method.clock.rate(problem)(problem.q0.ravel()))
    return f"steps are in units of the clock {method.clock}, {g:.3g} of time at the start"


def curves_from(
    problem: Problem, method: Galerkin, step: float, state: Checkpoint, time: float, end: float
) -> ClockCurves:
    """The curves from a state to the first end of a step past a time, of a run that ended at
    ``end``: only its last step may have been shortened."""
    there = replace(state, save_every=1, curves=True)
    steps = len(run_in_clock(problem, method, step, there, None, time).t) - 1
    run = run_in_clock(problem, method, step, there, steps, end)
    if run.curves is None:
        raise ValueError(f"the steps to t = {time!r} could not be done again. {run.status}")
    return cast(ClockCurves, run.curves)

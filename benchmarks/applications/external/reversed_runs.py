"""A run of an external integrator forwards and back again, for `external.check_runs`.

What is symmetric returns to the start but for rounding, however long its steps; of a method that is
not, the distance from the start is about its error times a power of the step. The steps are
therefore longer than those that it offers, where it runs at longer ones: as long as the error at
the end is below NOT_SMALL. Where its longest ones are too long themselves, as for an implicit
method whose iteration does not converge, they are its shortest.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.order_runs import (
    COARSE,
    LARGEST_SPAN,
    errors_at,
    fewest,
    offered_steps,
)
from benchmarks.store.frames import failure, row
from galvi import Problem, Trajectory
from galvi.arrays import Array
from galvi.systems.lagrangian import velocity_at

REVERSED = "distance from the start after a run back"
ROUNDING = "rounding of a run forwards and back"
NOT_REVERSED = "no run back"
NO_EQUAL_STEPS = (
    "It declares that it is symmetric, which is seen at equal steps: offer settings with a `step`."
)
NO_START = "It does not support the problem from the time at which a run back starts, t = {:g}."
NOT_SMALL = 1e-3  # error at the end of the run forwards that is large enough
NEARBY = 1e-7  # relative change of a start by which the growth of errors is measured
ROOM = 1000.0  # units of rounding of a step: for the sums in it, and an iteration that stops early


def reversed_runs(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    end: Array,
) -> Iterator[dict[str, Any]]:
    """Row REVERSED, the distance from the start over the size of the states, the larger of that of
    q and of p, and row ROUNDING, how large rounding may make it: ROOM eps for each step, times the
    growth of a small change of the start. Where no run back can be made, row NOT_REVERSED, the
    reason in its status.

    Parameters
    ----------
    settings
        the offered ones
    end
        the true configuration at the end
    """
    equal = [setting for setting in settings if "step" in setting]
    if not equal:
        yield row(study=check.problem.name, quantity=NOT_REVERSED, status=NO_EQUAL_STEPS)
        return
    few, many = offered_steps(check, equal)
    error = errors_at(external, check, equal, end)
    steps = fewest(error, few, max(many, round(LARGEST_SPAN * few)), NOT_SMALL)
    steps = steps if error(steps)[0] <= COARSE else many
    step, duration, problem = check.duration / steps, check.duration, check.problem
    setting = {**equal[-1], "step": step, "save_every": steps}
    where = {"study": problem.name, "step": step, "steps": steps, "t": duration}

    def run(start: Problem, sense: float = 1.0) -> Trajectory:
        run_setting = {**setting, "step": sense * step}
        return external.checked(start, sense * duration, run_setting, is_trial=True).run

    forwards = run(problem)
    if not forwards.success:
        yield row(quantity=REVERSED, status=failure(forwards), **where)
        return
    system, t = problem.system, float(forwards.t[-1])
    v = velocity_at(system, forwards.q[-1], forwards.p[-1], t, problem.v0)
    timed = any(getattr(system, name, False) for name in ("explicit_time", "timed_force"))
    turned = replace(problem, q0=forwards.q[-1], v0=v, t0=t if timed else problem.t0)
    if not external.supports(turned):
        yield row(quantity=NOT_REVERSED, status=NO_START.format(turned.t0), **where)
        return
    back, nearby = run(turned, -1.0), run(_moved(problem, duration))
    missed = _distance(back, problem.q0, problem.p0, forwards) if back.success else float("nan")
    growth = (
        _distance(nearby, forwards.q[-1], forwards.p[-1], forwards) / NEARBY
        if nearby.success
        else 1.0
    )
    yield row(quantity=REVERSED, value=missed, status=failure(back), **where)
    rounding = ROOM * float(np.finfo(float).eps) * steps * max(1.0, growth)
    yield row(quantity=ROUNDING, value=rounding, **where)


def _moved(problem: Problem, duration: float) -> Problem:
    """The problem with velocities changed by NEARBY of their size, differently in each."""
    size = float(np.max(np.abs(problem.v0))) or float(np.max(np.abs(problem.q0))) / duration
    change = np.random.default_rng(1).standard_normal(problem.v0.shape)
    return replace(problem, v0=problem.v0 + NEARBY * size * change)


def _distance(run: Trajectory, q: Array, p: Array, forwards: Trajectory) -> float:
    """The distance of a run's end from (q, p), over the size of the states of `forwards`."""
    return max(
        float(np.max(np.abs(end - state)) / (np.max(np.abs(states)) or 1.0))
        for end, state, states in ((run.q[-1], q, forwards.q), (run.p[-1], p, forwards.p))
    )

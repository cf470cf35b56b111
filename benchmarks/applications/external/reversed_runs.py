"""A run of an external integrator forwards and back again, for `external.check_runs`.

A symmetric method returns to the start but for rounding, however long its steps; any other ends at
a distance of about its error times a power of the step. Where the error is below
LARGE_ENOUGH_ERROR, longer steps than the offered ones are therefore tried. Where even the longest
offered steps are too long, as for an implicit method whose iteration does not converge, the
shortest are taken.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.applications.external.order_runs import (
    LARGEST_FIRST_ERROR,
    LARGEST_SPAN,
    errors_at,
    first_steps,
    offered_steps,
)
from benchmarks.store.tables import failure, row
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
LARGE_ENOUGH_ERROR = (
    1e-3  # error at the end of the run forwards from which on steps are long enough
)
START_CHANGE = 1e-7  # relative change of the start, to measure the growth of errors
ROUNDING_PER_STEP = 1000.0  # eps: rounding of a step's sums, and of an iteration that stops early


def reversed_runs(
    external: ExternalIntegrator,
    check: CheckProblem,
    settings: Sequence[Mapping[str, Any]],
    end: Array,
) -> Iterator[dict[str, Any]]:
    """Rows of a run forwards and back.

    Row REVERSED has the distance from the start over the size of the states, the larger of that of
    q and of p. Row ROUNDING has its largest value by rounding: ROUNDING_PER_STEP eps for each step,
    times the growth of a small change of the start. Where no run back is possible, row NOT_REVERSED
    has the reason in its status.

    Parameters
    ----------
    settings
        settings that the integrator offers
    end
        true configuration at the end
    """
    equal = [setting for setting in settings if "step" in setting]
    if not equal:
        yield row(study=check.problem.name, quantity=NOT_REVERSED, status=NO_EQUAL_STEPS)
        return
    few, many = offered_steps(check, equal)
    error = errors_at(external, check, equal, end)
    steps = first_steps(error, few, max(many, round(LARGEST_SPAN * few)), LARGE_ENOUGH_ERROR)
    steps = steps if error(steps)[0] <= LARGEST_FIRST_ERROR else many
    step, duration, problem = check.duration / steps, check.duration, check.problem
    setting = {**equal[-1], "step": step, "save_every": steps}
    columns = {"study": problem.name, "step": step, "steps": steps, "t": duration}

    def run(start: Problem, direction: float = 1.0) -> Trajectory:
        run_setting = {**setting, "step": direction * step}
        return external.checked(start, direction * duration, run_setting, is_trial=True).run

    forwards = run(problem)
    if not forwards.success:
        yield row(quantity=REVERSED, status=failure(forwards), **columns)
        return
    system, t = problem.system, float(forwards.t[-1])
    v = velocity_at(system, forwards.q[-1], forwards.p[-1], t, problem.v0)
    depends_on_time = any(getattr(system, name, False) for name in ("explicit_time", "timed_force"))
    backwards = replace(problem, q0=forwards.q[-1], v0=v, t0=t if depends_on_time else problem.t0)
    if not external.supports(backwards):
        yield row(quantity=NOT_REVERSED, status=NO_START.format(backwards.t0), **columns)
        return
    back, nearby = run(backwards, -1.0), run(_with_changed_velocities(problem, duration))
    distance = _distance(back, problem.q0, problem.p0, forwards) if back.success else float("nan")
    growth = (
        _distance(nearby, forwards.q[-1], forwards.p[-1], forwards) / START_CHANGE
        if nearby.success
        else 1.0
    )
    yield row(quantity=REVERSED, value=distance, status=failure(back), **columns)
    rounding = ROUNDING_PER_STEP * float(np.finfo(float).eps) * steps * max(1.0, growth)
    yield row(quantity=ROUNDING, value=rounding, **columns)


def _with_changed_velocities(problem: Problem, duration: float) -> Problem:
    """The problem with velocities changed at random, by about START_CHANGE of the largest."""
    size = float(np.max(np.abs(problem.v0))) or float(np.max(np.abs(problem.q0))) / duration
    change = np.random.default_rng(1).standard_normal(problem.v0.shape)
    return replace(problem, v0=problem.v0 + START_CHANGE * size * change)


def _distance(run: Trajectory, q: Array, p: Array, forwards: Trajectory) -> float:
    """The largest difference of a run's end from (q, p), over the size of `forwards`."""
    return max(
        float(np.max(np.abs(end - state)) / (np.max(np.abs(states)) or 1.0))
        for end, state, states in ((run.q[-1], q, forwards.q), (run.p[-1], p, forwards.p))
    )

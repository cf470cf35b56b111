"""Long runs of an external integrator, for `external.check_runs`: changes of conserved quantities,
and whether the runs reach the end.

Each problem is run over some twenty revolutions, at the finest setting. The first problem that
conserves something is also run from the start with LONGEST_RUN_STEPS steps of the same size, or
with as many as TIME_FRACTION of the time limit allows, as predicted from the first run. An
integrator without steps runs LENGTHENING times as long. States at random times are compared, since
evenly spaced ones may beat with the motion.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import CheckedRun, ExternalIntegrator
from benchmarks.measures import independent_invariants
from benchmarks.store.tables import failure, row
from benchmarks.work_precision.participants import offered_settings, readable_setting, sampled
from galvi import Problem, Trajectory
from galvi.arrays import Array

LONG = "steps of its longest run"
CUT = "difference of a run that starts half way"
NOT_CUT = "no run that starts half way"
NO_START = "It does not support the problem from half way, t = {:g}."
LONGER = "{} in its longest run"
LONG_RUN_PARTS = 200  # equal parts of a long run, or up to MOST_PARTS_FACTOR times as many
MOST_PARTS_FACTOR = 20
GROUP_SIZE = 4  # one of so many successive states is compared
SEEDS = (1, 2)
LONGEST_RUN_STEPS = 100_000
LENGTHENING = 6  # duration of the longest run without steps over that of the first run
CUT_FRACTION = 0.2  # of LONGEST_RUN_STEPS: steps of the run that is also started half way
TIME_FRACTION = 1.0 / 3.0  # of the time limit, for a time proportional to the number of steps


@dataclass(frozen=True, eq=False)
class LongRun:
    """A run over some twenty revolutions at the finest setting.

    Attributes
    ----------
    checked
        the run and its time
    steps
        number of equal steps; 0 where it has none
    """

    check: CheckProblem
    setting: Mapping[str, Any]
    checked: CheckedRun
    steps: int

    @property
    def problem(self) -> Problem:
        """The problem of the conservation run: `watched` where the check has one."""
        return self.check.watched or self.check.problem

    def rows(self) -> Iterator[dict[str, Any]]:
        """Yield rows of the relative changes of the conserved quantities."""
        yield from _changes(
            self.check, self.problem, self.checked.run, self.setting, "{}", self.check.conserved
        )


def long_run(external: ExternalIntegrator, check: CheckProblem) -> LongRun | None:
    """The long run on a problem; None where the integrator offers no settings for it."""
    problem = check.watched or check.problem
    offered = offered_settings(external, problem, check.long, LONG_RUN_PARTS)
    if not offered:
        return None
    step = offered[-1].get("step")
    parts = LONG_RUN_PARTS * max(
        1,
        min(
            MOST_PARTS_FACTOR,
            round(check.long / step) // LONG_RUN_PARTS if step else MOST_PARTS_FACTOR,
        ),
    )
    setting = sampled(check.long, offered[-1], parts)
    steps = parts * setting["save_every"] if step else 0
    return LongRun(check, setting, external.checked(problem, check.long, setting), steps)


def longest_run(external: ExternalIntegrator, first: LongRun) -> Iterator[dict[str, Any]]:
    """Rows of a longer run from the same start at the same step.

    Row LONG has its number of steps, or its duration for an integrator without steps; other rows
    have the changes of the quantities that the integrator declares to conserve. Where a longer run
    would take too long, row LONG is that of the first run; where the first run failed, it has the
    reason.
    """
    if not first.checked.run.success:
        yield row(
            study=first.check.problem.name,
            quantity=LONG,
            t=first.check.long,
            steps=first.steps,
            label=readable_setting(first.setting),
            status=failure(first.checked.run),
        )
        return
    wanted_factor = LONGEST_RUN_STEPS / first.steps if first.steps else float(LENGTHENING)
    factor = _in_time(external, first, wanted_factor)
    note = (
        ""
        if factor == wanted_factor or wanted_factor <= 1.0
        else ("More would take over a third of the time limit, by the time of its shorter run.")
    )
    steps, duration, run, setting = first.steps, first.check.long, first.checked.run, first.setting
    if factor > 1.0:
        setting, steps, duration = _lengthened(first, factor)
        run = external.checked(first.problem, duration, setting).run
        conserved = [name for name in first.check.conserved if name in external.conserves]
        yield from _changes(first.check, first.problem, run, setting, LONGER, conserved)
    yield row(
        study=first.check.problem.name,
        quantity=LONG,
        label=readable_setting(setting),
        t=duration,
        steps=steps,
        value=(steps or duration) if run.success else float("nan"),
        status=failure(run) or note,
    )


def _in_time(external: ExternalIntegrator, first: LongRun, factor: float) -> float:
    """The factor by which to lengthen a run: `factor`, or less where the time limit requires it."""
    # the square root: copying all states at each step takes a time that grows as their square
    in_time = external.limit / max(first.checked.seconds, 1e-9)
    return min(factor, TIME_FRACTION * in_time, in_time**0.5)


def cut_run(external: ExternalIntegrator, check: CheckProblem) -> Iterator[dict[str, Any]]:
    """Row CUT: the difference between the ends of a run and of another that starts half way.

    The second run starts from the first one's state and time half way. The difference is relative
    to the largest distance from the start. Where the integrator does not support that start, row
    NOT_CUT has the reason in its status. Nothing where the first run fails.

    The ends of a one-step method differ by rounding, those of other methods by their error; where
    a run uses the wrong time, they differ by the size of the motion.
    """
    first = long_run(external, replace(check, long=check.duration, watched=None))
    if not (first and first.checked.run.success):
        return
    wanted_factor = (
        CUT_FRACTION * LONGEST_RUN_STEPS / first.steps
        if first.steps
        else LENGTHENING * check.long / check.duration
    )
    factor = _in_time(external, first, wanted_factor)
    setting, steps, duration = first.setting, first.steps, check.duration
    if factor > 1.0:
        setting, steps, duration = _lengthened(first, factor)
    output = {"save_every": steps // 2} if steps else {"samples": 2}
    problem, half = first.problem, duration / 2.0
    run = external.checked(problem, duration, {**setting, **output}).run
    difference, why = float("nan"), failure(run)
    if run.success:
        system: Any = problem.system
        second_half = replace(
            problem, q0=run.q[1], v0=system.velocity(run.p[1]), t0=problem.t0 + half
        )
        if not external.supports(second_half):
            why = NO_START.format(second_half.t0)
            yield row(study=check.problem.name, quantity=NOT_CUT, t=duration, status=why)
            return
        output = {"save_every": steps // 2} if steps else {"samples": 1}
        again = external.checked(second_half, half, {**setting, **output}).run
        why, first_run = failure(again), first.checked.run
        if again.success:
            difference = max(
                float(np.max(np.abs(end - uncut[-1])) / np.max(np.abs(states - states[0])))
                for end, uncut, states in (
                    (again.q[-1], run.q, first_run.q),
                    (again.p[-1], run.p, first_run.p),
                )
            )
    yield row(
        study=check.problem.name,
        quantity=CUT,
        label=readable_setting(setting),
        t=duration,
        steps=steps,
        value=difference,
        status=why,
    )


def _lengthened(first: LongRun, factor: float) -> tuple[Mapping[str, Any], int, float]:
    """The setting, the number of steps and the duration of a run `factor` times as long."""
    if not first.steps:
        return (
            {**first.setting, "samples": LONG_RUN_PARTS * MOST_PARTS_FACTOR},
            0,
            factor * first.check.long,
        )
    parts = LONG_RUN_PARTS * max(
        1, min(MOST_PARTS_FACTOR, round(factor * first.steps) // LONG_RUN_PARTS)
    )
    save_every = max(1, round(factor * first.steps / parts))
    setting = {**first.setting, "save_every": save_every}
    return setting, parts * save_every, parts * save_every * first.setting["step"]


def _changes(
    check: CheckProblem,
    problem: Problem,
    run: Trajectory,
    setting: Mapping[str, Any],
    name: str,
    quantities: Iterable[str],
) -> Iterator[dict[str, Any]]:
    q, p = (
        np.concatenate([start[None], states])
        for start, states in ((problem.q0, run.q), (problem.p0, run.p))
    )
    formulas = {"energy": check.energy, "angular momentum": angular_momentum}
    for quantity in quantities:
        start, *values = formulas[quantity](problem, q, p).reshape(len(q), -1)
        change, size = np.linalg.norm(values - start, axis=-1), np.linalg.norm(start)
        for seed in SEEDS:
            t, changes = at_random(run.t, change / size, seed)
            for time, error in zip(t, changes, strict=True):
                yield row(
                    study=check.problem.name,
                    quantity=name.format(quantity),
                    label=readable_setting(setting),
                    t=time,
                    value=error,
                    n=seed,
                    status=failure(run),
                )


def at_random(t: Array, values: Array, seed: int) -> tuple[Array, Array]:
    """Mean times and randomly chosen values of groups of GROUP_SIZE successive states.

    The start is in no group. All times and values are returned where the groups hold at most
    LONG_RUN_PARTS states.
    """
    groups = (t.size - 1) // GROUP_SIZE  # the first is the start
    if groups * GROUP_SIZE <= LONG_RUN_PARTS:
        return t, values
    chosen = np.random.default_rng(seed).integers(GROUP_SIZE, size=groups)
    first = 1 + GROUP_SIZE * np.arange(groups)
    middle = np.mean(t[1 : 1 + GROUP_SIZE * groups].reshape(groups, GROUP_SIZE), axis=1)
    return middle, values[first + chosen]


def angular_momentum(problem: Problem, q: Array, p: Array) -> Array:
    """The angular momentum (k, ...) at states (k, ...), by the suite's own formula."""
    return independent_invariants.angular_momentum(problem, q, problem.system.velocity(p))

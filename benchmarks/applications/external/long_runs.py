"""Long runs of an external integrator, for `external.check_runs`: what it conserves, and whether
it comes to the end.

Each problem is run over some twenty revolutions, at the finest setting. One of them, the first that
conserves something, is run on at the same step to MANY steps, or as many as its first run lets
expect within a third of the limit of time; an integrator without steps over OVER times as long.
States are kept at random times, as evenly spaced ones may beat with the motion.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from benchmarks.applications.external.check_problems import CheckProblem
from benchmarks.applications.external.integrator import CheckedRun, ExternalIntegrator
from benchmarks.measures import independent_invariants
from benchmarks.store.frames import failure, row
from benchmarks.work_precision.participants import offered_settings, readable_setting, sampled
from galvi import Problem, Trajectory
from galvi.arrays import Array

LONG = "steps of its longest run"
CUT = "difference of a run that starts half way"
NOT_CUT = "no run that starts half way"
NO_START = "It does not support the problem from half way, t = {:g}."
LONGER = "{} in its longest run"
PARTS = 200  # equal parts of a long run, or up to FINER times as many
FINER, CHOICE = 20, 4  # one in CHOICE of their ends is looked at
SEEDS = (1, 2)
MANY, OVER = 100_000, 6  # steps, and length over that of the first run, of the longest run
CUT_STEPS = 0.2  # of MANY, of the run that is also started half way
SHARE = 1.0 / 3.0  # of the limit of time, as it would be if time grew with the number of steps


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
        """The problem that is run."""
        return self.check.watched or self.check.problem

    def rows(self) -> Iterator[dict[str, Any]]:
        """Relative changes of what the motion conserves."""
        yield from _changes(
            self.check, self.problem, self.checked.run, self.setting, "{}", self.check.conserved
        )


def long_run(external: ExternalIntegrator, check: CheckProblem) -> LongRun | None:
    """The long run on a problem; None where the integrator offers no settings for it."""
    problem = check.watched or check.problem
    offered = offered_settings(external, problem, check.long, PARTS)
    if not offered:
        return None
    step = offered[-1].get("step")
    parts = PARTS * max(1, min(FINER, round(check.long / step) // PARTS if step else FINER))
    setting = sampled(check.long, offered[-1], parts)
    steps = parts * setting["save_every"] if step else 0
    return LongRun(check, setting, external.checked(problem, check.long, setting), steps)


def longest_run(external: ExternalIntegrator, first: LongRun) -> Iterator[dict[str, Any]]:
    """Rows of the run that goes on from this one, in the sense of the same step: LONG, the number
    of steps, or its time for one without steps, and the changes of what it declares to conserve.
    Where the first run failed, only the first row, with its status."""
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
    wanted = MANY / first.steps if first.steps else float(OVER)
    longer = _in_time(external, first, wanted)
    note = (
        ""
        if longer == wanted or wanted <= 1.0
        else ("More would take over a third of the time limit, by the time of its shorter run.")
    )
    steps, duration, run, setting = first.steps, first.check.long, first.checked.run, first.setting
    if longer > 1.0:
        setting, steps, duration = _lengthened(first, longer)
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
    """By which factor to lengthen a run: `factor`, or less where the time limit requires it."""
    # the time of states that are copied at each step grows with the square of their number
    in_time = external.limit / max(first.checked.seconds, 1e-9)
    return min(factor, SHARE * in_time, in_time**0.5)


def cut_run(external: ExternalIntegrator, check: CheckProblem) -> Iterator[dict[str, Any]]:
    """Row CUT of a run over many steps, as fine as the finest for the problem's duration: how far
    its end is from that of another run, which starts half way, from its state and at its time
    there, relative to the way from the start. Where it does not support that start, row NOT_CUT,
    the reason in its status.

    A one-step method differs by rounding, any other by its error; a clock that goes wrong late, by
    the motion.
    """
    first = long_run(external, replace(check, long=check.duration, watched=None))
    if not (first and first.checked.run.success):
        return
    wanted = CUT_STEPS * MANY / first.steps if first.steps else OVER * check.long / check.duration
    longer = _in_time(external, first, wanted)
    setting, steps, duration = first.setting, first.steps, check.duration
    if longer > 1.0:
        setting, steps, duration = _lengthened(first, longer)
    saving = {"save_every": steps // 2} if steps else {"samples": 2}
    problem, half = first.problem, duration / 2.0
    run = external.checked(problem, duration, {**setting, **saving}).run
    difference, why = float("nan"), failure(run)
    if run.success:
        system: Any = problem.system
        later = replace(problem, q0=run.q[1], v0=system.velocity(run.p[1]), t0=problem.t0 + half)
        if not external.supports(later):
            why = NO_START.format(later.t0)
            yield row(study=check.problem.name, quantity=NOT_CUT, t=duration, status=why)
            return
        saving = {"save_every": steps // 2} if steps else {"samples": 1}
        again = external.checked(later, half, {**setting, **saving}).run
        why, way = failure(again), first.checked.run
        if again.success:
            difference = max(
                float(np.max(np.abs(end - uncut[-1])) / np.max(np.abs(states - states[0])))
                for end, uncut, states in ((again.q[-1], run.q, way.q), (again.p[-1], run.p, way.p))
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
        return {**first.setting, "samples": PARTS * FINER}, 0, factor * first.check.long
    parts = PARTS * max(1, min(FINER, round(factor * first.steps) // PARTS))
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
    """A random one of each CHOICE successive values, and the middle of their times; all values
    where there are fewer than CHOICE in a part."""
    groups = (t.size - 1) // CHOICE  # the first is the start
    if groups * CHOICE <= PARTS:
        return t, values
    chosen = np.random.default_rng(seed).integers(CHOICE, size=groups)
    first = 1 + CHOICE * np.arange(groups)
    middle = np.mean(t[1 : 1 + CHOICE * groups].reshape(groups, CHOICE), axis=1)
    return middle, values[first + chosen]


def angular_momentum(problem: Problem, q: Array, p: Array) -> Array:
    """The angular momentum (k, ...) at states (k, ...), by the suite's own formula."""
    return independent_invariants.angular_momentum(problem, q, problem.system.velocity(p))

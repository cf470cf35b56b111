"""Judge a model: the error of its own integrator and step, and what reaches an error cheapest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.applications.judging import bodies, trees
from benchmarks.applications.judging.candidate import Candidate, Kind, Model, Source, UserSetting
from benchmarks.applications.judging.clock import expected, steps_of, timed
from benchmarks.applications.judging.neighbours import horizons
from benchmarks.applications.judging.scan import (
    COLUMNS,
    Limits,
    ScanRow,
    energy_change,
    momentum_change,
    scan,
    unstopped_error,
)
from benchmarks.applications.judging.truth import Agreement, agreements, states_of, thinned
from galvi import Multibody, NBody, Problem, Trajectory, input_checks

YOURS = " (yours)"  # after the name of the own integrator in the table
PIECES = 20  # times at which sources of the truth are compared
SAMPLES = 100  # states of the user's own run and of the candidates, at most
PARTS, EARLY_SECONDS = 50, 10.0  # of the time, of which the first is looked at; seconds of a truth
EARLY_PARTS = 4 * PARTS  # parts of the time, of which a few tell how long the truth will take
FINER, LONG_SECONDS = 20, 2.0  # times as many of the own run at most; seconds of one with fewer
LOST_SHARE = 1e-3  # share of the motion by which sources differ where there is no truth any more


@dataclass(frozen=True, eq=False)
class Judgement:
    """The judgement of a model.

    Attributes
    ----------
    kind
        of model
    problem
        the model, and its duration
    error
        that is required: largest distance from the truth of any part at any time
    source
        of the truth
    agreements
        of the truth with other sources
    own
        the user's: integrator with its step, setting (the step), error, last_error (at the end),
        unstopped_error (at the end of a run that does not stop at the times at which it is
        compared; NaN for equal steps, which these do not change), seconds, seconds_low and
        seconds_high (median and quartiles; NaN where it was timed once), energy and momentum (their
        largest relative changes), status
    own_errors
        t, error: of the user's run
    parts
        the errors of each part in that run
    table
        the own run and all settings that were run; first those that reach the error, by their time
    encounters
        close passages
    horizons
        until when a start of each accuracy predicts the motion to ``error``; empty where
        neighbouring starts are not run
    truth
        the trajectory of the truth
    notes
        what a reader should know of the run, in sentences
    samples
        times at which the candidates are compared with the truth
    engine_hint
        how to install another engine as a source of the truth; "" where there is none
    """

    kind: Kind
    problem: Problem
    duration: float
    error: float
    source: Source
    agreements: tuple[Agreement, ...]
    own: Mapping[str, Any]
    own_errors: pd.DataFrame
    parts: pd.DataFrame
    table: pd.DataFrame
    encounters: pd.DataFrame
    horizons: pd.DataFrame
    truth: Trajectory
    notes: tuple[str, ...] = field(default=())
    samples: int = SAMPLES
    engine_hint: str = ""

    @property
    def truth_agreement(self) -> float:
        """The largest distance between two sources of the truth; NaN with one source only."""
        counted = (
            agreement.largest for agreement in self.agreements if not agreement.source.opinion
        )
        return max(counted, default=math.nan)

    @property
    def trusted_until(self) -> float:
        """The last time before two sources differ by LOST_SHARE of the motion; inf without one."""
        size, ends = self.kind.size(self.truth), []
        for agreement in self.agreements:
            parted = np.flatnonzero(~(agreement.distances < LOST_SHARE * size))
            if parted.size and not agreement.source.opinion:
                ends.append(float(agreement.t[parted[0] - 1]))
        return min(ends, key=lambda t: abs(t - self.problem.t0), default=math.inf)

    @property
    def engines(self) -> tuple[str, ...]:
        """The engines of the truth and of the sources that confirm it."""
        sources = (self.source, *(agreement.source for agreement in self.agreements))
        return tuple(dict.fromkeys(source.engine for source in sources if not source.opinion))

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The fastest row that reaches the error, perhaps the user's; None without one."""
        reached = self.table[self.table["reached"]]
        return None if reached.empty else reached.iloc[0].to_dict()

    @property
    def passed(self) -> bool:
        """Whether the user's own run reaches the error."""
        return bool(self.own["error"] <= self.error)


def judge(
    model: Model | Problem,
    duration: float | None = None,
    error: float | None = None,
    own: Mapping[str, Any] | None = None,
    report: Callable[[str], None] = lambda sentence: None,
    quick: bool = False,
    first: Callable[[Judgement], None] = lambda judgement: None,
) -> Judgement:
    """Judge a model of point masses, or a tree of rigid bodies.

    Parameters
    ----------
    duration
        in the model's time; None: 100 revolutions of its fastest body, or 10 for a tree; negative:
        backwards, as where the own step is. It is lengthened by some of the own integrator's steps,
        to a multiple of 50 to 100 of them
    error
        None: that of the user's own run, or ten times that of the truth if that is larger
    own
        the user's integrator by its engine's name, dt, and its options; what is not given is as in
        the model
    quick
        with shorter looks at other sources of the truth and other integrators, and none at
        neighbouring starts
    first
        called with what is known of the own run before anything is compared with it

    Raises
    ------
    ValueError
        For a model of another kind or that is misread, and for an own integrator that is not known.
    RuntimeError
        Where no source of the truth can be run.
    """
    problem = model.problem if isinstance(model, Model) else model
    kind = kind_of(problem)
    model = model if isinstance(model, Model) else kind.model(problem)
    user_setting = own_setting(kind, model, own or {})
    span = (
        kind.default_duration(problem)
        if duration is None
        else (input_checks.real("duration", duration))
    )
    if span == 0.0:
        raise ValueError("duration must not be 0; received 0. Give the time to cover.")
    span = kind.span(span, float((own or {}).get("dt") or problem.parameters.get("dt", 0.0)))
    samples, steps = SAMPLES, SAMPLES
    if user_setting.step is not None:
        samples, steps = _samples(abs(user_setting.step), span)
        span = math.copysign(steps * abs(user_setting.step), span)
        user_setting = replace(user_setting, step=math.copysign(user_setting.step, span))
        report(f"duration {span:g}, {steps} steps")
    if error is not None:
        error = input_checks.positive("error", error)
    all_sources = kind.sources(model, span, user_setting)
    finer = max(k for k in range(1, FINER + 1) if (steps // samples) % k == 0)
    dense = finer * -(-kind.states(problem, span) // (samples * finer))
    _say_early(kind, user_setting, problem, span, all_sources, report)
    began = time.perf_counter()
    truth, source, stopped = _truth(kind, problem, span, samples * dense, all_sources, report)
    limits = Limits.of(time.perf_counter() - began, quick)
    thin = thinned(truth, dense)
    kind.check(model, thin)
    report(f"own: {user_setting.label}")
    findings, over_time, parts, own_row = _user_run(
        kind, user_setting, problem, span, thinned(truth, dense // finer), samples
    )
    empty_table = pd.DataFrame(columns=list(COLUMNS)).astype({"reached": bool})
    first_error = findings["error"] if error is None else error
    before = Judgement(
        kind, problem, span, first_error, source, (), findings, over_time, parts, empty_table,
        kind.encounters(truth), pd.DataFrame(columns=["start_known_to", "until"]), truth,
        (*model.notes, *kind.notes(model, user_setting, truth)), samples, kind.engine_hint(model),
    )  # fmt: skip
    first(before)
    other_sources = [x for x in all_sources if x is not source and x not in stopped]
    checks = agreements(
        thin, other_sources, kind.errors, min(PIECES, samples), report, limits.source
    )
    checks += [Agreement(failing, thin.t[:1], np.zeros(1), "its run fails") for failing in stopped]
    disagreement = max(
        (agreement.largest for agreement in checks if not agreement.source.opinion), default=0.0
    )
    wanted = float(np.fmax(findings["error"], 10.0 * disagreement)) if error is None else error
    ends = before.horizons
    if limits.neighbours:
        report("neighbouring starts")
        ends = horizons(kind, source, thin, wanted)
    groups = list(kind.candidates(model, span, user_setting))
    table, spread = scan(kind, groups, span, thin, wanted, report, limits, own_row)
    findings = findings | dict(zip(("seconds", "seconds_low", "seconds_high"), spread, strict=True))
    return replace(
        before, error=wanted, own=findings, agreements=tuple(checks), horizons=ends, table=table
    )


def _say_early(
    kind: Kind,
    user_setting: UserSetting,
    problem: Problem,
    span: float,
    all_sources: list[Source],
    report: Callable[[str], None],
) -> None:
    """Where the truth takes long, report how long, and the error in a first part of the time."""
    source = next((candidate for candidate in all_sources if not candidate.opinion), None)
    if source is None:
        return
    steps = max(1, round(span / user_setting.step / PARTS)) if user_setting.step else None
    part = steps * user_setting.step if steps and user_setting.step else span / PARTS
    seconds = expected(
        lambda n: source.run(problem, n * span / EARLY_PARTS, 1), EARLY_PARTS, enough=EARLY_SECONDS
    )
    if seconds < EARLY_SECONDS:
        return
    truth = source.run(problem, part, 1)
    if not truth.success:
        return
    run = Candidate(user_setting.label, user_setting.contender, user_setting.options, steps).run(
        problem, part, 1
    )
    off = float(np.max(kind.errors(run, truth)))
    report(
        f"First answer: after {part:g} of {span:g} your run ({user_setting.label}) is off by "
        f"{off:.2g}. The truth of the whole run takes about {seconds:.0f} s, everything else "
        "several times that"
    )


def _truth(
    kind: Kind,
    problem: Problem,
    span: float,
    samples: int,
    all_sources: list[Source],
    report: Callable[[str], None],
) -> tuple[Trajectory, Source, list[Source]]:
    """The run of the first source that reaches the end, that source, and those that did not."""
    sources = [candidate for candidate in all_sources if not candidate.opinion]
    if not sources:
        raise RuntimeError(f"no source of the truth can be run: install {kind.ENGINE}.")
    stopped = []
    for source in sources:
        report(f"truth: {source.label}")
        truth = source.run(problem, span, samples)
        if truth.success:
            break
        stopped.append(source)
    else:
        raise RuntimeError(f"no source of the truth reaches the end: {truth.status}")
    if np.array_equal(truth.q[-1], problem.q0):
        raise ValueError(f"nothing moves from this start: choose another{kind.ANOTHER}.")
    return truth, source, stopped


def kind_of(problem: Problem) -> Kind:
    """The module for the kind of a model; ValueError for a model that cannot be judged."""
    if isinstance(problem.system, NBody):
        if problem.system.masses.size < 2:
            raise ValueError("judge needs at least two bodies; received one.")
        return bodies
    if isinstance(problem.system, Multibody):
        return trees
    raise ValueError(
        f"judge takes a model of point masses or a tree of rigid bodies; received a "
        f"{type(problem.system).__name__}."
    )


def own_setting(kind: Kind, model: Model, requested: Mapping[str, Any]) -> UserSetting:
    """The user's own integrator and step, as requested or else as in the model.

    Raises
    ------
    ValueError
        For an integrator that is unknown, and for a fixed step that is not given.
    """
    parameters = model.problem.parameters
    of_model = {key: parameters[key] for key in ("integrator", "dt") if key in parameters}
    setting = {**of_model, **requested}
    name = str(setting.pop("integrator", next(iter(kind.INTEGRATORS)))).lower()
    if name not in kind.INTEGRATORS:
        whose = "own" if "integrator" in requested else "the model's own"
        first = next(iter(kind.INTEGRATORS))
        raise ValueError(
            f"{whose} integrator must be one of {', '.join(kind.INTEGRATORS)}; received {name!r}. "
            f"Choose one to judge: --own integrator={first}, in galvi.judge "
            f"own={{'integrator': {first!r}}}."
        )
    step = setting.pop("dt", None)
    contender = kind.own_contender(model, name)
    if name == of_model.get("integrator", "").lower():  # with the options that the model has
        option_names = {*getattr(contender, "options", ()), *getattr(contender, "defaults", ())}
        options = parameters.get("options", {})
        setting = {key: value for key, value in options.items() if key in option_names} | setting
    label = kind.label(contender, setting)
    if name in kind.ADAPTIVE:
        return UserSetting(label, contender, setting, None)
    if step is None:
        raise ValueError(f"own integrator {name} takes equal steps: give dt=... with it.")
    step = input_checks.real("own dt", step)
    if step == 0.0:
        raise ValueError("own dt must not be 0; received 0.")
    return UserSetting(label, contender, setting, step)


def _samples(step: float, span: float) -> tuple[int, int]:
    """The number of saved states of a run in own steps, SAMPLES at most, and the number of steps,
    the least multiple of that number that covers the duration.

    Raises
    ------
    ValueError
        For a step longer than the duration.
    """
    if step > abs(span):
        raise ValueError(f"own dt must be at most the duration {abs(span):g}; received {step:g}.")
    steps = abs(span) / step
    nearest = round(steps) or 1
    fewest_steps = nearest if abs(nearest - steps) < 1e-9 * steps else math.ceil(steps)
    few = range(min(fewest_steps, SAMPLES // 2), min(fewest_steps, SAMPLES) + 1)
    return min(((k, -(-fewest_steps // k) * k) for k in few), key=lambda pair: (pair[1], -pair[0]))


def _user_run(
    kind: Kind,
    user_setting: UserSetting,
    problem: Problem,
    span: float,
    truth: Trajectory,
    samples: int,
) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame, ScanRow]:
    """Findings on the user's run, its errors over time and by part, and its row of the table; at
    the states of the truth, or at ``samples`` of them where the run takes long."""
    steps = None if user_setting.step is None else round(span / user_setting.step)
    candidate = Candidate(
        f"{user_setting.name}{YOURS}", user_setting.contender, user_setting.options, steps
    )
    if steps is not None:  # what a first call costs is not its speed
        steps_of(candidate, problem, span, samples, 2)
    run, seconds, wall = timed(candidate, problem, span, samples)
    finer = (len(truth.t) - 1) // samples
    if finer > 1 and seconds < LONG_SECONDS:
        run = candidate.run(problem, span, samples * finer)
    else:
        truth = thinned(truth, finer)
    worst = kind.errors(run, truth).max(axis=1)
    before_failure = slice(len(np.flatnonzero(np.isfinite(worst))))  # up to where it failed
    error, last, energy = float(np.max(worst)), float(worst[-1]), energy_change(run)
    unstopped = math.nan
    if steps is None and run.success:
        unstopped = unstopped_error(kind, candidate, span, truth)
        error = max(error, unstopped)
    findings = {
        "integrator": user_setting.label,
        "setting": candidate.text(span, samples),
        "error": error,
        "last_error": last,
        "unstopped_error": unstopped,
        "seconds": seconds,
        "seconds_low": math.nan,
        "seconds_high": math.nan,
        "energy": energy,
        "momentum": momentum_change(run),
        "status": run.status,
        "end": run.outcome.end.value,
        "remarks": list(run.outcome.notes),
    }
    status = "" if run.success else run.status
    row = ScanRow(
        candidate.label,
        candidate.text(span, samples),
        candidate,
        error,
        last,
        seconds,
        energy,
        status=status,
        wall=wall,
    )
    over_time = pd.DataFrame({"t": run.t, "error": worst})
    return (
        findings,
        over_time,
        kind.by_part(states_of(run, before_failure), states_of(truth, before_failure)),
        row,
    )

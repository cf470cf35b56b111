"""Judge a model: the error of its own integrator and step, and the cheapest way to an error."""

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

OWN_SUFFIX = " (yours)"  # after the name of the user's integrator in the table
COMPARED_TIMES = 20  # times at which sources of the truth are compared
SAMPLES = 100  # states of the user's own run and of the candidates, at most
DURATION_PARTS = 50  # of which the first is run for an early answer
EARLY_SECONDS = 10.0  # predicted seconds of the truth from which on there is an early answer
TRIAL_PARTS = 4 * DURATION_PARTS  # of which a few are run to predict the time of the truth
MOST_FINER_STATES = 20  # largest ratio of the user's saved states to `samples`
LONG_RUN_SECONDS = 2.0  # a longer run of the user's is not repeated with more states
LOST_FRACTION = 1e-3  # of the motion: sources that differ by more lose the truth


@dataclass(frozen=True, eq=False)
class Judgement:
    """The judgement of a model.

    Attributes
    ----------
    kind
        module for the kind of model
    problem, duration
        the model, and its duration
    error
        required error: largest distance of any part from the truth at any time
    source
        source of the truth
    agreements
        agreement of the truth with each other source
    own
        values of the user's run: integrator with its step, setting, error, last_error (at the end),
        unstopped_error (at the end of a run that does not stop at the times at which it is
        compared; NaN for equal steps, which these do not change), seconds, seconds_low and
        seconds_high (median and quartiles; NaN where it was timed once), energy and momentum (their
        largest relative changes), status
    own_errors
        columns t and error of the user's run
    parts
        the errors of each part in that run
    table
        the user's run and all other settings that were tried; those that reach the error come
        first, in order of time
    encounters
        close passages
    horizons
        time until which a start of each accuracy predicts the motion to ``error``; empty where
        neighbouring starts are not run
    truth
        the trajectory of the truth
    notes
        sentences for the reader on the model and the run
    samples
        number of times at which the candidates are compared with the truth
    engine_hint
        a hint how to install another engine as a source of the truth; "" where there is none
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
            agreement.largest for agreement in self.agreements if not agreement.source.is_galvi
        )
        return max(counted, default=math.nan)

    @property
    def trusted_until(self) -> float:
        """The last compared time before two sources differ by LOST_FRACTION of the motion; inf
        where they never do."""
        size, times = self.kind.size(self.truth), []
        for agreement in self.agreements:
            rows_apart = np.flatnonzero(~(agreement.distances < LOST_FRACTION * size))
            if rows_apart.size and not agreement.source.is_galvi:
                times.append(float(agreement.t[rows_apart[0] - 1]))
        return min(times, key=lambda t: abs(t - self.problem.t0), default=math.inf)

    @property
    def engines(self) -> tuple[str, ...]:
        """The engines of the truth and of the sources compared with it, without galvi."""
        sources = (self.source, *(agreement.source for agreement in self.agreements))
        return tuple(dict.fromkeys(source.engine for source in sources if not source.is_galvi))

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The fastest row that reaches the error, perhaps the user's; None where none does."""
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
        in the model's time; None: 100 revolutions of its fastest body, or 10 for a tree. Negative:
        backwards, as with a negative step. For equal steps it is lengthened, so that 50 to 100
        states (fewer where there are fewer steps) are equal numbers of steps apart
    error
        required error; None: that of the user's run, or ten times the disagreement of the truth's
        sources if that is larger
    own
        the user's integrator by its engine's name, dt, and its options; the model's where absent
    quick
        whether other sources and integrators get less time, and neighbouring starts are not run
    first
        called with the judgement of the user's run before other sources and integrators are run

    Raises
    ------
    ValueError
        For a model of another kind, a model that is misread or in which nothing moves, and an
        integrator, step, duration or error that is not valid.
    RuntimeError
        Where no source of the truth can be run.
    """
    problem = model.problem if isinstance(model, Model) else model
    kind = kind_of(problem)
    model = model if isinstance(model, Model) else kind.model(problem)
    user_setting = own_setting(kind, model, own or {})
    if duration is not None:
        duration = input_checks.real("duration", duration)
    span = kind.default_duration(problem) if duration is None else duration
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
    finer = max(k for k in range(1, MOST_FINER_STATES + 1) if (steps // samples) % k == 0)
    dense = finer * -(-kind.states(problem, span) // (samples * finer))
    _say_early(kind, user_setting, problem, span, all_sources, report)
    began = time.perf_counter()
    truth, source, stopped = _truth(kind, problem, span, samples * dense, all_sources, report)
    limits = Limits.of(time.perf_counter() - began, quick)
    compared_truth = thinned(truth, dense)
    kind.check(model, compared_truth)
    report(f"own: {user_setting.label}")
    findings, over_time, parts, own_row = _user_run(
        kind, user_setting, problem, span, thinned(truth, dense // finer), samples
    )
    empty_table = pd.DataFrame(columns=list(COLUMNS)).astype({"reached": bool})
    first_error = findings["error"] if error is None else error
    preliminary = Judgement(
        kind, problem, span, first_error, source, (), findings, over_time, parts, empty_table,
        kind.encounters(truth), pd.DataFrame(columns=["start_known_to", "until"]), truth,
        (*model.notes, *kind.notes(model, user_setting, truth)), samples, kind.engine_hint(model),
    )  # fmt: skip
    first(preliminary)
    other_sources = [x for x in all_sources if x is not source and x not in stopped]
    checks = agreements(
        compared_truth,
        other_sources,
        kind.errors,
        min(COMPARED_TIMES, samples),
        report,
        limits.source,
    )
    checks += [
        Agreement(failing, compared_truth.t[:1], np.zeros(1), "its run fails")
        for failing in stopped
    ]
    disagreement = max(
        (agreement.largest for agreement in checks if not agreement.source.is_galvi), default=0.0
    )
    wanted = float(np.fmax(findings["error"], 10.0 * disagreement)) if error is None else error
    prediction_ends = preliminary.horizons
    if limits.neighbours:
        report("neighbouring starts")
        prediction_ends = horizons(kind, source, compared_truth, wanted)
    groups = list(kind.candidates(model, span, user_setting))
    table, spread = scan(kind, groups, span, compared_truth, wanted, report, limits, own_row)
    findings = findings | dict(zip(("seconds", "seconds_low", "seconds_high"), spread, strict=True))
    return replace(
        preliminary,
        error=wanted,
        own=findings,
        agreements=tuple(checks),
        horizons=prediction_ends,
        table=table,
    )


def _say_early(
    kind: Kind,
    user_setting: UserSetting,
    problem: Problem,
    span: float,
    all_sources: list[Source],
    report: Callable[[str], None],
) -> None:
    """Where the truth takes EARLY_SECONDS or longer, report its time, and the error of the user's
    run in a first part of the duration."""
    source = next((candidate for candidate in all_sources if not candidate.is_galvi), None)
    if source is None:
        return
    steps = max(1, round(span / user_setting.step / DURATION_PARTS)) if user_setting.step else None
    part = steps * user_setting.step if steps and user_setting.step else span / DURATION_PARTS
    seconds = expected(
        lambda n: source.run(problem, n * span / TRIAL_PARTS, 1), TRIAL_PARTS, enough=EARLY_SECONDS
    )
    if seconds < EARLY_SECONDS:
        return
    truth = source.run(problem, part, 1)
    if not truth.success:
        return
    run = Candidate(user_setting.label, user_setting.contender, user_setting.options, steps).run(
        problem, part, 1
    )
    error = float(np.max(kind.errors(run, truth)))
    report(
        f"First answer: after {part:g} of {span:g} your run ({user_setting.label}) is off by "
        f"{error:.2g}. The truth of the whole run takes about {seconds:.0f} s, everything else "
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
    """The run of the first source that reaches the end, this source, and those that failed before.

    Raises
    ------
    RuntimeError
        Where no source can be run, or none reaches the end.
    ValueError
        Where nothing moves.
    """
    sources = [candidate for candidate in all_sources if not candidate.is_galvi]
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
        For an unknown integrator, and for equal steps without dt or with dt = 0.
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
    """The number of saved states of a run in the user's steps, at most SAMPLES, and the number of
    steps, the least multiple of that number that covers the duration.

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
    """Run the user's setting and compare it with the truth.

    Returns the values of `Judgement.own`, the errors over time, the errors by part, and the row of
    the table. They are at the states of the truth, or at ``samples`` of them where the run takes
    LONG_RUN_SECONDS or longer.
    """
    steps = None if user_setting.step is None else round(span / user_setting.step)
    candidate = Candidate(
        f"{user_setting.name}{OWN_SUFFIX}", user_setting.contender, user_setting.options, steps
    )
    if steps is not None:  # so that the timed run does not compile
        steps_of(candidate, problem, span, samples, 2)
    run, seconds, wall = timed(candidate, problem, span, samples)
    finer = (len(truth.t) - 1) // samples
    if finer > 1 and seconds < LONG_RUN_SECONDS:
        run = candidate.run(problem, span, samples * finer)
    else:
        truth = thinned(truth, finer)
    worst = kind.errors(run, truth).max(axis=1)
    # states past a failure are NaN
    rows_before_failure = slice(len(np.flatnonzero(np.isfinite(worst))))
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
        kind.by_part(states_of(run, rows_before_failure), states_of(truth, rows_before_failure)),
        row,
    )

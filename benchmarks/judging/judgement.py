"""Judge a model: the error of its own integrator and step, and what reaches an error cheapest."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, cast

import numpy as np
import pandas as pd

import galvi
from benchmarks.judging import bodies, trees
from benchmarks.judging.candidate import Candidate, Kind, Own, Source
from benchmarks.judging.neighbours import horizons
from benchmarks.judging.truth import Agreement, agreements
from galvi import Multibody, NBody, Problem, Trajectory, input_checks
from galvi.arrays import Array
from galvi.run.energies import conserves_energy

SAMPLES = 100  # states of the user's own run and of the candidates
PIECES = 20  # times at which sources of the truth are compared
REPEATED = 0.05  # seconds below which a run is timed several times
REPEATS = 3
PATIENCE = 3.0  # seconds for the settings of one integrator
SLOWER = 20.0  # times as long as one that reaches the error: not tried any further
MOST_RUNS = 12  # of one integrator
LOST = 1e-3  # share of the motion by which sources differ where there is no truth any more
LEAST, MOST = 1.4, 4.0  # factors between the steps of two runs
COLUMNS = ("integrator", "setting", "error", "seconds", "energy_error", "reached", "status")


@dataclass(frozen=True, eq=False)
class Judgement:
    """What is found of a model.

    kind         of model
    problem      the model, and its duration
    error        that is asked for, largest distance from the truth of any part at any time
    source       of the truth
    agreements   of the truth with other sources
    own          the user's setting: label, error, seconds, energy_error, momentum_error, status
    own_errors   t, error: of the user's run
    parts        the errors of each part in that run
    table        the candidates that were tried, those that reach the error first, by their time
    encounters   passages that no fixed step resolves
    horizons     until when a start known to so many digits predicts the motion to ``error``
    truth        the trajectory of the truth
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

    @property
    def truth_agreement(self) -> float:
        """The largest distance between two sources of the truth; NaN with one source only."""
        counted = (one.largest for one in self.agreements if not one.source.opinion)
        return max(counted, default=math.nan)

    @property
    def trusted_until(self) -> float:
        """The last time before two sources differ by LOST of the motion; inf where they do not."""
        still = np.broadcast_to(self.problem.q0, self.truth.q.shape)
        size = float(np.max(self.kind.errors(replace(self.truth, q=still), self.truth)))
        ends = [math.inf]
        for one in self.agreements:
            parted = np.flatnonzero(~(one.apart < LOST * size))
            ends += [float(one.t[parted[0] - 1])] if parted.size and not one.source.opinion else []
        return min(ends)

    @property
    def engines(self) -> tuple[str, ...]:
        """Those that the truth rests on."""
        every = (self.source, *(one.source for one in self.agreements))
        return tuple(dict.fromkeys(one.engine for one in every if not one.opinion))

    @property
    def recommended(self) -> Mapping[str, Any] | None:
        """The cheapest candidate that reaches the error; None where none does."""
        reached = self.table[self.table["reached"]]
        return None if reached.empty else reached.iloc[0].to_dict()

    @property
    def passed(self) -> bool:
        """Whether the user's own run reaches the error."""
        return bool(self.own["error"] <= self.error)


def judge(
    problem: Problem,
    duration: float | None = None,
    error: float | None = None,
    own: Mapping[str, Any] | None = None,
    report: Callable[[str], None] = lambda sentence: None,
) -> Judgement:
    """Judge a model of point masses, or a tree of rigid bodies.

    duration  in the model's time; None: 100 revolutions of its fastest body, or 10 for a tree. It
              is lengthened to a multiple of a hundred of the own integrator's steps
    error     None: that of the user's own run, or ten times that of the truth if that is larger
    own       the user's integrator by its engine's name, dt, and its options; what is not given is
              as in the model

    Raises ValueError for a model of another kind, and for an own integrator that is not known;
    RuntimeError where no source of the truth can be run.
    """
    kind = kind_of(problem)
    mine = own_setting(kind, problem, own or {})
    span = kind.default_duration(problem) if duration is None else (
        input_checks.positive("duration", duration)
    )  # fmt: skip
    if mine.step is not None and mine.step > span:
        raise ValueError(f"own dt must be at most the duration {span:g}; received {mine.step:g}.")
    if mine.step is not None:
        span = math.ceil(span / (SAMPLES * mine.step) - 1e-9) * SAMPLES * mine.step
        report(f"duration {span:g}, {SAMPLES} times a whole number of steps")
    if error is not None:
        error = input_checks.positive("error", error)
    every = kind.sources(problem, span)
    sources = [one for one in every if not one.opinion]
    if not sources:
        raise RuntimeError(f"no source of the truth can be run: install {kind.ENGINE}.")
    dense, stopped = -(-kind.states(problem, span) // SAMPLES), []
    for first in sources:
        report(f"truth: {first.label}")
        truth = first.run(problem, span, SAMPLES * dense)
        if truth.success:
            break
        stopped.append(first)
    else:
        raise RuntimeError(f"no source of the truth reaches the end: {truth.status}")
    if np.array_equal(truth.q[-1], problem.q0):
        raise ValueError(
            "nothing moves from this start: choose another; where a model of MuJoCo has keyframes, "
            "--key 0 takes the first one, in galvi.judge key=0."
        )
    thin = _thinned(truth, dense)
    others = [one for one in every if one is not first and one not in stopped]
    checks = agreements(thin, others, kind.errors, PIECES, report)
    report(f"own: {mine.label}")
    found, over_time, parts = _own(kind, mine, problem, span, thin)
    known = max((one.largest for one in checks if not one.source.opinion), default=0.0)
    wanted = np.fmax(found["error"], 10.0 * known) if error is None else error
    report("neighbouring starts")
    ends = horizons(kind, first, thin, wanted)
    table = _scan(kind, problem, span, thin, wanted, report)
    return Judgement(
        kind, problem, span, wanted, first, tuple(checks), found, over_time, parts, table,
        kind.encounters(truth), ends, truth,
    )  # fmt: skip


def kind_of(problem: Problem) -> Kind:
    """What is known of a kind of model; ValueError for one that cannot be judged."""
    if isinstance(problem.system, NBody):
        if problem.system.masses.size < 2:
            raise ValueError("judge needs at least two bodies; received one.")
        return cast(Kind, bodies)
    if isinstance(problem.system, Multibody):
        return cast(Kind, trees)
    raise ValueError(
        f"judge takes a model of point masses or a tree of rigid bodies; received a "
        f"{type(problem.system).__name__}."
    )


def _until(run: Trajectory, states: int) -> Trajectory:
    """The first states of a run."""
    velocities = None if run.velocities is None else run.velocities[:states]
    return replace(run, t=run.t[:states], q=run.q[:states], p=run.p[:states], velocities=velocities)


def _thinned(truth: Trajectory, every: int) -> Trajectory:
    rows = slice(None, None, every)
    return Trajectory(
        truth.problem, truth.t[rows], truth.q[rows], truth.p[rows], velocities=truth.v[rows],
        method=truth.method,
    )  # fmt: skip


def own_setting(kind: Kind, problem: Problem, asked: Mapping[str, Any]) -> Own:
    """The user's own integrator and step, as asked for or as the model has them.

    Raises ValueError for an integrator that is unknown, and for a fixed step that is not given.
    """
    kept = {key: problem.parameters[key] for key in ("integrator", "dt")
            if key in problem.parameters}  # fmt: skip
    given = {**kept, **asked}
    name = str(given.pop("integrator", next(iter(kind.INTEGRATORS)))).lower()
    if name not in kind.INTEGRATORS:
        raise ValueError(
            f"own integrator must be one of {', '.join(kind.INTEGRATORS)}; received {name!r}."
        )
    step = given.pop("dt", None)
    contender = kind.INTEGRATORS[name]
    if name == kept.get("integrator", "").lower():  # with the options that the model has
        known = {*getattr(contender, "options", ()), *getattr(contender, "defaults", ())}
        options = problem.parameters.get("options", {})
        given = {key: value for key, value in options.items() if key in known} | given
    if name in kind.ADAPTIVE:
        return Own(f"{contender.name}, as it is", contender, given, None)
    if step is None:
        raise ValueError(f"own integrator {name} takes equal steps: give dt=... with it.")
    step = input_checks.positive("own dt", step)
    return Own(f"{contender.name}, dt = {step:g}", contender, given, step)


def _own(
    kind: Kind, own: Own, problem: Problem, span: float, truth: Trajectory
) -> tuple[dict[str, Any], pd.DataFrame, pd.DataFrame]:
    """The findings of the user's setting, by part, and over time."""
    steps = None if own.step is None else round(span / own.step)
    run, seconds = _timed(Candidate(own.label, own.contender, own.options, steps), problem, span)
    worst = kind.errors(run, truth).max(axis=1)
    whole = np.flatnonzero(np.isfinite(worst))  # up to where it failed
    found = {
        "integrator": own.label,
        "error": float(np.max(worst)),
        "seconds": seconds,
        "energy_error": _energy_error(run),
        "momentum_error": _momentum_error(run),
        "status": run.status,
    }
    over_time = pd.DataFrame({"t": run.t, "error": worst})
    return found, over_time, kind.by_part(_until(run, len(whole)), _until(truth, len(whole)))


def _timed(candidate: Candidate, problem: Problem, span: float) -> tuple[Trajectory, float]:
    """A run with SAMPLES states, and its seconds, the least of several where it is short."""
    seconds, run = math.inf, None
    if candidate.steps is not None:  # what compiles, and what a first call costs, is not its speed
        step = candidate.setting(span, SAMPLES)["step"]
        brief = {**candidate.options, "step": step, "save_every": 2}
        candidate.contender.run(problem, 2 * step, brief)
    for _ in range(1 + REPEATS):
        clock = time.perf_counter()
        run = candidate.run(problem, span, SAMPLES)
        seconds = min(seconds, time.perf_counter() - clock)
        if seconds > REPEATED:
            break
    assert run is not None
    return run, seconds


def _scan(
    kind: Kind, problem: Problem, span: float, truth: Trajectory,
    wanted: float, report: Callable[[str], None],
) -> pd.DataFrame:  # fmt: skip
    """Each integrator from coarse to fine until it reaches the error, or takes far longer than one
    that does; the rows in order of usefulness."""
    rows: list[tuple[Any, ...]] = []
    best = math.inf
    for settings in kind.candidates(problem, span):
        report(settings[0].label)
        begun = time.perf_counter()
        waiting, last = list(settings), math.nan
        for _ in range(MOST_RUNS):
            if not waiting:
                break
            candidate = waiting.pop(0)
            try:
                run, seconds = _timed(candidate, problem, span)
            except ValueError as refused:
                rows.append((candidate.label, "", math.nan, math.nan, math.nan, False, refused))
                break
            off = float(np.max(kind.errors(run, truth))) if run.success else math.nan
            reached = bool(off <= wanted)
            text = ("adaptive" if candidate.steps is None
                    else f"dt = {candidate.setting(span, SAMPLES)['step']:.4g}")  # fmt: skip
            extra = ", ".join(f"{k} = {v:g}" for k, v in candidate.options.items()
                              if k == "epsilon")  # fmt: skip
            change = _energy_error(run) if run.success else math.nan
            rows.append((candidate.label, f"{text} {extra}".strip(), off, seconds, change, reached,
                         "" if run.success else run.status))  # fmt: skip
            best = min(best, seconds) if reached else best
            if reached or seconds > SLOWER * best or time.perf_counter() - begun > PATIENCE:
                break
            if candidate.steps is not None:
                finer = _factor(off, last, wanted)
                if finer * seconds > PATIENCE:
                    break
                done = candidate.setting(span, SAMPLES)["save_every"] * SAMPLES
                waiting.append(replace(candidate, steps=math.ceil(finer * done)))
            last = off
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    keys = [~table["reached"], table["seconds"].where(table["reached"], table["error"])]
    return table.iloc[np.lexsort(keys[::-1])].reset_index(drop=True)


def _factor(error: float, before: float, wanted: float) -> float:
    """By how many times more steps to take next: what the order asks for that the errors of the
    last two runs, one with MOST times fewer steps at most, suggest; cautiously where it is low."""
    if not (math.isfinite(error) and error > 0.0):
        return 2.0
    order = 2.0
    if math.isfinite(before) and before > error:
        order = max(order, math.log(before / error) / math.log(MOST))
    return min(max((error / wanted) ** (1.0 / order), LEAST), MOST)


def _energy_error(run: Trajectory) -> float:
    """The largest relative change of the energy; NaN where it is not conserved."""
    return _relative(galvi.energy(run)) if conserves_energy(run.problem.system) else math.nan


def _momentum_error(run: Trajectory) -> float:
    """The largest relative change of the angular momentum of point masses; NaN for others."""
    return _relative(galvi.momentum_map(run)) if isinstance(run.problem.system, NBody) else math.nan


def _relative(values: Array) -> float:
    """The largest change from the first, over its size."""
    change = np.abs(values - values[0]).reshape(len(values), -1).max(axis=1)
    size = float(np.max(np.abs(values[0]))) or 1.0
    return float(np.max(change)) / size

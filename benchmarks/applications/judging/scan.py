"""Settings of integrators that reach an error, tried from coarse to fine, and their times."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.judging.candidate import Candidate, Kind
from benchmarks.applications.judging.clock import expected, quartiles, race, steps_of, timed
from benchmarks.applications.judging.truth import states_of, thinned
from galvi import NBody, Trajectory
from galvi.arrays import Array
from galvi.recommend.scan import failure, reached_limit
from galvi.run.energies import conserves_energy

MOST_RUNS = 12  # of one integrator
SMALLEST_FACTOR, LARGEST_FACTOR = 1.4, 4.0  # factors between the steps of two runs
LOW_ORDER = 4  # methods up to this order try twice the step wherever they reach the error
AIMED_FRACTION = 0.8  # of the error, so that one more run is not needed for a last percent
Spread = tuple[float, float, float]  # median and quartiles of seconds
REACHED, MISSED = "reached", "not reached with this setting"


@dataclass(frozen=True)
class Limits:
    """Seconds that parts of a judgement may take, beside the truth and the user's own run.

    Attributes
    ----------
    source
        seconds of each further source of the truth
    integrator
        seconds of the settings of one integrator, without compilation
    candidates
        seconds of all integrators, in equal parts; those that an integrator leaves go to the next
    spread
        seconds of the repeated timings of settings that reach the error
    neighbours
        whether neighbouring starts are run
    """

    source: float
    integrator: float
    candidates: float
    spread: float
    neighbours: bool = True

    @classmethod
    def of(cls, truth: float, quick: bool) -> Limits:
        """The limits where the truth took `truth` seconds."""
        if quick:
            return cls(max(0.5, 0.25 * truth), max(0.3, 0.25 * truth), max(2.0, truth), 1.0, False)
        return cls(max(0.7, truth), max(1.0, truth), max(20.0, 4.0 * truth), max(1.0, truth))


@dataclass(frozen=True)
class ScanRow:
    """A row of the table, without the spread of its times.

    Attributes
    ----------
    candidate
        the setting that was run; None where none was
    last_error
        error at the end
    seconds
        time of one run in its engine
    wall
        seconds of the run with conversions outside the engine
    hard
        whether Newton's method solved steps, so that a run with more steps may take less time
    stopped
        time at which a force reached its limit, where it stopped; else infinite
    """

    integrator: str
    setting: str
    candidate: Candidate | None = None
    error: float = math.nan
    last_error: float = math.nan
    seconds: float = math.nan
    energy: float = math.nan
    reached: bool = False
    status: str = ""
    wall: float = 0.0
    hard: bool = False
    stopped: float = math.inf


COLUMNS = (
    "integrator",
    "setting",
    "error",
    "last_error",
    "seconds",
    "seconds_low",
    "seconds_high",
    "energy",
    "reached",
    "status",
)


def scan(
    kind: Kind,
    groups: Sequence[list[Candidate]],
    span: float,
    truth: Trajectory,
    wanted: float,
    report: Callable[[str], None],
    limits: Limits,
    own_row: ScanRow,
) -> tuple[pd.DataFrame, Spread]:
    """Try the user's integrator at other steps and each other integrator, within their limits.

    Returns the table, the rows that reach the error first, by their time, then others by their
    error; and the spread of the times of the user's run.
    """
    search = Search(kind, span, truth, wanted)
    status = own_row.status or search.status_of(own_row.error)
    rows = [replace(own_row, reached=own_row.error <= wanted, status=status)]
    if own_row.candidate is not None and own_row.candidate.steps is not None:
        report(f"{own_row.integrator}, with other steps")
        rows = search.rows_of([], limits.integrator, rows)
    seconds_left = limits.candidates
    for index, settings in enumerate(groups):
        report(
            f"{settings[0].label} (at most {max(seconds_left, 0.0):.0f} s more, beside compilation)"
        )
        seconds = min(limits.integrator, seconds_left / (len(groups) - index))
        group_rows = search.rows_of(settings, seconds)
        # compilation is not taken from the time of the integrators that follow
        seconds_left -= min(seconds, sum(row.wall for row in group_rows))
        rows += group_rows
    indices_to_time = [k for k, row in enumerate(rows) if row.candidate and (k == 0 or row.reached)]
    report("times, in turns")
    times = race(
        [rows[k].candidate for k in indices_to_time],
        [rows[k].wall for k in indices_to_time],
        truth.problem,
        span,
        search.samples,
        limits.spread,
    )
    spreads = {
        k: quartiles(seconds)
        for k, seconds in zip(indices_to_time, times, strict=True)
        if seconds.size
    }
    single_times = [(row.seconds, math.nan, math.nan) for row in rows]
    table = pd.DataFrame([
        (row.integrator, row.setting, row.error, row.last_error, *spreads.get(k, single_times[k]),
         row.energy, row.reached, row.status)
        for k, row in enumerate(rows)
    ], columns=list(COLUMNS))  # fmt: skip
    keys = [~table["reached"], table["seconds"].where(table["reached"], table["error"])]
    return table.iloc[np.lexsort(keys[::-1])].reset_index(drop=True), spreads.get(
        0, single_times[0]
    )


@dataclass(frozen=True)
class Search:
    """The search for settings of an integrator with an error of at most `wanted`."""

    kind: Kind
    span: float
    truth: Trajectory
    wanted: float

    @property
    def samples(self) -> int:
        return len(self.truth.t) - 1

    def status_of(self, error: float) -> str:
        """The status of a run that reached the end with this error."""
        return REACHED if error <= self.wanted else MISSED

    def rows_of(
        self, waiting: list[Candidate], limit: float, earlier: Sequence[ScanRow] = ()
    ) -> list[ScanRow]:
        """Run settings of an integrator for about `limit` seconds and return `earlier` with their
        rows: coarser settings while all reach the error, else finer ones."""
        rows, waiting = list(earlier), list(waiting)
        while True:
            candidate, why = waiting.pop(0) if not rows else None, ""
            if candidate is None:
                spent = sum(row.wall for row in rows[len(earlier) :])
                candidate, why = self._next(rows, waiting, limit - spent)
            if candidate is None:
                return explained(rows, why)
            label, setting = candidate.label, candidate.text(self.span, self.samples)
            try:
                if candidate.steps is None and not rows:  # compile
                    candidate.run(self.truth.problem, self.span / self.samples, 1)
                if candidate.steps is not None and not rows:
                    enough = 2.0 * limit + 1.0
                    seconds = self._expected(candidate, enough)
                    if seconds > enough:
                        why = f"not tried: it would take about {_rounded(seconds)} s"
                        return [ScanRow(label, setting, status=why)]
                rows.append(self._run_row(candidate))
            except ValueError as refusal:
                return [*rows, ScanRow(label, "", status=str(refusal))]

    def _expected(self, candidate: Candidate, enough: float) -> float:
        problem = self.truth.problem
        return expected(
            lambda n: steps_of(candidate, problem, self.span, self.samples, n),
            candidate.count(self.samples),
            enough,
        )

    def _run_row(self, candidate: Candidate) -> ScanRow:
        run, seconds, wall = timed(candidate, self.truth.problem, self.span, self.samples)
        row = ScanRow(
            candidate.label,
            candidate.text(self.span, self.samples),
            candidate,
            seconds=seconds,
            wall=wall,
            status=run.status,
        )
        if not run.success:
            return replace(row, stopped=_end(run) if reached_limit(run) else math.inf)
        errors = self.kind.errors(run, thinned(self.truth, self.samples // (len(run.t) - 1)))
        worst, failure_text = float(np.max(errors)), failure(run)
        if worst <= self.wanted and candidate.steps is None:
            worst = max(worst, unstopped_error(self.kind, candidate, self.span, self.truth))
        return replace(
            row,
            error=worst,
            last_error=float(np.max(errors[-1])),
            energy=energy_change(run),
            reached=worst <= self.wanted and not failure_text,
            status=failure_text or self.status_of(worst),
            hard=run.counts.get("newton_steps", 0) > 0,
        )

    def _next(
        self, rows: list[ScanRow], waiting: list[Candidate], seconds_left: float
    ) -> tuple[Candidate | None, str]:
        """The candidate to run next in the seconds left and ""; or None, and the reason or ""."""
        last = rows[-1]
        last_steps = last.candidate.count(self.samples) if last.candidate.steps is not None else 0
        if any(row.reached for row in rows):
            goes_on = last_steps and seconds_left >= 0.0 and all(row.reached for row in rows)
            coarser = self._coarser(last, last_steps) if goes_on else None
            return coarser or self._finer(rows, seconds_left), ""
        if len(rows) >= MOST_RUNS:
            return None, f"{MOST_RUNS} settings were tried"
        if len(rows) > 1 and _about_equal(rows[-2].stopped, last.stopped):
            return None, f"a force reaches its limit at t = {last.stopped:.4g}, whatever the step"
        if not last_steps:
            if not waiting:
                return None, "no finer one is offered"
            return (waiting.pop(0), "") if seconds_left > 0.0 else (None, "its time was over")
        order = _order(rows, self.samples)
        factor = _factor(last.error, order, self.wanted)
        factor_in_time = seconds_left / max(last.wall, 1e-9)
        if min(factor, factor_in_time) < SMALLEST_FACTOR:
            needed = last.seconds * (last.error / self.wanted) ** (1.0 / (order or math.inf))
            forecast = f", and as it converges it needs {_rounded(needed)} s a run" if order else ""
            return None, f"its time was over{forecast}"
        return replace(
            last.candidate, steps=math.ceil(min(factor, factor_in_time) * last_steps)
        ), ""

    def _coarser(self, last: ScanRow, last_steps: int) -> Candidate | None:
        """Half as many steps as the last run had; None where that cannot reach the error, has no
        fewer steps, or Newton's method solved steps of the last run."""
        candidate = last.candidate
        coarser = replace(candidate, steps=-(-last_steps // 2))
        order = getattr(candidate.contender, "order", 0)
        is_hopeless = order > LOW_ORDER and 2.0**order * last.error > self.wanted
        return (
            None
            if is_hopeless or last.hard or coarser.count(self.samples) >= last_steps
            else coarser
        )

    def _finer(self, rows: list[ScanRow], seconds_left: float) -> Candidate | None:
        """Twice the largest number of steps where Newton's method solved some of these, since that
        may take less time; otherwise None."""
        finest = max(
            (row for row in rows if row.candidate is not None),
            key=lambda row: row.candidate.count(self.samples),
        )
        if not (
            finest.hard and finest.reached and seconds_left > finest.wall and len(rows) < MOST_RUNS
        ):
            return None
        candidate = finest.candidate
        return replace(candidate, steps=2 * candidate.count(self.samples))


def unstopped_error(kind: Kind, candidate: Candidate, span: float, truth: Trajectory) -> float:
    """The error at the end of a run without stops at the compared times; infinite where it
    fails."""
    run = candidate.run(truth.problem, span, 1)
    if not run.success:
        return math.inf
    last = slice(-1, None)
    return float(np.max(kind.errors(states_of(run, last), states_of(truth, last))))


def _end(run: Trajectory) -> float:
    """The time since the start of the last finite state of a run."""
    finite = np.isfinite(run.q.reshape(len(run.t), -1)).all(axis=1)
    return abs(float(run.t[finite][-1] - run.t[0]))


def _about_equal(first: float, second: float) -> bool:
    """Whether two times are finite and differ by at most 5 %."""
    return (
        math.isfinite(first)
        and math.isfinite(second)
        and abs(first - second) <= 0.05 * max(first, second)
    )


def _rounded(number: float) -> str:
    return f"{float(f'{number:.2g}'):g}"


def explained(rows: list[ScanRow], why: str) -> list[ScanRow]:
    """The rows; where none reaches the error, the reason is the status of the last and of the most
    accurate one, which tables show."""
    measured = [row for row in rows if not math.isnan(row.error)]
    if any(row.reached for row in rows) or not measured:
        return rows
    best, last = min(measured, key=lambda row: row.error), rows[-1]
    error = "failed" if math.isnan(last.error) else f"error {last.error:.2g}"
    text = f"not reached with the finest setting tried, {last.setting}, {error}: {why}"
    explained_rows = [best] if math.isnan(last.error) else [best, last]
    return [replace(row, status=text) if row in explained_rows else row for row in rows]


def _order(rows: list[ScanRow], samples: int) -> float:
    """The order of convergence by the errors of the last two runs; 0 where they do not converge."""
    if len(rows) < 2:
        return 0.0
    before, last = rows[-2:]
    if not before.error > 1.5 * last.error > 0.0:
        return 0.0
    counts = [row.candidate.count(samples) for row in (before, last) if row.candidate is not None]
    return math.log(before.error / last.error) / math.log(counts[1] / counts[0])


def _factor(error: float, order: float, wanted: float) -> float:
    """The factor on the number of steps for the next run; an order below 2 counts as 2."""
    if not (math.isfinite(error) and error > 0.0):
        return 2.0
    return min(
        max((error / (AIMED_FRACTION * wanted)) ** (1.0 / max(order, 2.0)), SMALLEST_FACTOR),
        LARGEST_FACTOR,
    )


def energy_change(run: Trajectory) -> float:
    """The largest relative change of the energy; NaN where it is not conserved."""
    return _relative(galvi.energy(run)) if conserves_energy(run.problem.system) else math.nan


def momentum_change(run: Trajectory) -> float:
    """The largest relative change of the angular momentum of point masses; NaN for others."""
    return _relative(galvi.momentum_map(run)) if isinstance(run.problem.system, NBody) else math.nan


def _relative(values: Array) -> float:
    """The largest change from the first value, over the largest entry of that value."""
    change = np.abs(values - values[0]).reshape(len(values), -1).max(axis=1)
    size = float(np.max(np.abs(values[0]))) or 1.0
    return float(np.max(change)) / size

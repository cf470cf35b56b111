"""What reaches an error, and how cheaply: other integrators from coarse steps to fine."""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.judging.candidate import Candidate, Kind, Model
from galvi import NBody, Problem, Trajectory
from galvi.arrays import Array
from galvi.run.energies import conserves_energy
from references.engine_clock import heard

REPEATED = 0.05  # seconds below which a run is timed several times
REPEATS = 3
SLOWER = 20.0  # times as long as one that reaches the error: not tried any further
MOST_RUNS = 12  # of one integrator
LEAST, MOST = 1.4, 4.0  # factors between the steps of two runs
UNKNOWN = (math.nan,) * 3  # error, seconds and energy
COLUMNS = ("integrator", "setting", "error", "seconds", "energy", "reached", "status")


@dataclass(frozen=True)
class Limits:
    """Seconds that parts of a judgement may take, beside the truth and the user's own run.

    source      another source of the truth
    integrator  the settings of one integrator
    candidates  all of them; none is begun after these
    neighbours  whether neighbouring starts are run
    """

    source: float
    integrator: float
    candidates: float
    neighbours: bool = True

    @classmethod
    def of(cls, truth: float, quick: bool) -> Limits:
        """Where the truth took so many seconds."""
        if quick:
            return cls(max(0.5, 0.25 * truth), max(0.3, 0.25 * truth), max(2.0, truth), False)
        return cls(max(0.7, truth), max(1.0, truth), max(20.0, 4.0 * truth))


def timed(
    candidate: Candidate, problem: Problem, span: float, samples: int,
    worth: Callable[[Trajectory], bool] = lambda run: True,
) -> tuple[Trajectory, float]:  # fmt: skip
    """A run with so many states, and the seconds of its engine, the least of several where it is
    short and worth it: of galvi those of the whole call, of others without our conversion of their
    states."""
    seconds, run = math.inf, None
    if candidate.steps is not None:  # what compiles, and what a first call costs, is not its speed
        _brief(candidate, problem, span, samples)
    for _ in range(1 + REPEATS):
        with heard() as spent:
            clock = time.perf_counter()
            run = candidate.run(problem, span, samples)
            whole = time.perf_counter() - clock
        seconds = min(seconds, spent.seconds or whole)
        if whole > REPEATED or not worth(run):
            break
    assert run is not None
    return run, seconds


def _brief(candidate: Candidate, problem: Problem, span: float, samples: int) -> float:
    """The seconds of a step, measured where it is long."""
    step = candidate.setting(span, samples)["step"]
    clock = time.perf_counter()
    candidate.contender.run(problem, 2 * step, {**candidate.options, "step": step, "save_every": 2})
    return 0.5 * (time.perf_counter() - clock)


def scan(
    kind: Kind, model: Model, span: float, truth: Trajectory, wanted: float,
    report: Callable[[str], None], limits: Limits,
) -> pd.DataFrame:  # fmt: skip
    """Each integrator from coarse to fine until it reaches the error, or would take far longer than
    one that does; the rows in order of usefulness."""
    rows: list[tuple[Any, ...]] = []
    best, begun = math.inf, time.perf_counter()
    for settings in kind.candidates(model, span):
        left = begun + limits.candidates - time.perf_counter()
        report(f"{settings[0].label} (all others end within {max(left, 0.0):.0f} s)")
        if left < 0.0:
            why = "not tried: the time for other integrators was over"
            rows.append((settings[0].label, "", *UNKNOWN, False, why))
            continue
        rows += _one_integrator(
            kind, list(settings), model.problem, span, truth, wanted, best,
            min(limits.integrator, left),
        )  # fmt: skip
        best = min([best, *(row[3] for row in rows if row[5])])
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    keys = [~table["reached"], table["seconds"].where(table["reached"], table["error"])]
    return table.iloc[np.lexsort(keys[::-1])].reset_index(drop=True)


def _one_integrator(
    kind: Kind, waiting: list[Candidate], problem: Problem, span: float, truth: Trajectory,
    wanted: float, best: float, limit: float,
) -> list[tuple[Any, ...]]:  # fmt: skip
    """Its rows. `best` seconds of what reaches the error; ``limit`` seconds for all of them."""
    rows: list[tuple[Any, ...]] = []
    begun, last, samples = time.perf_counter(), math.nan, len(truth.t) - 1

    def reaches(run: Trajectory) -> bool:
        return run.success and bool(np.max(kind.errors(run, truth)) <= wanted)

    for _ in range(MOST_RUNS):
        if not waiting:
            break
        candidate = waiting.pop(0)
        row = (candidate.label, _setting(candidate, span, samples))
        try:
            if not rows and candidate.steps is not None:
                _brief(candidate, problem, span, samples)  # compiles
                expected = candidate.steps * _brief(candidate, problem, span, samples)
                if expected > 2.0 * limit + 1.0:
                    why = f"not tried: it would take about {expected:.2g} s"
                    rows.append((*row, *UNKNOWN, False, why))
                    break
            run, seconds = timed(candidate, problem, span, samples, reaches)
        except ValueError as refused:
            rows.append((candidate.label, "", *UNKNOWN, False, refused))
            break
        off = float(np.max(kind.errors(run, truth))) if run.success else math.nan
        reached = off <= wanted
        change = energy_change(run) if run.success else math.nan
        rows.append((*row, off, seconds, change, reached, "" if run.success else run.status))
        spent = time.perf_counter() - begun
        if reached or seconds > SLOWER * best or spent > limit:
            break
        if candidate.steps is not None:
            order = _order(off, last)
            if order and (off / wanted) ** (1.0 / order) * seconds > min(
                SLOWER * best, 4.0 * (limit - spent)
            ):
                break
            finer = _factor(off, order, wanted)
            done = candidate.setting(span, samples)["save_every"] * samples
            waiting.append(replace(candidate, steps=math.ceil(finer * done)))
        last = off
    return rows


def _setting(candidate: Candidate, span: float, samples: int) -> str:
    text = ("adaptive" if candidate.steps is None
            else f"dt = {candidate.setting(span, samples)['step']:.4g}")  # fmt: skip
    extra = ", ".join(f"{k} = {v:g}" for k, v in candidate.options.items() if k == "epsilon")
    return f"{text} {extra}".strip()


def _order(error: float, before: float) -> float:
    """Of convergence, at least, as the errors of the last two runs suggest, one with MOST times
    fewer steps at most; 0 where they do not converge yet."""
    converging = math.isfinite(before) and before > 1.5 * error > 0.0
    return math.log(before / error) / math.log(MOST) if converging else 0.0


def _factor(error: float, order: float, wanted: float) -> float:
    """By how many times more steps to take next; cautiously where the order is low."""
    if not (math.isfinite(error) and error > 0.0):
        return 2.0
    return min(max((error / wanted) ** (1.0 / max(order, 2.0)), LEAST), MOST)


def energy_change(run: Trajectory) -> float:
    """The largest relative change of the energy; NaN where it is not conserved."""
    return _relative(galvi.energy(run)) if conserves_energy(run.problem.system) else math.nan


def momentum_change(run: Trajectory) -> float:
    """The largest relative change of the angular momentum of point masses; NaN for others."""
    return _relative(galvi.momentum_map(run)) if isinstance(run.problem.system, NBody) else math.nan


def _relative(values: Array) -> float:
    """The largest change from the first, over its size."""
    change = np.abs(values - values[0]).reshape(len(values), -1).max(axis=1)
    size = float(np.max(np.abs(values[0]))) or 1.0
    return float(np.max(change)) / size

"""The Brouwer study: does the energy of a long run walk at random, or drift?

An ensemble of runs whose starts differ by 1e-12 rounds differently at every step. If rounding is
unbiased, the energy error over the ensemble is a random walk: its RMS grows as t^1/2 and its mean
stays at zero within its standard error (Brouwer 1937).
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Protocol

import numpy as np
import pandas as pd

import galvi
from benchmarks.exact_energy import exactly, relative_energy_error
from benchmarks.growth import Growth, growth, rms
from benchmarks.orbit_shape import period
from galvi import Problem
from references import Contender
from references.double_double import DoubleDouble
from references.ias15 import IAS15

COLUMNS: Mapping[str, type] = {
    "contender": str,
    "settings": str,
    "years": float,
    "member": int,
    "sample": int,
    "t": float,
    "error": float,
    "error_of_rounded": float,
    "status": str,
    "commit": str,
    "date": str,
}
SAMPLES = 100
KEPT = tuple(sorted({round(10 ** (k / 10)) for k in range(21)}))  # log-spaced, in two decades
YEARS, QUICK_YEARS = 1e4, 1e3
RUNS, QUICK_RUNS = 32, 8
YEAR = 365.25
SIZE, SEED = 1e-12, 1937
JUPITER = 1  # its place among the bodies
COARSE = 2.0  # an RMS is resolved when it is so many times what the rounding of a state makes of it


@dataclass(frozen=True)
class Sample:
    """Relative energy errors at ``number`` hundredths of a run.

    error             of the state with what its rounding lost, where that is known
    error_of_rounded  of the state as float64 numbers
    status            empty, or why the run ended
    """

    number: int
    error: float
    error_of_rounded: float
    status: str = ""


class Walker(Protocol):
    """Who takes part."""

    @property
    def label(self) -> str:
        """For tables and figures."""

    @property
    def settings(self) -> str:
        """In words."""

    def samples(
        self, problem: Problem, years: float, resume: Path | None, told: Callable[[str], None]
    ) -> Iterator[Sample]:
        """Those of KEPT, in order.

        resume  where to keep the run as it goes and to continue it from; its first sample is then
                the one that was reached
        told    is told of a file there that cannot be used
        """


@dataclass(frozen=True)
class Galerkin:
    """A galvi method with ``per_orbit`` steps, about, in a revolution of Jupiter."""

    method: galvi.Galerkin
    per_orbit: float

    @property
    def label(self) -> str:
        """See `Walker`."""
        return f"galvi degree {self.method.space.degree}, Gauss {self.method.stages}"

    @property
    def settings(self) -> str:
        """See `Walker`."""
        return f"step = Jupiter's period / {self.per_orbit}"

    def samples(
        self, problem: Problem, years: float, resume: Path | None, told: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `Walker`; the state's low parts are those of `galvi.continuation`."""
        length = years * YEAR / SAMPLES
        each = max(1, round(length * self.per_orbit / period(problem, JUPITER)))
        run, done = self._kept(problem, length / each, each, resume, told), 0
        if run is not None:
            done = run.continuation.first // each
            yield _sample(done, run)
        for number in KEPT[KEPT.index(done) + 1 if done else 0 :]:
            steps = (number - done) * each
            if run is None:
                run = galvi.integrate(problem, self.method, length / each, steps, save_every=steps)
            else:
                run = galvi.resume(run, steps, save_every=steps)
            if run.status.startswith("Interrupted"):
                raise KeyboardInterrupt
            done = number
            yield _sample(number, run)
            if not run.success:
                return
            if resume is not None and number != KEPT[-1]:
                galvi.save(run, resume)

    def _kept(
        self, problem: Problem, step: float, each: int, path: Path | None,
        told: Callable[[str], None],
    ) -> Any:  # fmt: skip
        """The run that was saved, if it is this one and stands at a sample."""
        if path is None or not path.exists():
            return None
        try:
            run: Any = galvi.load(path, problem)
        except ValueError as error:
            told(f"{error} The run starts anew.")
            return None
        number, rest = divmod(run.continuation.first, each)
        same = run.step == step and run.method == self.method
        if same and run.success and not rest and number in KEPT:
            return run
        told(f"{path.name} holds another run; this one starts anew.")
        return None


@dataclass(frozen=True)
class Peer:
    """A contender that chooses its steps, in one run: it hands no low parts out, so that a run that
    is stopped and continued would be another one, and worse."""

    contender: Contender

    @property
    def label(self) -> str:
        """See `Walker`."""
        return self.contender.name

    @property
    def settings(self) -> str:
        """See `Walker`."""
        return "default"

    def samples(
        self, problem: Problem, years: float, resume: Path | None, told: Callable[[str], None]
    ) -> Iterator[Sample]:
        """See `Walker`; a run that was interrupted starts anew."""
        masses: Any = problem.system.masses  # type: ignore[attr-defined]
        run = self.contender.run(problem, years * YEAR, {"samples": SAMPLES})
        rows = list(KEPT)
        v = exactly(run.p[rows]) / exactly(masses[:, None])
        errors = relative_energy_error(problem, exactly(run.q[rows]), v)
        for number, error in zip(KEPT, errors.tolist(), strict=True):
            yield Sample(number, error, error, "" if np.isfinite(error) else run.status)


def gauss(degree: int, per_orbit: float) -> Galerkin:
    """Gauss collocation."""
    return Galerkin(galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree)), per_orbit)


# Not a whole number of steps in a revolution: at P/10 the truncation error, 2e-15 here, beats with
# Jupiter's motion over millennia, alike in all runs, which looks like a drift while it lasts.
WALKERS: tuple[Walker, ...] = (gauss(8, 10.38), gauss(16, 6.38), Peer(IAS15))


def member(number: int) -> Problem:
    """The outer solar system with every coordinate and velocity off by about 1e-12 of itself."""
    problem = galvi.problems.outer_solar_system()
    off = np.random.default_rng([SEED, number]).standard_normal((2, *problem.q0.shape))
    return galvi.Problem(
        problem.system,
        problem.q0 * (1.0 + SIZE * off[0]),
        problem.v0 * (1.0 + SIZE * off[1]),
        problem.t0,
        problem.name,
        problem.parameters,
        problem.units,
    )


def row(walker: Walker, years: float, member: int, sample: Sample) -> dict[str, Any]:
    """One line of the study; what a study tells of its commit and date is added there."""
    return {
        "contender": walker.label,
        "settings": walker.settings,
        "years": years,
        "member": member,
        "sample": sample.number,
        "t": years * sample.number / SAMPLES,
        "error": sample.error,
        "error_of_rounded": sample.error_of_rounded,
        "status": sample.status,
        "commit": "",
        "date": "",
    }


def brouwer(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    walkers: Sequence[Walker] = WALKERS,
) -> pd.DataFrame:
    """One row for each contender, run and sampled time (in years), with the columns COLUMNS.

    The start is at t = 0, with an error of zero by definition. A contender whose engine is missing
    has no rows.
    """
    years, runs = (QUICK_YEARS, QUICK_RUNS) if quick else (YEARS, RUNS)
    rows = []
    for walker in walkers:
        if isinstance(walker, Peer) and walker.contender.missing:
            report(f"{walker.label}: {walker.contender.missing}")
            continue
        for number in range(runs):
            report(f"{walker.label}, {walker.settings}, {years:g} years, run {number + 1}")
            seen = walker.samples(member(number), years, None, report)
            rows += [row(walker, years, number, sample) for sample in seen]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def ensembles(frame: pd.DataFrame) -> Iterator[tuple[dict[str, Any], Any, Any]]:
    """(contender, settings, years, commit, date), times (k,) and errors (runs, k) of each ensemble.

    Runs that are not complete are left out; a failed one is NaN from there on.
    """
    for keys, rows in frame.groupby(["contender", "settings", "years", "commit"], sort=False):
        table = rows.pivot(index="member", columns="t", values="error").sort_index(axis=1)
        counts = rows.groupby("member")["sample"].nunique()
        broken = set(rows.loc[rows["status"] != "", "member"])
        whole = [n for n in table.index if counts[n] == len(KEPT) or n in broken]
        if whole:
            names = dict(zip(("contender", "settings", "years", "commit"), keys, strict=True))
            told = {**names, "date": rows["date"].max()}
            yield told, table.columns.to_numpy(float), table.loc[whole].to_numpy(float)


def reading_floor(frame: pd.DataFrame) -> float:
    """RMS energy error that rounding a state to float64 makes; 0 where no contender tells."""
    apart = (frame["error"] - frame["error_of_rounded"]).to_numpy(float)
    apart = apart[np.isfinite(apart) & (apart != 0.0)]
    return float(rms(apart)) if apart.size else 0.0


def growths(frame: pd.DataFrame) -> list[tuple[dict[str, Any], Growth]]:
    """How each ensemble's errors grow; those of rounded states are fitted where they resolve it."""
    floor = reading_floor(frame)
    found = []
    for told, t, errors in ensembles(frame):
        rows = frame[(frame["contender"] == told["contender"]) & (frame["years"] == told["years"])]
        rounded = bool((rows["error"] == rows["error_of_rounded"]).all())
        found.append((told, growth(t, errors, floor=COARSE * floor if rounded else 0.0)))
    return found


def _sample(number: int, run: Any) -> Sample:
    """Where a run of galvi stands."""
    if not run.success:
        return Sample(number, float("nan"), float("nan"), run.status)
    problem = run.problem
    q, q_low, v, v_low = run.continuation.state.reshape(4, *problem.q0.shape)
    exact = relative_energy_error(problem, DoubleDouble(q, q_low), DoubleDouble(v, v_low))
    masses = problem.system.masses[:, None]
    handed_out = exactly(run.p[-1]) / exactly(masses)
    rounded = relative_energy_error(problem, exactly(run.q[-1]), handed_out)
    return Sample(number, float(exact), float(rounded))

"""The growth of round-off in the energy of long runs: ensembles, and their long form."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.checks.claim import Report
from benchmarks.statistics.drift import Growth, growth, rms
from benchmarks.store.provenance import today, version
from benchmarks.store.row_files import RowFiles, stored_rows
from benchmarks.studies.round_off_participants import (
    DAYS_PER_YEAR,
    EIGHT,
    HUNDREDTHS,
    OUTER,
    SAMPLED_HUNDREDTHS,
    Bodies,
    GalerkinParticipant,
    ReferenceParticipant,
    RoundOffParticipant,
    Sample,
    samples_of_rounded_run,
)
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.participants import ensemble, label_beside, readable_setting
from galvi import Problem
from references.rebound.ias15 import IAS15

# The Brouwer study: random walk or drift of the energy in long runs.
#
# An ensemble of runs whose starts differ by 1e-12 rounds differently at every step. If rounding is
# unbiased, the energy error over the ensemble is a random walk: its RMS grows as t^1/2 and its mean
# stays at zero within its standard error (Brouwer 1937).

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
YEARS, QUICK_YEARS = 1e4, 1e3
RUNS, QUICK_RUNS = 32, 8
START_CHANGE, SEED = 1e-12, 1937
STEPS_A_YEAR = 0.5  # fewest for an external integrator without settings: 6 in Jupiter's period
RESOLVED_RATIO = 2.0  # an RMS is resolved above this multiple of the effect of rounding the state


def gauss(
    degree: int, per_orbit: float, chart: Any = None, bodies: Bodies = OUTER
) -> GalerkinParticipant:
    """Gauss collocation of this degree, with `per_orbit` steps in a revolution of the pacing
    planet."""
    return GalerkinParticipant(gauss_collocation(degree, chart).method, per_orbit, bodies)


# Not a whole number of steps in a revolution: at P/10 the truncation error, 2e-15 here, beats with
# Jupiter's motion over millennia, alike in all runs, which looks like a drift while it lasts.
PARTICIPANTS: tuple[RoundOffParticipant, ...] = (
    gauss(8, 10.38),
    gauss(16, 6.38),
    ReferenceParticipant(IAS15),
)
FRAME = gauss(8, 10.38, galvi.KeplerFrame())
LONGER_FACTOR = 10.0  # of the duration in the frame, whose steps take little time
# Over a million years, with few runs: IAS15 takes most of an hour for each.
PLANETS: tuple[RoundOffParticipant, ...] = (
    gauss(16, 1.97, galvi.KeplerFrame(), EIGHT),
    ReferenceParticipant(IAS15, EIGHT),
)
PLANET_RUNS = 4


def member(number: int, bodies: Bodies = OUTER) -> Problem:
    """The planets with positions and velocities perturbed by about 1e-12, relative."""
    problem = bodies.make()
    changes = np.random.default_rng([SEED, number]).standard_normal((2, *problem.q0.shape))
    return problem.with_initial_state(
        problem.q0 * (1.0 + START_CHANGE * changes[0]),
        problem.v0 * (1.0 + START_CHANGE * changes[1]),
    )


def row(
    participant: RoundOffParticipant, years: float, member: int, sample: Sample
) -> dict[str, Any]:
    """One row of the study; the long form adds commit and date."""
    return line(participant.label, participant.settings, years, member, sample)


def line(label: str, settings: str, years: float, member: int, sample: Sample) -> dict[str, Any]:
    """One row of the study, for a contender with this label and these settings."""
    return {
        "contender": label,
        "settings": settings,
        "years": years,
        "member": member,
        "sample": sample.number,
        "t": years * sample.number / HUNDREDTHS,
        "error": sample.error,
        "error_of_rounded": sample.error_of_rounded,
        "status": sample.status,
        "commit": "",
        "date": "",
    }


def brouwer(
    quick: bool = False,
    report: Callable[[str], None] = lambda sentence: None,
    participants: Sequence[RoundOffParticipant] = PARTICIPANTS,
    externals: Sequence[ExternalIntegrator] = (),
    longer: Sequence[RoundOffParticipant] = (),
) -> pd.DataFrame:
    """One row for each contender, run and sampled time (in years), with the columns COLUMNS.

    Parameters
    ----------
    longer
        participants that run LONGER_FACTOR times as long

    Notes
    -----
    The start is at t = 0, with an error of zero by definition. A contender whose engine is missing
    has no rows. External integrators take part where they can, see
    `benchmarks.work_precision.participants.ensemble`.
    """
    years, runs = (QUICK_YEARS, QUICK_RUNS) if quick else (YEARS, RUNS)
    rows = []
    spans = [(participant, years) for participant in participants] + [
        (participant, LONGER_FACTOR * years) for participant in longer
    ]
    for participant, span in spans:
        if isinstance(participant, ReferenceParticipant) and participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
            continue
        for number in range(runs):
            report(f"{participant.label}, {participant.settings}, {span:g} years, run {number + 1}")
            start = member(number, participant.bodies)
            samples = participant.samples(start, span, None, report)
            rows += [row(participant, span, number, sample) for sample in samples]
    labels = [participant.label for participant in participants]
    for external in externals:
        label, starts = label_beside(external, labels), map(member, range(runs))
        report(f"{label}, {years:g} years")
        fewest = round(years * STEPS_A_YEAR)
        external_runs = ensemble(external, starts, years * DAYS_PER_YEAR, HUNDREDTHS, fewest)
        for number, (setting, run) in enumerate(external_runs):
            settings = readable_setting(setting)
            rows += [
                line(label, settings, years, number, sample)
                for sample in samples_of_rounded_run(run)
            ]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def ensembles(observations: pd.DataFrame) -> Iterator[tuple[dict[str, Any], Any, Any]]:
    """(contender, settings, years, commit, date, status), times (k,) and errors (runs, k) of each
    ensemble.

    Incomplete runs are omitted; a failed one is NaN after its failure.
    """
    for keys, rows in observations.groupby(
        ["contender", "settings", "years", "commit"], sort=False
    ):
        table = rows.pivot(index="member", columns="t", values="error").sort_index(axis=1)
        counts = rows.groupby("member")["sample"].nunique()
        broken = set(rows.loc[rows["status"] != "", "member"])
        complete = [n for n in table.index if counts[n] == len(SAMPLED_HUNDREDTHS) or n in broken]
        if complete:
            names = dict(zip(("contender", "settings", "years", "commit"), keys, strict=True))
            why = "; ".join(dict.fromkeys(text for text in rows["status"] if text))
            about = {**names, "date": rows["date"].max(), "status": why}
            yield about, table.columns.to_numpy(float), table.loc[complete].to_numpy(float)


def reading_floor(table: pd.DataFrame) -> float:
    """RMS energy error caused by rounding a state to float64; 0 where no contender reports it."""
    differences = (table["error"] - table["error_of_rounded"]).to_numpy(float)
    differences = differences[np.isfinite(differences) & (differences != 0.0)]
    return float(rms(differences)) if differences.size else 0.0


def growths(table: pd.DataFrame) -> list[tuple[dict[str, Any], Growth]]:
    """The growth of each ensemble's errors; rounded states are fitted where they resolve it."""
    floor = reading_floor(table)
    fits = []
    for about, t, errors in ensembles(table):
        rows = table[
            (table["contender"] == about["contender"]) & (table["years"] == about["years"])
        ]
        rounded = bool((rows["error"] == rows["error_of_rounded"]).all())
        fits.append((about, growth(t, errors, floor=RESOLVED_RATIO * floor if rounded else 0.0)))
    return fits


# The long form of the Brouwer study, a million years, in parts that survive an interruption.
#
# One file of rows for each contender, run and version of the code, updated at every sampled time; a
# run of galvi is saved beside it until complete, and is resumed from there bit-identically.

LONG_YEARS = 1e6
FOLDER = "brouwer"  # subfolder of the studies


@dataclass(frozen=True)
class Part:
    """One run of one contender.

    Attributes
    ----------
    files
        the files of its rows
    version
        version of the code, see `version`
    """

    participant: RoundOffParticipant
    member: int
    years: float
    files: RowFiles
    version: str

    @property
    def name(self) -> str:
        """The name of its files: contender, settings, years, run and version."""
        text = f"{self.participant.label} {self.participant.settings}"
        slug = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-")
        return f"{slug}_{self.years:.0f}-years_run-{self.member:02d}_{self.version}"

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.participant.label}, {self.years:g} years, run {self.member + 1}"

    def is_complete(self) -> bool:
        """Whether all rows exist."""
        return _complete(self._rows())

    def run(self, report: Report) -> None:
        """Compute the missing rows, writing each as soon as it is known."""
        rows, saved = self._rows(), self.files.path(self.name, ".npz")
        self.files.folder.mkdir(parents=True, exist_ok=True)

        def start_anew(sentence: str) -> None:
            report(sentence)
            self.files.set_aside(saved, "the run that was kept there cannot be used")

        start = member(self.member, self.participant.bodies)
        for sample in self.participant.samples(start, self.years, saved, start_anew):
            earlier = [entry for entry in rows if entry["sample"] < sample.number]
            if [entry["sample"] for entry in earlier] != list(
                SAMPLED_HUNDREDTHS[: SAMPLED_HUNDREDTHS.index(sample.number)]
            ):
                saved.unlink(missing_ok=True)  # the rows before it are lost: restart the run
                return self.run(report)
            rows = [*earlier, self._row(sample)]
            self.files.write(self.name, pd.DataFrame(rows, columns=list(COLUMNS)))
            if _complete(rows):
                saved.unlink(missing_ok=True)
            report(f"{self.title}: {rows[-1]['t']:g} years")

    def _rows(self) -> list[dict[str, Any]]:
        table = self.files.read(self.name)
        return [] if table is None else table.to_dict("records")

    def _row(self, sample: Sample) -> dict[str, Any]:
        columns = row(self.participant, self.years, self.member, sample)
        return {**columns, "commit": self.version, "date": today()}


def _complete(rows: Sequence[dict[str, Any]]) -> bool:
    return bool(rows) and (rows[-1]["sample"] == SAMPLED_HUNDREDTHS[-1] or rows[-1]["status"] != "")


def parts(
    studies: Path,
    report: Report,
    years: float = LONG_YEARS,
    runs: int = RUNS,
    participants: Sequence[RoundOffParticipant] = (*PARTICIPANTS, FRAME, *PLANETS),
    code: str | None = None,
) -> list[Part]:
    """All runs, the contenders alternating, so that an interrupted study can be compared.

    Parameters
    ----------
    studies
        the folder of all studies
    code
        version of the code; None for that of the checkout
    """
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    able = []
    for participant in participants:
        if isinstance(participant, ReferenceParticipant) and participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
        else:
            able.append(participant)
    return [
        Part(participant, k, years, files, code)
        for k in range(runs)
        for participant in able
        if k < PLANET_RUNS or participant not in PLANETS
    ]


stored = stored_rows(FOLDER, COLUMNS)

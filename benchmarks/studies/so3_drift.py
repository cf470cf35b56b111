"""A million steps on SO(3): errors of orthogonality, momentum and energy.

A free body from starts that differ by 1e-12, so that they round differently. The exact motion
conserves R^T R = I and R mu; rounding may change them like the square root of the steps.
"""

from __future__ import annotations

import datetime
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.measures.rigid_invariants import energy, orthogonality_defect, spatial_momentum
from benchmarks.statistics.drift import Growth, growth
from benchmarks.store.provenance import version
from benchmarks.store.row_files import RowFiles
from benchmarks.studies.round_off_participants import KEPT, SAMPLES
from benchmarks.work_precision.participants import ensemble, label_beside, readable_setting
from galvi import Problem, Trajectory

COLUMNS: Mapping[str, type] = {
    "contender": str,
    "settings": str,
    "steps": int,
    "member": int,
    "done": int,
    "orthogonality": float,
    "momentum": float,
    "energy": float,
    "status": str,
    "commit": str,
    "date": str,
}
QUANTITIES = {
    "orthogonality": "|R^T R - I|, largest entry",
    "momentum": "|R mu - R0 mu0| / |mu0|",
    "energy": "relative energy error",
}
STEP = 0.21
RUNS, QUICK_RUNS = 8, 4
# Length of an external integrator's runs, in steps of STEP.
EXTERNAL_STEPS, QUICK_EXTERNAL_STEPS = 10_000, 1_000
FEWEST = 5 / 8  # of these, for an external integrator without settings
SIZE, SEED = 1e-12, 1765
FOLDER = "turning"  # subfolder of the studies
LEAST = 1e-17  # replaces an exact zero: less than the rounding of an entry
Report = Callable[[str], None]


@dataclass(frozen=True)
class SpinParticipant:
    """A galvi method and its numbers of steps in each form of the study.

    label   label in tables and figures
    method  the method
    quick, default, long  numbers of steps
    """

    label: str
    method: galvi.Galerkin
    quick: int
    default: int
    long: int


SPACE = galvi.Polynomials(8)
PARTICIPANTS = (
    SpinParticipant("galvi degree 8, Gauss 8, Cayley", galvi.Galerkin(SPACE, galvi.gauss(8)),
           100_000, 1_000_000, 100_000_000),
    SpinParticipant("galvi degree 8, Gauss 8, exponential",
           galvi.Galerkin(SPACE, galvi.gauss(8), galvi.Exponential()),
           100_000, 1_000_000, 100_000_000),
    SpinParticipant("galvi degree 7, Gauss 8, Cayley", galvi.Galerkin(galvi.Polynomials(7),
    galvi.gauss(8)),
           1_000, 10_000, 1_000_000),
)  # fmt: skip


def member(number: int) -> Problem:
    """H's free body with each velocity component perturbed by about 1e-12, relative."""
    body = galvi.problems.free_rigid_body()
    off = np.random.default_rng([SEED, number]).standard_normal(3)
    return Problem(body.system, body.q0, body.v0 * (1.0 + SIZE * off))


def rows(participant: SpinParticipant, number: int, steps: int) -> list[dict[str, Any]]:
    """The rows at the kept hundredths of a run."""
    body = member(number)
    run = galvi.integrate(body, participant.method, STEP, steps, save_every=steps // SAMPLES)
    if run.interrupted:
        raise KeyboardInterrupt
    return run_rows(participant.label, f"h = {STEP:g}", number, steps, run)


def run_rows(
    label: str, settings: str, number: int, steps: int, run: Trajectory
) -> list[dict[str, Any]]:
    """The same for a run with states at every hundredth of `steps` steps."""
    kept, body = list(KEPT), run.problem
    R, p = run.q[kept], run.p[kept]
    start = spatial_momentum(body.q0[None], body.p0[None])
    exact = float(energy(body, body.q0[None], body.p0[None])[0])
    found = {
        "orthogonality": orthogonality_defect(R),
        "momentum": np.linalg.norm(spatial_momentum(R, p) - start, axis=-1) / np.linalg.norm(start),
        "energy": energy(body, R, p) / exact - 1.0,
    }
    return [
        {
            "contender": label, "settings": settings, "steps": steps,
            "member": number, "done": max(1, round(hundredth * steps / SAMPLES)),
            **{name: float(values[k]) for name, values in found.items()},
            "status": "" if run.success else run.status, "commit": "", "date": "",
        }
        for k, hundredth in enumerate(kept)
    ]  # fmt: skip


def external_rows(external: ExternalIntegrator, label: str, quick: bool) -> list[dict[str, Any]]:
    """The same for an external integrator; see `benchmarks.work_precision.participants.ensemble`.

    One with adaptive steps is listed under the number of steps of its first run or, without counts,
    under the hundred parts of its states.
    """
    length = QUICK_EXTERNAL_STEPS if quick else EXTERNAL_STEPS
    starts = map(member, range(QUICK_RUNS if quick else RUNS))
    runs = ensemble(external, starts, length * STEP, SAMPLES, round(length * FEWEST))
    found, steps = [], 0
    for number, (setting, run) in enumerate(runs):
        counted = setting["save_every"] * SAMPLES if "step" in setting else run.counts.get("steps")
        steps = steps or max(SAMPLES, counted or 0)
        found += run_rows(label, readable_setting(setting) or "default", number, steps, run)
    return found


def turning(
    quick: bool = False,
    report: Report = lambda sentence: None,
    participants: Sequence[SpinParticipant] = PARTICIPANTS,
    externals: Sequence[ExternalIntegrator] = (),
) -> pd.DataFrame:
    """The rows of every run, with the columns COLUMNS; external integrators take part where they
    can."""
    found = []
    for participant in participants:
        steps = participant.quick if quick else participant.default
        for number in range(QUICK_RUNS if quick else RUNS):
            report(f"{participant.label}, {steps} steps, run {number + 1}")
            found += rows(participant, number, steps)
    taken = [one.label for one in participants]
    for external in externals:
        length = QUICK_EXTERNAL_STEPS if quick else EXTERNAL_STEPS
        report(f"{external.name}, {length} steps of {STEP:g}")
        found += external_rows(external, label_beside(external, taken), quick)
    return pd.DataFrame(found, columns=list(COLUMNS))


def growths(frame: pd.DataFrame) -> Iterator[tuple[dict[str, Any], str, Growth, float]]:
    """(contender, settings, steps, commit, date), quantity, its growth and largest value for each
    ensemble; growth is that of the RMS over the runs against the number of steps."""
    for known, name, done, errors in ensembles(frame):
        yield known, name, growth(done, errors), float(np.max(np.abs(errors)))


def ensembles(frame: pd.DataFrame) -> Iterator[tuple[dict[str, Any], str, Any, Any]]:
    """(contender, ...), quantity, steps done (k,) and errors (runs, k)."""
    if frame.empty:
        return
    for keys, table in frame.groupby(["contender", "settings", "steps", "commit"], sort=False):
        names = dict(zip(("contender", "settings", "steps", "commit"), keys, strict=True))
        why = "; ".join(dict.fromkeys(text for text in table["status"] if text))
        known = {**names, "date": table["date"].max(), "status": why}
        for name in QUANTITIES:
            wide = table.pivot(index="member", columns="done", values=name).sort_index(axis=1)
            errors = wide.to_numpy(float)
            least = np.where(errors == 0.0, LEAST, errors)
            yield known, name, wide.columns.to_numpy(float), least


@dataclass(frozen=True)
class Part:
    """One run of the long form; an interrupted run is restarted, which costs minutes."""

    participant: SpinParticipant
    member: int
    files: RowFiles
    code: str

    @property
    def name(self) -> str:
        """The name of its file."""
        slug = "-".join(self.participant.label.lower().replace(",", "").split())
        return f"{slug}_{self.participant.long}-steps_run-{self.member:02d}_{self.code}"

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.participant.label}, {self.participant.long} steps, run {self.member + 1}"

    def done(self) -> bool:
        """Whether its rows exist."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Compute and write its rows."""
        report(self.title)
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        table = pd.DataFrame(rows(self.participant, self.member, self.participant.long))
        self.files.write(self.name, table.assign(commit=self.code, date=date))


def parts(
    studies: Path,
    report: Report,
    participants: Sequence[SpinParticipant] = PARTICIPANTS,
    runs: int = RUNS,
    code: str | None = None,
) -> list[Part]:
    """All runs of the long form, the methods alternating."""
    files, code = row_files(studies, report), code or version()
    return [
        Part(participant, number, files, code)
        for number in range(runs)
        for participant in participants
    ]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows; none when the study was not run."""
    return row_files(studies, report).all()


def row_files(studies: Path, report: Report) -> RowFiles:
    """The files of the study's rows."""
    return RowFiles(studies / FOLDER, COLUMNS, report)

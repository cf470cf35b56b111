"""The problems that are published for IRKGL16-SIMD, an implicit Gauss method in vector code.

arXiv 2511.03655: Gauss collocation of 8 stages with constant steps. What is printed there stands
beside what is measured here.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.statistics.timing import once
from benchmarks.store.provenance import version
from benchmarks.store.row_files import RowFiles
from benchmarks.test_problems.planets import outer_planets_of_1969, regular_henon_heiles
from benchmarks.work_precision.galvi_methods import gauss_collocation
from benchmarks.work_precision.problem import frame_label, galvi_label
from galvi import Problem
from galvi.trajectory import COMPLETED

COLUMNS = {
    "problem": str,
    "contender": str,
    "step": float,
    "steps": float,
    "energy_error": float,
    "microseconds": float,
    "seconds": float,
    "status": str,
    "commit": str,
    "date": str,
}
STATES = 500
LONG = 1_000_000  # steps above which a run is cut
SHORT, SHORTEST = 10, 100  # parts of the published length
PRINTED = "IRKGL16-SIMD, as printed"
FOLDER = "published"  # subfolder of the studies
EXPLANATION = (
    "Two problems of arXiv 2511.03655, where Gauss collocation of 8 stages in vector code "
    "(IRKGL16-SIMD) keeps the energy to rounding: the Sun with its inner planets, the outer "
    "planets and Pluto over 1e7 days from JD 2440400.5, in steps of 50 days, and Henon-Heiles with "
    "H = 1/12 over 1e6 times 2 pi in steps of 2 pi / 48. Errors and times of IRKGL16-SIMD are "
    "those that are printed, the times from another machine; galvi's are measured here. The "
    "planets start from DE421 instead of DE430, Henon-Heiles as in Hairer, McLachlan and "
    "Razakarivony (2008); galvi's runs of the latter may be shorter, see their steps: a "
    "random walk grows with the square root."
)
Report = Callable[[str], None]


@dataclass(frozen=True)
class Case:
    """A published problem: its length in steps, and the errors and time of a step printed."""

    problem: Problem
    step: float
    steps: int
    energy_error: float
    microseconds: float
    ours: tuple[tuple[int, Any, float], ...]  # stages, frame, step

    def contenders(self) -> list[tuple[str, Any, float]]:
        """Label, contender and step of galvi's."""
        return [
            (frame_label(s, None) if frame else galvi_label(s), gauss_collocation(s, frame), h)
            for s, frame, h in self.ours
        ]


CASES = (
    Case(
        outer_planets_of_1969(), 50.0, 200_000, 3.6e-15, 2.1,
        ((8, None, 50.0), (8, galvi.KeplerFrame(), 50.0), (8, galvi.KeplerFrame(), 400.0)),
    ),
    Case(
        regular_henon_heiles(), 2.0 * np.pi / 48.0, 48_000_000, 5.6e-14, np.nan,
        ((8, None, 2.0 * np.pi / 48.0), (16, None, 2.0 * np.pi / 8.0)),
    ),
)  # fmt: skip


def published(quick: bool = False, report: Report = lambda sentence: None) -> pd.DataFrame:
    """What is printed, and what galvi does, one row each.

    energy_error  largest, relative, over ``STATES`` states
    microseconds  of a step; seconds, of the run
    """
    rows = []
    for case in CASES:
        report(case.problem.name)
        rows.append(_printed(case))
        cut = (SHORTEST if quick else SHORT) if case.steps > LONG else 1
        rows += [_measured(case, *one, cut) for one in case.contenders()]
    return pd.DataFrame(rows, columns=list(COLUMNS))


def _printed(case: Case) -> dict[str, Any]:
    return {
        "problem": case.problem.name, "contender": PRINTED, "step": case.step,
        "steps": float(case.steps), "energy_error": case.energy_error,
        "microseconds": case.microseconds, "seconds": 1e-6 * case.microseconds * case.steps,
        "status": "", "commit": "", "date": "",
    }  # fmt: skip


def _measured(case: Case, label: str, contender: Any, step: float, cut: int) -> dict[str, Any]:
    """The row of a run over a part of the published length."""
    steps = round(case.steps * case.step / step / cut)
    setting = {"step": step, "save_every": max(1, steps // STATES)}
    contender.run(case.problem, 100.0 * step, {"step": step})  # compiled, and its tables made
    run, seconds = once(lambda: contender.run(case.problem, steps * step, setting))
    energy = galvi.energy(run)
    return {
        "problem": case.problem.name, "contender": label, "step": step, "steps": float(steps),
        "energy_error": float(np.max(np.abs(energy / energy[0] - 1.0))),
        "microseconds": 1e6 * seconds / steps, "seconds": seconds,
        "status": "" if run.status == COMPLETED else run.status, "commit": "", "date": "",
    }  # fmt: skip


@dataclass(frozen=True)
class Part:
    """The whole run of one contender."""

    case: Case
    contender: tuple[str, Any, float]
    files: RowFiles
    code: str

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.case.problem.name}, {self.contender[0]}, step {self.contender[2]:.4g}"

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"{re.sub(r'[^a-z0-9.]+', '-', self.title.lower()).strip('-')}_{self.code}"

    def done(self) -> bool:
        """Whether its row exists."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Make the run and store its row."""
        report(self.title)
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        row = pd.DataFrame([_measured(self.case, *self.contender, 1)], columns=list(COLUMNS))
        self.files.write(self.name, row.assign(commit=self.code, date=date))


def parts(
    studies: Path, report: Report, cases: Sequence[Case] = CASES, code: str | None = None
) -> list[Part]:
    """A part for each contender of each problem, at full length."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    return [Part(case, one, files, code) for case in cases for one in case.contenders()]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows, of any version; none when the study was not run."""
    return RowFiles(studies / FOLDER, COLUMNS, report).all()

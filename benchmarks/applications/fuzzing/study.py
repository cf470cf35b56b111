"""The study of calls at random, in rounds over all targets that survive an interruption."""

from __future__ import annotations

import datetime
import os
from collections.abc import Callable, Mapping
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.applications.fuzzing.trials import Trials, tried
from benchmarks.store.provenance import version
from benchmarks.store.row_files import RowFiles

COLUMNS: Mapping[str, type] = {
    "target": str,
    "seed": int,
    "calls": int,
    "returned": int,
    "refused": int,
    "finding": str,
    "example": str,
    "commit": str,
    "date": str,
}
FOLDER = "fuzz"  # subfolder of the studies
CALLS = 1000  # of each target in a round
FEWER = {
    "an archive of REBOUND's": 50,  # each of which is read in a process of its own
    "events": 200,
    "forces": 200,  # of which functions in Python are called
    "clocks": 100,  # which compile a kernel for each system and clock, or call functions
}
ALL = 1_000_000  # calls of the long form
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """One round, which is also the seed of its calls."""

    round: int
    targets: tuple[str, ...]
    files: RowFiles
    code: str

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"round-{self.round:03d}_{self.code}"

    @property
    def title(self) -> str:
        """The title for progress output."""
        return (
            f"Calls at random, {CALLS} of most of {len(self.targets)} targets, round {self.round}"
        )

    def done(self) -> bool:
        """Whether its rows exist."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> list[str]:
        """Call the targets and write the rows; returns a sentence for each finding."""
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        rows: list[dict[str, object]] = []
        with ThreadPoolExecutor(os.cpu_count()) as pool:
            calls = [FEWER.get(name, CALLS) for name in self.targets]
            found = pool.map(lambda *one: tried(*one, self.round), self.targets, calls)
            for name, trials in zip(self.targets, found, strict=True):
                report(f"{name}: {trials.returned} returned, {trials.refused} refused")
                rows += self._rows(name, trials)
        frame = pd.DataFrame(rows).assign(commit=self.code, date=date)
        self.files.write(self.name, frame)
        wrong = frame[frame["finding"] != ""]
        return [f"{row.target}: {row.finding}: {row.example}" for row in wrong.itertuples()]

    def _rows(self, name: str, trials: Trials) -> list[dict[str, object]]:
        """A row of counts, without a finding, and one for each finding, without counts."""
        known = {"target": name, "seed": self.round}
        first = {"calls": trials.calls, "returned": trials.returned, "refused": trials.refused}
        found = [
            known | dict.fromkeys(first, 0) | {"finding": what, "example": example}
            for what, example in trials.findings.items()
        ]
        return [known | first | {"finding": "", "example": ""}, *found]


def parts(studies: Path, report: Report) -> list[Part]:
    """All rounds; none without hypothesis."""
    try:
        from benchmarks.applications.fuzzing.targets import TARGETS
    except ModuleNotFoundError as missing:
        report(
            f"Calls at random: not run, {missing.name} is not installed; `make install` does it."
        )
        return []
    files, code, targets = row_files(studies, report), version(), tuple(TARGETS)
    rounds = -(-ALL // (CALLS * len(targets)))
    return [Part(number, targets, files, code) for number in range(1, rounds + 1)]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows; none when the study was not run."""
    return row_files(studies, report).all()


def row_files(studies: Path, report: Report) -> RowFiles:
    """The files of the study's rows."""
    return RowFiles(studies / FOLDER, COLUMNS, report)

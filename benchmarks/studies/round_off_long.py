"""The long form of the Brouwer study, a million years, in parts that survive an interruption.

One file of rows for each contender, run and version of the code, updated at every sampled time; a
run of galvi is saved beside it until complete, and is resumed from there bit-identically.
"""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.provenance import version
from benchmarks.store.row_files import RowFiles
from benchmarks.studies.round_off import (
    COLUMNS,
    FRAME,
    PARTICIPANTS,
    PLANET_RUNS,
    PLANETS,
    RUNS,
    member,
    row,
)
from benchmarks.studies.round_off_participants import (
    KEPT,
    ReferenceParticipant,
    RoundOffParticipant,
    Sample,
)

YEARS = 1e6
FOLDER = "brouwer"  # subfolder of the studies
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """One run of one contender.

    files    the files of its rows
    version  version of the code, see `version`
    """

    participant: RoundOffParticipant
    member: int
    years: float
    files: RowFiles
    version: str

    @property
    def name(self) -> str:
        """The name of its files: contender, settings, years, run and version."""
        words = f"{self.participant.label} {self.participant.settings}"
        slug = re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-")
        return f"{slug}_{self.years:.0f}-years_run-{self.member:02d}_{self.version}"

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.participant.label}, {self.years:g} years, run {self.member + 1}"

    def done(self) -> bool:
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
            earlier = [each for each in rows if each["sample"] < sample.number]
            if [each["sample"] for each in earlier] != list(KEPT[: KEPT.index(sample.number)]):
                saved.unlink(missing_ok=True)  # the rows before it are lost: restart the run
                return self.run(report)
            rows = [*earlier, self._row(sample)]
            self.files.write(self.name, pd.DataFrame(rows, columns=list(COLUMNS)))
            if _complete(rows):
                saved.unlink(missing_ok=True)
            report(f"{self.title}: {rows[-1]['t']:g} years")

    def _rows(self) -> list[dict[str, Any]]:
        frame = self.files.read(self.name)
        return [] if frame is None else frame.to_dict("records")

    def _row(self, sample: Sample) -> dict[str, Any]:
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        known = row(self.participant, self.years, self.member, sample)
        return {**known, "commit": self.version, "date": date}


def _complete(rows: Sequence[dict[str, Any]]) -> bool:
    return bool(rows) and (rows[-1]["sample"] == KEPT[-1] or rows[-1]["status"] != "")


def parts(
    studies: Path,
    report: Report,
    years: float = YEARS,
    runs: int = RUNS,
    participants: Sequence[RoundOffParticipant] = (*PARTICIPANTS, FRAME, *PLANETS),
    code: str | None = None,
) -> list[Part]:
    """All runs, the contenders alternating, so that an interrupted study can be compared.

    studies  the folder of all studies
    code     version of the code; None for that of the checkout
    """
    files, code = row_files(studies, report), code or version()
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


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows, of any version; none when the study was not run."""
    return row_files(studies, report).all()


def row_files(studies: Path, report: Report) -> RowFiles:
    """The files of the study's rows."""
    return RowFiles(studies / FOLDER, COLUMNS, report)

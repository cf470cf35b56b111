"""The long form of the free-body drift: 100,000 turns, one stored run per contender."""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.store.provenance import version
from benchmarks.store.row_files import RowFiles
from benchmarks.studies.free_body_drift import COLUMNS, PARTICIPANTS, DriftParticipant, body_rows

MANY_TURNS = 100_000
FOLDER = "free_spin"  # subfolder of the studies
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """One contender's long run.

    files  the files of its rows
    code   version of the code
    """

    participant: DriftParticipant
    turns: int
    files: RowFiles
    code: str

    @property
    def title(self) -> str:
        """The title for progress output."""
        return f"{self.participant.label}, {self.turns} turns"

    @property
    def name(self) -> str:
        """The name of its file: contender, turns, engine and version."""
        words = f"{self.title} {self.participant.engine}"
        return f"{re.sub(r'[^a-z0-9.]+', '-', words.lower()).strip('-')}_{self.code}"

    def done(self) -> bool:
        """Whether its rows exist."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Make the run and store its rows."""
        report(self.title)
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        rows = pd.DataFrame(body_rows(self.participant, self.turns), columns=list(COLUMNS))
        self.files.write(self.name, rows.assign(commit=self.code, date=date))


def parts(
    studies: Path,
    report: Report,
    turns: int = MANY_TURNS,
    participants: Sequence[DriftParticipant] = PARTICIPANTS,
    code: str | None = None,
) -> list[Part]:
    """A part for each available contender."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    for participant in participants:
        if participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
    return [Part(one, turns, files, code) for one in participants if not one.contender.missing]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows, of any version; none when the study was not run."""
    return RowFiles(studies / FOLDER, COLUMNS, report).all()

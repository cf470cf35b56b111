"""The long spins over 100,000 turns, in parts: one for each contender, kept when it is done."""

from __future__ import annotations

import datetime
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.store.row_files import RowFiles
from benchmarks.studies.free_body_drift import COLUMNS, PARTICIPANTS, DriftParticipant, body_rows
from benchmarks.studies.round_off_long import version

MANY_TURNS = 100_000
FOLDER = "free_spin"  # below that of all studies
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """One contender's long run.

    files  where its rows go
    code   version of the code
    """

    participant: DriftParticipant
    turns: int
    files: RowFiles
    code: str

    @property
    def title(self) -> str:
        """For progress."""
        return f"{self.participant.label}, {self.turns} turns"

    @property
    def name(self) -> str:
        """Of its file: contender, turns, engine and version."""
        words = f"{self.title} {self.participant.engine}"
        return f"{re.sub(r'[^a-z0-9.]+', '-', words.lower()).strip('-')}_{self.code}"

    def done(self) -> bool:
        """Whether its rows are there."""
        return self.files.read(self.name) is not None

    def run(self, report: Report) -> None:
        """Turn the body and keep the rows."""
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
    """One for each contender that is here."""
    files, code = RowFiles(studies / FOLDER, COLUMNS, report), code or version()
    for participant in participants:
        if participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
    return [Part(one, turns, files, code) for one in participants if not one.contender.missing]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """Every row that is there, of any version; none when the study was not run."""
    return RowFiles(studies / FOLDER, COLUMNS, report).all()

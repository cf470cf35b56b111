"""The Brouwer study over a million years, in parts that survive an interruption.

One file of rows for each contender, run and version of the code, renewed at every sampled time; a
run of galvi is kept beside it until it is complete, and goes on from there bit for bit.
"""

from __future__ import annotations

import datetime
import hashlib
import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.provenance import ROOT, commit
from benchmarks.store.row_files import RowFiles
from benchmarks.studies.round_off import COLUMNS, PARTICIPANTS, RUNS, member, row
from benchmarks.studies.round_off_participants import (
    KEPT,
    ReferenceParticipant,
    RoundOffParticipant,
    Sample,
)

YEARS = 1e6
FOLDER = "brouwer"  # below that of all studies
SOURCES = ("galvi", "references", "benchmarks")  # what the rows depend on
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """One run of one contender.

    files    where its rows go
    version  of the code, see `version`
    """

    participant: RoundOffParticipant
    member: int
    years: float
    files: RowFiles
    version: str

    @property
    def name(self) -> str:
        """Of its files: contender, settings, years, run and version."""
        words = f"{self.participant.label} {self.participant.settings}"
        slug = re.sub(r"[^a-z0-9]+", "-", words.lower()).strip("-")
        return f"{slug}_{self.years:.0f}-years_run-{self.member:02d}_{self.version}"

    @property
    def title(self) -> str:
        """For progress."""
        return f"{self.participant.label}, {self.years:g} years, run {self.member + 1}"

    def done(self) -> bool:
        """Whether every row is there."""
        return _complete(self._rows())

    def run(self, report: Report) -> None:
        """Compute the rows that are missing, writing each as soon as it is known."""
        rows, saved = self._rows(), self.files.path(self.name, ".npz")
        self.files.folder.mkdir(parents=True, exist_ok=True)

        def start_anew(sentence: str) -> None:
            report(sentence)
            self.files.set_aside(saved, "the run that was kept there cannot be used")

        for sample in self.participant.samples(member(self.member), self.years, saved, start_anew):
            earlier = [each for each in rows if each["sample"] < sample.number]
            if [each["sample"] for each in earlier] != list(KEPT[: KEPT.index(sample.number)]):
                saved.unlink(missing_ok=True)  # rows before it are lost: the run starts anew
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
    participants: Sequence[RoundOffParticipant] = PARTICIPANTS,
    code: str | None = None,
) -> list[Part]:
    """All runs, the contenders in turn, so that what an interruption leaves can be compared.

    studies  folder of all studies' rows
    code     version to file the rows under; None asks the checkout
    """
    files, code = row_files(studies, report), code or version()
    able = []
    for participant in participants:
        if isinstance(participant, ReferenceParticipant) and participant.contender.missing:
            report(f"{participant.label}: {participant.contender.missing}")
        else:
            able.append(participant)
    return [Part(participant, k, years, files, code) for k in range(runs) for participant in able]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """Every row that is there, of any version; none when the study was not run."""
    return row_files(studies, report).all()


def row_files(studies: Path, report: Report) -> RowFiles:
    """Where the rows are."""
    return RowFiles(studies / FOLDER, COLUMNS, report)


def version() -> str:
    """The commit's first digits; where files differ from it, '+' and a digest of the sources."""
    head = commit()
    digits, _, dirty = head.partition("+")
    return f"{digits[:12]}+{_digest()}" if dirty or head == "unknown" else digits[:12]


def _digest() -> str:
    digest = hashlib.sha256()
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:8]

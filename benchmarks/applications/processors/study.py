"""The study of processors: the same runs, compiled for each, and how far apart they end."""

from __future__ import annotations

import datetime
import json
import os
import subprocess
import sys
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.store.provenance import ROOT, version
from benchmarks.store.row_files import RowFiles

# NUMBA_CPU_NAME -> OPENBLAS_CORETYPE; "" is the processor of this machine
PROCESSORS = {
    "": "",
    "generic": "Prescott",
    "haswell": "Haswell",
    "skylake-avx512": "SkylakeX",
    "znver4": "Zen",
}
HOST = "this machine's"
COLUMNS: Mapping[str, type] = {
    "case": str,
    "processor": str,
    "units": float,
    "iterations": int,
    "status": str,
    "commit": str,
    "date": str,
}
FOLDER = "processors"  # subfolder of the studies
PATIENCE = 1800.0  # seconds to compile every kernel and to run
Report = Callable[[str], None]


@dataclass(frozen=True)
class Part:
    """The runs of all processors."""

    files: RowFiles
    code: str

    title = "The same runs on each processor"

    def done(self) -> bool:
        """Whether its rows exist."""
        return self.files.read(self.code) is not None

    def run(self, report: Report) -> list[str]:
        """Run the cases for each processor; returns a sentence for each status that differs."""
        ends = {}
        for processor in PROCESSORS:
            report(processor or HOST)
            ends[processor] = _ends(processor)
        date = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d")
        rows = [row for processor in PROCESSORS for row in compared(ends, processor)]
        frame = pd.DataFrame(rows).assign(commit=self.code, date=date)
        self.files.write(self.code, frame)
        return [
            f"{row.case} for {row.processor}: {row.status}"
            for row in frame[~frame["status"].isin(["", NOT_HERE])].itertuples()
        ]


NOT_HERE = "not run: this machine lacks instructions of it"


def compared(ends: Mapping[str, Any], processor: str) -> list[dict[str, Any]]:
    """A row for each case: the distance of its end from this machine's own.

    units  largest difference of a coordinate in units in the last place of the largest one, or of a
           momentum likewise
    """
    if ends[processor] is None:
        return [_row("all", processor, float("nan"), 0, NOT_HERE)]
    rows = []
    for case, here in ends[""].items():
        there = ends[processor][case]
        units = max(_apart(here[name], there[name]) for name in ("q", "p"))
        status = "" if here["status"] == there["status"] else there["status"]
        rows.append(_row(case, processor, units, there["iterations"], status))
    return rows


def _apart(here: list[str], there: list[str]) -> float:
    a, b = (np.array([float.fromhex(x) for x in one]) for one in (here, there))
    return float(np.max(np.abs(b - a)) / np.spacing(np.max(np.abs(a))))


def _row(case: str, processor: str, units: float, iterations: int, status: str) -> dict[str, Any]:
    name = processor or HOST
    return {
        "case": case,
        "processor": name,
        "units": units,
        "iterations": iterations,
        "status": status,
    }


def _ends(processor: str) -> Any:
    """What `processors.cases` writes; None where the machine lacks an instruction."""
    done = subprocess.run(
        [sys.executable, "-m", "benchmarks.applications.processors.cases"], cwd=ROOT,
        env=environment(processor), capture_output=True, text=True, timeout=PATIENCE,
    )  # fmt: skip
    if done.returncode < 0:  # ended by a signal: an illegal instruction
        return None
    if done.returncode:
        raise RuntimeError(done.stderr[-1000:])
    return json.loads(done.stdout)


def environment(processor: str) -> dict[str, str]:
    """Of a process whose kernels are compiled for a processor.

    With its name alone numba would still use every instruction that this machine has.
    """
    given = {
        "NUMBA_CPU_NAME": processor,
        "NUMBA_CPU_FEATURES": "",
        "OPENBLAS_CORETYPE": PROCESSORS[processor],
    }
    return {**os.environ, "PYTHONPATH": str(ROOT), **(given if processor else {})}


def parts(studies: Path, report: Report) -> list[Part]:
    """The one part."""
    return [Part(row_files(studies, report), version())]


def stored(studies: Path, report: Report) -> pd.DataFrame:
    """All stored rows; none when the study was not run."""
    return row_files(studies, report).all()


def row_files(studies: Path, report: Report) -> RowFiles:
    """The files of the study's rows."""
    return RowFiles(studies / FOLDER, COLUMNS, report)

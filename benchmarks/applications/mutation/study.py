"""The study of the mutants: a sample, tried in parts that survive an interruption."""

from __future__ import annotations

import hashlib
import os
import tempfile
from collections.abc import Mapping, Set
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from pathlib import Path

import pandas as pd

from benchmarks.applications.mutation.mutants import Mutant, sampled
from benchmarks.applications.mutation.reach import Reach, copied, recorded
from benchmarks.applications.mutation.trial import KILLED, Outcome, tried
from benchmarks.checks.claim import Report
from benchmarks.store.provenance import ROOT, digest_of_sources, today, version
from benchmarks.store.row_files import RowFiles, stored_rows

COLUMNS: Mapping[str, type] = {
    "sample": str,
    "file": str,
    "line": int,
    "operator": str,
    "before": str,
    "after": str,
    "mutant": str,
    "outcome": str,
    "test": str,
    "seconds": float,
    "tests": str,
    "seed": int,
    "commit": str,
    "date": str,
}
FOLDER = "mutants"  # subfolder of the studies
SEED = 1
SAMPLES = {
    "integrators": (("galvi",), 500),
    "judges and references": (
        ("benchmarks/checks", "benchmarks/statistics", "benchmarks/measures", "references"),
        100,
    ),
}
ENGINES = "rebound", "mujoco", "heyoka", "pinocchio"  # whose tests are skipped without them
BATCH = 50
SAME = "equivalent"  # an outcome, of those in EQUIVALENT
EQUIVALENT = Path(__file__).with_name("equivalent.csv")


@dataclass(frozen=True)
class Part:
    """A few mutants of one sample; those that survive are tried again when the tests change, those
    once killed are not: their row has the commit of the tests that did it. Equivalent ones are not
    tried."""

    sample: str
    number: int
    mutants: tuple[Mutant, ...]
    files: RowFiles
    tests: str

    @property
    def name(self) -> str:
        """The name of its file."""
        return f"{self.sample.replace(' ', '-')}_{self.number:02d}"

    @property
    def title(self) -> str:
        """The title in progress output."""
        return f"Mutants of the {self.sample}, {BATCH} at a time: {self.number + 1}"

    def done(self) -> bool:
        """Whether the outcome of each mutant is known."""
        return len(self._known()) == len(self.mutants)

    def run(self, report: Report) -> None:
        """Try what is missing, and write the rows after each."""
        known = self._known()
        reach = _reach(self.files.folder / "reach" / self.tests, report)
        left = [one for one in self.mutants if one.code not in known]
        with (
            tempfile.TemporaryDirectory(prefix="galvi-mutants-") as place,
            ThreadPoolExecutor(os.cpu_count()) as pool,
        ):
            sources = copied(ROOT, Path(place) / "sources")
            outcomes = pool.map(lambda one: self._tried(one, reach, sources), left)
            for mutant, outcome in zip(left, outcomes, strict=True):
                report(f"{outcome.outcome}: {mutant}")
                known[mutant.code] = self._row(mutant, outcome)
                rows = [known[one.code] for one in self.mutants if one.code in known]
                self.files.write(self.name, pd.DataFrame(rows, columns=list(COLUMNS)))

    def _known(self) -> dict[str, dict[str, object]]:
        frame = self.files.read(self.name)
        if frame is None:
            return {}
        wanted = {one.code for one in self.mutants}
        same = {one.code for one in self.mutants if _equivalent(one)}
        return {
            str(row["mutant"]): row
            for row in frame.to_dict("records")
            if row["mutant"] in wanted
            and (row["outcome"] == KILLED or row["tests"] == self.tests or row["mutant"] in same)
        }

    def _tried(self, mutant: Mutant, reach: Reach, sources: Path) -> Outcome:
        return Outcome(SAME, "", 0.0) if _equivalent(mutant) else tried(mutant, reach, sources)

    def _row(self, mutant: Mutant, outcome: Outcome) -> dict[str, object]:
        return {
            "sample": self.sample,
            "file": mutant.file,
            "line": mutant.line,
            "operator": mutant.operator.removeprefix("core/"),
            "before": mutant.before,
            "after": mutant.after,
            "mutant": mutant.code,
            "outcome": outcome.outcome,
            "test": outcome.test,
            "seconds": outcome.seconds,
            "tests": self.tests,
            "seed": SEED,
            "commit": version(),
            "date": today(),
        }


def parts(studies: Path, report: Report, seed: int = SEED) -> list[Part]:
    """All parts, in an order in which each beginning is a sample too; none without cosmic-ray."""
    files, tests, found = row_files(studies, report), digest_of_sources(("tests",)), []
    absent = {f"references/{name}" for name in ENGINES if find_spec(name) is None}
    for sample, (folders, count) in SAMPLES.items():
        try:
            mutants = sampled(ROOT, folders, count, seed, absent)
        except ModuleNotFoundError as missing:
            report(f"Mutants: not run, {missing.name} is not installed; `make mutants` does it.")
            return []
        mutants.sort(key=lambda one: hashlib.sha256(one.code.encode()).digest())
        for k in range(0, len(mutants), BATCH):
            few = tuple(mutants[k : k + BATCH])
            found.append(Part(sample, k // BATCH, few, files, tests))
    return found


stored = stored_rows(FOLDER, COLUMNS)


def row_files(studies: Path, report: Report) -> RowFiles:
    """The files of the study's rows."""
    return RowFiles(studies / FOLDER, COLUMNS, report)


def _equivalent(mutant: Mutant) -> bool:
    return (mutant.file, mutant.before, mutant.after) in equivalents()


@lru_cache(maxsize=1)
def equivalents() -> Set[tuple[str, str, str]]:
    """File, line and changed line of each mutant in EQUIVALENT."""
    table = pd.read_csv(EQUIVALENT, dtype=str, keep_default_na=False)
    return set(table[["file", "before", "after"]].itertuples(index=False, name=None))


def _reach(folder: Path, report: Report) -> Reach:
    if not (folder / "durations.json").exists():
        report("all tests once, with coverage")
        recorded(ROOT, folder)
    return _read_once(ROOT, folder)


_read_once = lru_cache(maxsize=1)(Reach)  # of all parts, since it is large

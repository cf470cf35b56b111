"""Measure studies one by one, and store their results, so that an interrupted build can be resumed.

A result is a complete measurement: a claim's study, the comparison on one problem, or a study.
Times compare only within one run, so an interrupted measurement is repeated as a whole.

Each result is a JSON file in a folder of its build, below the output folder. Files are written
atomically, and reading them executes no code.
"""

from __future__ import annotations

import json
import shutil
import sys
import time
from collections import Counter
from collections.abc import Callable, Iterable
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.applications.external.loading import describe_error
from benchmarks.checks.claim import Report
from benchmarks.store.atomic import write
from benchmarks.store.provenance import digest_of_sources
from benchmarks.store.row_files import digest_of
from reports.results.options import Options
from reports.results.progress import Studies
from reports.results.suite import Suite

CACHE_FOLDER = "unfinished"  # subfolder of the output folder
WEEK_SECONDS = 7 * 86_400  # seconds after which results of any build are deleted
RUN_FIELDS = ("date", "command")  # provenance fields that differ between runs of the same build
EXTRA_SOURCES = ("reports",)  # in addition to the measured sources


@dataclass(frozen=True, eq=False)
class Study:
    """A measurement whose table the cache stores.

    Attributes
    ----------
    name
        name of its result
    label, title
        texts that are shown while it runs
    measure
        report -> table
    timed
        whether it measures times
    """

    name: str
    label: str
    title: str
    measure: Callable[[Report], pd.DataFrame]
    timed: bool = True


@dataclass(frozen=True, eq=False)
class CachedResult:
    """A table, its measuring time in seconds, and the start date of the earlier run that measured
    it; empty for this run."""

    table: pd.DataFrame
    seconds: float
    run: str = ""

    @classmethod
    def from_json(cls, stored: dict[str, Any]) -> CachedResult:
        """The result from the mapping that `as_json` returned."""
        columns = {
            name: pd.Series(stored["columns"][name], dtype=kind)
            for name, kind in stored["types"].items()
        }
        return cls(pd.DataFrame(columns), stored["seconds"], stored["run"])

    def as_json(self, run: str) -> dict[str, Any]:
        """The result as a mapping for `json`, with exact numbers, without the table's index.

        Parameters
        ----------
        run
            start date of this run
        """
        return {
            "run": run,
            "seconds": self.seconds,
            "types": self.table.dtypes.astype(str).to_dict(),
            "columns": self.table.to_dict("list"),
        }


@dataclass(eq=False)
class BuildCache:
    """The results of one build, by name.

    Attributes
    ----------
    folder
        where results are stored; None stores nothing
    run
        start date of this run
    sources
        digest of the sources when this run began; "" to ignore changes
    entries
        name -> result of interrupted runs and of this one
    edited
        whether the sources changed since this run began; nothing is stored from then on
    """

    folder: Path | None = None
    run: str = ""
    sources: str = ""
    entries: dict[str, CachedResult] = field(default_factory=dict)
    edited: bool = False

    def load(self) -> None:
        """Read the stored results into `entries`; files that cannot be read are ignored."""
        for path in self.folder.glob("*.json") if self.folder else ():
            with suppress(Exception):
                name, stored = json.loads(path.read_text(encoding="utf-8"))
                self.entries[name] = CachedResult.from_json(stored)

    @property
    def resumed(self) -> list[CachedResult]:
        """The results of interrupted runs."""
        return [entry for entry in self.entries.values() if entry.run]

    def measure(self, studies: Iterable[Study]) -> dict[str, Exception]:
        """Measure and store the studies without a result; progress goes to stderr.

        Returns name -> exception of the studies that raised.
        """
        errors = {}
        missing = [study for study in studies if study.name not in self.entries]
        with Studies(len(missing)) as progress:
            for study in missing:
                start = time.perf_counter()
                try:
                    with progress(study.label, study.title) as report:
                        table = study.measure(report)
                        self.keep(study.name, table, time.perf_counter() - start)
                except Exception as error:
                    errors[study.name] = error
        return errors

    def keep(self, name: str, table: pd.DataFrame, seconds: float) -> None:
        """Add a result to `entries`, and write its file.

        A warning is printed if the file cannot be written, or if it is not, because the sources
        have changed.
        """
        self.entries[name] = CachedResult(table, seconds)
        if self.folder is None:
            return
        self.check_sources()
        why = "the sources changed since the build began" if self.edited else ""
        try:
            if not why:
                text = json.dumps([name, self.entries[name].as_json(self.run)])
                write(self.folder / f"{digest_of(name)[:32]}.json", text)
        except OSError as error:
            why = " ".join(str(error).split())
        if why:
            print(f"{name} is not kept for a build that is resumed: {why}.", file=sys.stderr)

    def forget(self) -> None:
        """Delete the stored results of this build, and those of other builds after a week."""
        if self.folder is None:
            return
        shutil.rmtree(self.folder, ignore_errors=True)
        with suppress(OSError):  # another process was faster, or others' results stay
            for sibling in self.folder.parent.iterdir():
                if time.time() - sibling.stat().st_mtime > WEEK_SECONDS:
                    shutil.rmtree(sibling)
            self.folder.parent.rmdir()

    def check_sources(self) -> None:
        """Update `edited`: whether the sources ever changed since this run began."""
        changed = self.sources != "" and digest_of_sources(EXTRA_SOURCES) != self.sources
        self.edited = self.edited or changed

    def provenance(self) -> dict[str, str]:
        """Entries for the provenance: on results of earlier runs, and on changed sources."""
        notes = {}
        if self.resumed:
            notes["resumed"] = f"{self._earlier_runs()}; times compare within a result"
        if self.edited:
            notes["changed"] = "the sources, after this run began: results may be of either state"
        return notes

    def resumption(self) -> str:
        """A sentence on the results that are reused; empty when there are none."""
        return f"Resuming: {self._earlier_runs()}; --anew starts over." if self.resumed else ""

    def _earlier_runs(self) -> str:
        counts = Counter(entry.run for entry in self.resumed)
        return " and ".join(
            f"{count} {'result' if count == 1 else 'results'} of the build of {run}, "
            "which was stopped"
            for run, count in counts.items()
        )


def not_run(title: str, error: Exception) -> str:
    """A sentence on a study that raised."""
    return f"{title}: not run ({describe_error(error)})."


def open_cache(suite: Suite, options: Options) -> BuildCache:
    """The cache of this build, with the results of earlier, interrupted runs of the same build.

    Two builds are the same if commit, working tree, input data, versions, machine, setting and
    claims are the same. A build with external integrators stores nothing, since changes of their
    code would go unnoticed. With `options.anew` stored results are deleted first.
    """
    provenance, sources = suite.provenance(options.command), digest_of_sources(EXTRA_SOURCES)
    stable_provenance = {name: text for name, text in provenance.items() if name not in RUN_FIELDS}
    build_key = json.dumps(
        [sources, stable_provenance, options.quick, options.claims], sort_keys=True
    )
    folder = None if options.contenders else options.out / CACHE_FOLDER / digest_of(build_key)[:16]
    cache = BuildCache(folder, provenance.get("date", ""), sources)
    if options.anew:
        cache.forget()
    cache.load()
    return cache

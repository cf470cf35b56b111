"""Store the results of a build one by one, so that an interrupted build can be resumed.

A result is a complete measurement: a claim's study, the comparison on one problem, or a study.
Times compare only within one run, so an interrupted measurement is repeated as a whole.
"""

from __future__ import annotations

import hashlib
import json
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from benchmarks.store.result_cache import ResultCache, digest_of_sources
from reports.results.options import Options
from reports.results.suite import Suite

CHANGING = ("date", "command")  # provenance fields that differ between runs of the same build
CODE = ("reports",)  # in addition to the measured sources


@dataclass(frozen=True, eq=False)
class CachedResult:
    """A frame, its measuring time in seconds, and the start date of the earlier run that measured
    it; empty for this run."""

    frame: pd.DataFrame
    seconds: float
    run: str = ""

    @classmethod
    def from_json(cls, stored: dict[str, Any]) -> CachedResult:
        """From what `as_json` gave."""
        columns = {
            name: pd.Series(stored["columns"][name], dtype=kind)
            for name, kind in stored["types"].items()
        }
        return cls(pd.DataFrame(columns), stored["seconds"], stored["run"])

    def as_json(self, run: str) -> dict[str, Any]:
        """Its numbers and texts, exactly, measured in this run; the index is not kept."""
        return {
            "run": run,
            "seconds": self.seconds,
            "types": self.frame.dtypes.astype(str).to_dict(),
            "columns": self.frame.to_dict("list"),
        }


@dataclass(eq=False)
class BuildCache:
    """The results of one build, by name.

    Attributes
    ----------
    store
        where results are stored; None stores nothing
    run
        start date of this run
    sources
        digest of the current sources
    results
        of interrupted runs and of this one
    edited
        whether the sources changed since this run began; nothing is stored from then on
    """

    store: ResultCache | None = None
    run: str = ""
    sources: Callable[[], str] = str
    results: dict[str, CachedResult] = field(default_factory=dict)
    edited: bool = False

    def __post_init__(self) -> None:
        self._begun_with = self.sources()

    @property
    def taken(self) -> list[CachedResult]:
        """The results of interrupted runs."""
        return [result for result in self.results.values() if result.run]

    def result(self, name: str, measure: Callable[[], pd.DataFrame]) -> CachedResult:
        """The result of this name, or measure and store it; exceptions propagate."""
        if name not in self.results:
            start = time.perf_counter()
            frame = measure()
            self.keep(name, frame, time.perf_counter() - start)
        return self.results[name]

    def keep(self, name: str, frame: pd.DataFrame, seconds: float) -> None:
        """Store a result; when that fails, print a warning and continue."""
        self.results[name] = CachedResult(frame, seconds)
        if self.store is None:
            return
        self.look()
        why = "the sources changed since the build began" if self.edited else ""
        try:
            if not why:
                self.store.keep(name, self.results[name].as_json(self.run))
        except OSError as error:
            why = " ".join(str(error).split())
        if why:
            print(f"{name} is not kept for a build that is resumed: {why}.", file=sys.stderr)

    def forget(self) -> None:
        """Delete the stored results of this build."""
        if self.store is not None:
            self.store.forget()

    def look(self) -> None:
        """Update `edited`: whether the sources ever changed since this run began."""
        self.edited = self.edited or self.sources() != self._begun_with

    def provenance(self) -> dict[str, str]:
        """Provenance: results of earlier runs, and whether the sources changed meanwhile."""
        notes = {}
        if self.taken:
            notes["resumed"] = f"{self._earlier()}; times compare within a result"
        if self.edited:
            notes["changed"] = "the sources, after this run began: results may be of either state"
        return notes

    def greeting(self) -> str:
        """A sentence on the results that are reused; empty when there are none."""
        return f"Resuming: {self._earlier()}; --anew starts over." if self.taken else ""

    def _earlier(self) -> str:
        counts = Counter(result.run for result in self.taken)
        return " and ".join(
            f"{count} {'result' if count == 1 else 'results'} of the build of {run}, "
            "which was stopped"
            for run, count in counts.items()
        )


def open_cache(suite: Suite, options: Options) -> BuildCache:
    """The cache of this build, with the results of an earlier, interrupted run.

    A build is the same when commit, working tree, input data, versions, machine, setting and claims
    are the same. A build with external integrators stores nothing, since changes of their code
    would go unnoticed.
    """
    provenance = suite.provenance(options.command)
    same = {name: text for name, text in provenance.items() if name not in CHANGING}
    build = json.dumps([_sources(), same, options.quick, options.claims], sort_keys=True)
    store = ResultCache(options.out, hashlib.sha256(build.encode()).hexdigest()[:16])
    cache = BuildCache(None if options.contenders else store, provenance.get("date", ""), _sources)
    if options.anew:
        cache.forget()
    elif cache.store is not None:
        for name, stored in cache.store.results().items():
            cache.results[name] = CachedResult.from_json(stored)
    return cache


def _sources() -> str:
    return digest_of_sources(CODE)

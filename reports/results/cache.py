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

import numpy as np
import pandas as pd

from benchmarks.store.result_cache import ResultCache, digest_of_sources
from reports.results.options import Options
from reports.results.suite import Suite

CHANGING = ("date", "command")  # provenance fields that differ between runs of the same build
CODE = ("reports",)  # in addition to the measured sources


@dataclass(frozen=True, eq=False)
class CachedResult:
    """A frame, its measuring time in seconds, and the start date of the run that measured it."""

    frame: pd.DataFrame
    seconds: float
    run: str = ""

    def as_json(self) -> list[Any]:
        """Its numbers and texts, exactly; the index is not kept."""
        columns = [
            (name, str(column.dtype), [_native(cell) for cell in column.astype(object)])
            for name, column in self.frame.items()
        ]
        return [self.seconds, self.run, columns]

    @classmethod
    def from_json(cls, kept: list[Any]) -> CachedResult:
        """From what `as_json` gave."""
        seconds, run, columns = kept
        named = {name: pd.Series(values, dtype=kind) for name, kind, values in columns}
        return cls(pd.DataFrame(named), seconds, run)


def _native(cell: Any) -> Any:
    """A cell as JSON has it."""
    return cell.item() if isinstance(cell, np.generic) else cell


@dataclass(eq=False)
class BuildCache:
    """The results of one build, by name.

    store    where results are stored; None stores nothing
    run      start date of this run
    sources  digest of the current sources
    taken    results of interrupted runs
    ready    results of this run that were measured before their turn
    edited   whether the sources changed since this run began; nothing is stored from then on
    """

    store: ResultCache | None = None
    run: str = ""
    sources: Callable[[], str] = str
    taken: dict[str, CachedResult] = field(default_factory=dict)
    ready: dict[str, CachedResult] = field(default_factory=dict)
    edited: bool = False

    def __post_init__(self) -> None:
        self._begun_with = self.sources()

    def result(self, name: str, measure: Callable[[], pd.DataFrame]) -> CachedResult:
        """The stored result of this name, or measure and store it; exceptions propagate."""
        for known in (self.taken, self.ready):
            if name in known:
                return known[name]
        start = time.perf_counter()
        frame = measure()
        return self.keep(name, frame, time.perf_counter() - start)

    def keep(self, name: str, frame: pd.DataFrame, seconds: float) -> CachedResult:
        """Store a result; when that fails, print a warning and continue."""
        result = CachedResult(frame, seconds, self.run)
        if self.store is None:
            return result
        self.look()
        why = "the sources changed since the build began" if self.edited else ""
        try:
            if not why:
                self.store.keep(name, result.as_json())
        except OSError as error:
            why = " ".join(str(error).split())
        if why:
            print(f"{name} is not kept for a build that is resumed: {why}.", file=sys.stderr)
        return result

    def forget(self) -> None:
        """Delete the stored results of this build."""
        if self.store is not None:
            self.store.forget()
        self.taken = {}

    def look(self) -> None:
        """Update `edited`: whether the sources ever changed since this run began."""
        self.edited = self.edited or self.sources() != self._begun_with

    def provenance(self) -> dict[str, str]:
        """Provenance: results of earlier runs, and whether the sources changed meanwhile."""
        said = {}
        if self.taken:
            said["resumed"] = f"{self._earlier()}; times compare within a result"
        if self.edited:
            said["changed"] = "the sources, after this run began: results may be of either state"
        return said

    def greeting(self) -> str:
        """A sentence on the results that are reused; empty when there are none."""
        return f"Resuming: {self._earlier()}; --anew starts over." if self.taken else ""

    def _earlier(self) -> str:
        counts = Counter(result.run for result in self.taken.values())
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
    words = json.dumps([_sources(), same, options.quick, options.claims], sort_keys=True)
    store = ResultCache(options.out, hashlib.sha256(words.encode()).hexdigest()[:16])
    cache = BuildCache(None if options.contenders else store, provenance.get("date", ""), _sources)
    if options.anew:
        cache.forget()
    elif cache.store is not None:
        kept = cache.store.results()
        cache.taken = {name: CachedResult.from_json(one) for name, one in kept.items()}
    return cache


def _sources() -> str:
    return digest_of_sources(CODE)

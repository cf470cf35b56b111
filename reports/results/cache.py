"""The results of a build, kept one by one, so that a build that was stopped resumes.

A result is a whole measurement: a claim's study, one problem's comparison, a study. Times compare
only inside one run, so a measurement that was stopped half way is done again as a whole.
"""

from __future__ import annotations

import hashlib
import json
import sqlite3
import sys
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass, field

import pandas as pd

from benchmarks.store.result_cache import ResultCache, digest_of_sources
from reports.results.options import Options
from reports.results.suite import Suite

CHANGING = ("date", "command")  # of a provenance: from one run of the same build to the next
CODE = ("reports",)  # besides the sources that are measured


@dataclass(frozen=True, eq=False)
class CachedResult:
    """A frame, the seconds it took, and the date on which the run began that measured it."""

    frame: pd.DataFrame
    seconds: float
    run: str = ""


@dataclass(eq=False)
class BuildCache:
    """The results of one build, by name.

    store    where they are kept; None keeps nothing
    run      the date on which this run began
    sources  digest of the sources as they are now
    taken    results of runs that were stopped
    edited   whether the sources changed since this run began; no result is kept from then on
    """

    store: ResultCache | None = None
    run: str = ""
    sources: Callable[[], str] = str
    taken: dict[str, CachedResult] = field(default_factory=dict)
    edited: bool = False

    def __post_init__(self) -> None:
        self._begun_with = self.sources()

    def result(self, name: str, measure: Callable[[], pd.DataFrame]) -> CachedResult:
        """The result kept under this name, or measured now and kept; exceptions of measure pass."""
        if name in self.taken:
            return self.taken[name]
        start = time.perf_counter()
        frame = measure()
        return self.keep(name, frame, time.perf_counter() - start)

    def keep(self, name: str, frame: pd.DataFrame, seconds: float) -> CachedResult:
        """Store what was measured; where that cannot be done, say so: the build goes on."""
        result = CachedResult(frame, seconds, self.run)
        if self.store is None:
            return result
        self.look()
        why = "the sources changed since the build began" if self.edited else ""
        try:
            if not why:
                self.store.keep(name, result)
        except (OSError, sqlite3.Error) as error:
            why = " ".join(str(error).split())
        if why:
            print(f"{name} is not kept for a build that is resumed: {why}.", file=sys.stderr)
        return result

    def forget(self) -> None:
        """Keep nothing of this build any more."""
        if self.store is not None:
            self.store.forget()
        self.taken = {}

    def look(self) -> None:
        """Check whether the sources changed since this run began; once edited, it stays so."""
        self.edited = self.edited or self.sources() != self._begun_with

    def provenance(self) -> dict[str, str]:
        """How many results earlier runs measured, and whether the sources changed meanwhile."""
        said = {}
        if self.taken:
            said["resumed"] = f"{self._earlier()}; times compare within a result"
        if self.edited:
            said["changed"] = "the sources, after this run began: results may be of either state"
        return said

    def greeting(self) -> str:
        """A sentence on the results that are taken up; empty when there are none."""
        return f"Resuming: {self._earlier()}; --anew starts over." if self.taken else ""

    def _earlier(self) -> str:
        counts = Counter(result.run for result in self.taken.values())
        return " and ".join(
            f"{count} {'result' if count == 1 else 'results'} of the build of {run}, "
            "which was stopped"
            for run, count in counts.items()
        )


def open_cache(suite: Suite, options: Options) -> BuildCache:
    """The cache of this build, with the results of an earlier run that was stopped.

    It is the same build when the commit, the sources as they lie there, the data they read, the
    versions, the machine, the setting and the claims are the same. A build with external
    integrators keeps nothing, whose code may change unseen.
    """
    provenance = suite.provenance(options.command)
    same = {name: text for name, text in provenance.items() if name not in CHANGING}
    words = json.dumps([_sources(), same, options.quick, options.claims], sort_keys=True)
    store = ResultCache(options.out, hashlib.sha256(words.encode()).hexdigest()[:16])
    cache = BuildCache(None if options.contenders else store, provenance.get("date", ""), _sources)
    if options.anew:
        cache.forget()
    elif cache.store is not None:
        cache.taken = cache.store.results()
    return cache


def _sources() -> str:
    return digest_of_sources(CODE)

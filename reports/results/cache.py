"""What a build has measured so far, kept part by part, so that one that was stopped goes on.

A part is a whole measurement: a claim's study, one problem's comparison, a table, a study. Times
compare only inside one run, so one that was stopped half way is measured anew as a whole.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Collection, Iterable, Sequence
from dataclasses import dataclass, field
from typing import Any

import pandas as pd

from benchmarks.timings.unfinished import Unfinished
from reports.tables.plain_frames import framed, plain_frame

WHAT = ("frame", "seconds", "run", "faults")


@dataclass(frozen=True, eq=False)
class Part:
    """One of them.

    seconds  it took
    run      when the run began that measured it
    faults   what outsiders did wrong in it
    """

    frame: pd.DataFrame
    seconds: float
    run: str = ""
    faults: tuple[str, ...] = ()


@dataclass(eq=False)
class Parts:
    """Those of one build, by their names.

    store    where they are kept; None keeps nothing
    run      when this run began
    faults   what outsiders did wrong so far in this run
    planned  names of all parts
    ahead    whether a second process may keep parts of claims, see `reports.build.parallel_claims`
    changed  what of the sources is not as it was when this run began; no part is kept from then on
    taken    those of runs that did not end
    runs     when the run began that measured it, for each part that was asked for
    seen     what was found to be changed
    """

    store: Unfinished | None = None
    run: str = ""
    faults: Callable[[], Collection[str]] = tuple
    planned: Sequence[str] = ()
    ahead: bool = False
    changed: Callable[[], Collection[str]] = tuple
    taken: dict[str, Part] = field(default_factory=dict)
    runs: dict[str, str] = field(default_factory=dict)
    seen: tuple[str, ...] = ()

    def take_up(self) -> None:
        """Find what is kept of the planned parts; what is damaged is set aside, with a sentence."""
        kept = {name: self._kept(name) for name in self.planned}
        self.taken = {name: part for name, part in kept.items() if part is not None}

    def part(self, name: str, measure: Callable[[], pd.DataFrame]) -> Part:
        """What is kept under this name, or is measured now and kept; raises what measure does."""
        part = self.taken.get(name) or self._kept(name) or self._measured(name, measure)
        self.runs[name] = part.run
        return part

    def faults_taken(self) -> list[str]:
        """What outsiders did wrong in the parts taken up."""
        return [fault for part in self.taken.values() for fault in part.faults]

    def forget(self) -> None:
        """Keep nothing of this build any more."""
        if self.store is not None:
            self.store.remove_all()
        self.taken = {}

    def greeting(self) -> str:
        """What is taken up, in a sentence; empty when nothing is."""
        if not self.taken:
            return ""
        return (
            f"Goes on with a build of {' and '.join(self._runs())} that did not end: "
            f"{len(self.taken)} of {len(self.planned)} parts are there; --anew starts over."
        )

    def origin(self) -> dict[str, str]:
        """For the provenance: how many parts other runs measured; nothing when none did."""
        if not self.taken:
            return {}
        runs = [part.run for part in self.taken.values()]
        told = [f"{runs.count(run)} by a run of {run} that was stopped" for run in self._runs()]
        return {
            "runs": f"of {len(self.planned)} parts, {', '.join(told)}, the others "
            "by this one; times compare within a part, each of which one run measured"
        }

    def measured(self, names: Iterable[str]) -> dict[str, str]:
        """For the provenance of a file that these parts are in: which run measured which of them.

        Nothing when this one did.
        """
        found: dict[str, list[str]] = {}
        for name in names:
            if name in self.runs:
                found.setdefault(self.runs[name], []).append(name)
        if set(found) <= {self.run}:
            return {}
        told = [f"{', '.join(parts)} by the run of {run}" for run, parts in found.items()]
        return {"measured": "; ".join(told)}

    def changes(self) -> dict[str, str]:
        """For the provenance: what was changed, when it was last looked at; nothing when nothing.

        It is looked at before a part is kept.
        """
        if not self.seen:
            return {}
        told = " and ".join(self.seen)
        return {"changed": f"{told}, after this run began: parts may be of either state"}

    def look(self) -> None:
        """See what was changed since this run began; what was once, stays so."""
        self.seen = tuple(dict.fromkeys((*self.seen, *self.changed())))

    def _runs(self) -> list[str]:
        return list(dict.fromkeys(part.run for part in self.taken.values()))

    def _kept(self, name: str) -> Part | None:
        row = None if self.store is None else self.store.row(name)
        if row is None:
            return None
        try:
            frame, seconds, run, faults = (row[what] for what in WHAT)
            return Part(framed(frame), float(seconds), str(run), tuple(map(str, faults)))
        except (KeyError, TypeError, ValueError) as error:
            self._store().set_aside(name, f"{type(error).__name__}: {error}")
            return None

    def _measured(self, name: str, measure: Callable[[], pd.DataFrame]) -> Part:
        start, before = time.perf_counter(), tuple(self.faults())
        frame = measure()
        took = time.perf_counter() - start
        new = tuple(fault for fault in self.faults() if fault not in before)
        part = Part(frame, took, self.run, new)
        self._keep(name, part)
        return part

    def _keep(self, name: str, part: Part) -> None:
        """Store it; where that cannot be, say so: the build itself goes on."""
        if self.store is None:
            return
        self.look()
        if self.seen:
            print(
                f"{name} is not kept for a build that goes on: {' and '.join(self.seen)} changed "
                "since the build began.",
                file=sys.stderr,
            )
            return
        try:
            row: dict[str, Any] = {
                "frame": plain_frame(part.frame), "seconds": part.seconds, "run": part.run,
                "faults": part.faults,
            }  # fmt: skip
            self.store.keep(name, row)
        except (OSError, TypeError, ValueError) as error:
            why = " ".join(str(error).split())
            print(f"{name} is not kept for a build that goes on: {why}.", file=sys.stderr)

    def _store(self) -> Unfinished:
        assert self.store is not None
        return self.store

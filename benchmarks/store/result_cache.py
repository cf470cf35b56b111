"""What a run that was stopped had measured, for the next run of the same sources to take up.

Kept by diskcache: whole or not at all, by any number of processes.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diskcache import Cache

from benchmarks.store.provenance import ROOT, cpu, versions

FOLDER = "unfinished"  # in the folder of what is measured
WEEK = 7 * 86_400  # seconds after which a result is not taken up any more
SOURCES = ("galvi", "references", "benchmarks")
KINDS = (".py", ".csv")  # code, and the data that starts and truths are read from


def digest_of_sources(code: tuple[str, ...] = ()) -> str:
    """Of the sources, the versions and the processor, and of the code in more folders, as now."""
    digest = hashlib.sha256(json.dumps([versions(), cpu()]).encode())
    for folder in (*SOURCES, *code):
        kinds = KINDS if folder in SOURCES else KINDS[:1]
        for path in sorted((ROOT / folder).rglob("*")):
            if path.suffix in kinds:
                digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class ResultCache:
    """Results by name, of one state of the sources; those of other states are left alone.

    storage  the folder of what is measured; results lie below it, in FOLDER
    state    a digest of all that the results depend on
    """

    storage: Path
    state: str

    def results(self) -> dict[str, Any]:
        """Everything that was kept; what cannot be read any more is left out."""
        if not (self.storage / FOLDER).exists():
            return {}
        found = {}
        with self._opened() as cache:
            for key in cache:
                state, _, name = key.partition(" ")
                if state != self.state:
                    continue
                try:
                    found[name] = cache[key]
                except Exception:  # expired, damaged, or pickled by something else
                    continue
        return found

    def keep(self, name: str, result: Any) -> None:
        """Store a result. Raises OSError or sqlite3.Error where that cannot be done."""
        with self._opened() as cache:
            cache.set(f"{self.state} {name}", result, expire=WEEK, tag=self.state)

    def forget(self, names: Iterable[str] | None = None) -> None:
        """Remove these results, all of this state for None, and the folder when it is empty."""
        if not (self.storage / FOLDER).exists():
            return
        with self._opened() as cache:
            if names is None:
                cache.evict(self.state)
            for name in names or ():
                cache.delete(f"{self.state} {name}")
            cache.expire()
            empty = len(cache) == 0
        if empty:
            shutil.rmtree(self.storage / FOLDER, ignore_errors=True)

    @contextmanager
    def _opened(self) -> Iterator[Cache]:
        """The cache; one that is no database any more is replaced by an empty one."""
        folder = self.storage / FOLDER
        try:
            cache = Cache(str(folder))
        except sqlite3.OperationalError:  # the disk is full, or another process holds it
            raise
        except sqlite3.DatabaseError:
            shutil.rmtree(folder)
            cache = Cache(str(folder))
        with cache:
            yield cache

"""A cache of the results of an interrupted run, for the next run of the same sources.

Stored with diskcache: atomic, and safe for several processes.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import sqlite3
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from diskcache import Cache

from benchmarks.store.provenance import ROOT, cpu, versions

FOLDER = "unfinished"  # subfolder of the output folder
WEEK = 7 * 86_400  # seconds after which a result expires
SOURCES = ("galvi", "references", "benchmarks")
KINDS = (".py", ".csv")  # code, and data of initial states and truths


def digest_of_sources(code: tuple[str, ...] = (), machine: bool = True) -> str:
    """A digest of the current sources, including further folders, of versions and processor.

    machine  whether the processor counts
    """
    digest = hashlib.sha256(json.dumps([versions(), cpu() if machine else ""]).encode())
    for folder in (*SOURCES, *code):
        kinds = KINDS if folder in SOURCES else KINDS[:1]
        for name in sorted(_files(ROOT / folder, kinds)):
            digest.update(name.encode() + b"\0" + (ROOT / name).read_bytes())
    return digest.hexdigest()[:16]


def _files(folder: Path, kinds: tuple[str, ...]) -> Iterator[str]:
    """Names, relative to ROOT, of the files of these kinds below a folder."""
    for place, folders, names in os.walk(folder):  # a build walks often: as fast as can be
        folders[:] = [name for name in folders if name != "__pycache__"]
        start = os.path.relpath(place, ROOT)
        yield from (f"{start}/{name}" for name in names if name.endswith(kinds))


@dataclass(frozen=True)
class ResultCache:
    """Results by name, for one state of the sources; those of other states are not touched.

    storage  the output folder; results are stored below it, in FOLDER
    state    a digest of everything that the results depend on
    """

    storage: Path
    state: str

    def results(self) -> dict[str, Any]:
        """All stored results by name; unreadable ones are omitted."""
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
        """Store a result. Raises OSError or sqlite3.Error when that fails."""
        with self._opened() as cache:
            cache.set(f"{self.state} {name}", result, expire=WEEK, tag=self.state)

    def forget(self, names: Iterable[str] | None = None) -> None:
        """Delete these results (None: all of this state), and the folder when it is empty."""
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
        """The open cache; a damaged database is replaced by an empty one."""
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

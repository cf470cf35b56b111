"""A cache of the results of an interrupted run, for the next run of the same sources.

Files are written as a whole and renamed, so that several processes may write at a time.
"""

from __future__ import annotations

import hashlib
import json
import time
from collections.abc import Iterable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT, SOURCES, cpu, versions
from benchmarks.store.row_files import digest_of

FOLDER = "unfinished"  # subfolder of the output folder
WEEK = 7 * 86_400  # seconds after which results of any state are deleted
KINDS = (".py", ".csv", ".md")  # code, data of initial states and truths, documents of claims


def digest_of_sources(code: tuple[str, ...] = ()) -> str:
    """A digest of the current sources, including further folders, of versions and processor."""
    digest = hashlib.sha256(json.dumps([versions(), cpu()]).encode())
    for folder in (*SOURCES, *code):
        for kind in KINDS if folder in SOURCES else KINDS[:1]:
            for path in sorted((ROOT / folder).rglob(f"*{kind}")):
                name = path.relative_to(ROOT).as_posix()
                digest.update(name.encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class ResultCache:
    """Results by name, for one state of the sources; those of other states are not touched.

    Attributes
    ----------
    storage
        the output folder; results are stored below it, in FOLDER
    state
        a digest of everything that the results depend on

    Notes
    -----
    A result is what JSON holds, in a file of its own. Nothing that lies in the folder is ever run.
    """

    storage: Path
    state: str

    def results(self) -> dict[str, Any]:
        """All stored results by name; damaged ones are omitted."""
        results = {}
        for path in (self.storage / FOLDER / self.state).glob("*.json"):
            with suppress(OSError, ValueError, TypeError, RecursionError):
                name, result = json.loads(path.read_text(encoding="utf-8"))
                results[name] = result
        return results

    def keep(self, name: str, result: Any) -> None:
        """Store a result.

        Raises
        ------
        OSError
            When that fails.
        """
        write(self._path(name), json.dumps([name, result]))

    def forget(self, names: Iterable[str] | None = None) -> None:
        """Delete these results (None: all of this state), what is older than a week, and the folder
        when it is empty."""
        folder, begun = self.storage / FOLDER, time.time()
        paths = [*folder.glob(f"{self.state}/*.json")] if names is None else map(self._path, names)
        for path in paths:
            path.unlink(missing_ok=True)
        for path in folder.glob("*/*.json"):
            with suppress(OSError):  # another process was faster
                if begun - path.stat().st_mtime > WEEK:
                    path.unlink()
        for empty in (*folder.glob("*"), folder):
            with suppress(OSError):  # it is not empty, or another process was faster
                empty.rmdir()

    def _path(self, name: str) -> Path:
        return self.storage / FOLDER / self.state / f"{digest_of(name)[:32]}.json"

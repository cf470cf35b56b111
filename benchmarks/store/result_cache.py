"""A cache of the results of an interrupted run, for the next run of the same sources.

Files are written as a whole and renamed, so that several processes may write at a time.
"""

from __future__ import annotations

import hashlib
import json
import os
import time
from collections.abc import Iterable, Iterator
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT, SOURCES, cpu, versions
from benchmarks.store.row_files import digest_of

FOLDER = "unfinished"  # subfolder of the output folder
WEEK = 7 * 86_400  # seconds after which a result expires
ENDING = ".json"
KINDS = (".py", ".csv", ".md")  # code, data of initial states and truths, documents of claims


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

    A result is what JSON holds, one file each with a digest of its text. Nothing that lies in the
    folder is ever run.
    """

    storage: Path
    state: str

    def results(self) -> dict[str, Any]:
        """All stored results by name; damaged and expired ones are omitted."""
        found = {}
        for path in self._files():
            try:
                digest, _, text = path.read_text(encoding="utf-8").partition("\n")
                if digest == digest_of(text) and not _expired(path):
                    name, result = json.loads(text)
                    found[name] = result
            except (OSError, ValueError, RecursionError):
                continue
        return found

    def keep(self, name: str, result: Any) -> None:
        """Store a result. Raises OSError when that fails."""
        text = json.dumps([name, result])
        write(self._path(name), f"{digest_of(text)}\n{text}")

    def forget(self, names: Iterable[str] | None = None) -> None:
        """Delete these results (None: all of this state), and the folder when it is empty."""
        gone = list(self._files()) if names is None else [self._path(name) for name in names]
        folder = self.storage / FOLDER
        gone += [path for path in folder.glob(f"*/*{ENDING}") if _expired(path)]
        for path in gone:
            path.unlink(missing_ok=True)
        for empty in (*folder.glob("*"), folder):
            with suppress(OSError):  # it is not empty, or another process was faster
                empty.rmdir()

    def _path(self, name: str) -> Path:
        return self.storage / FOLDER / self.state / f"{digest_of(name)[:32]}{ENDING}"

    def _files(self) -> Iterator[Path]:
        yield from (self.storage / FOLDER / self.state).glob(f"*{ENDING}")


def _expired(path: Path) -> bool:
    try:
        return time.time() - path.stat().st_mtime > WEEK
    except OSError:  # another process was faster
        return False

"""Rows of a bench, or parts of a report, that was stopped: each is kept as soon as it is known, and
taken up again.

They belong to one state of the sources and one machine; others neither see nor remove them.
"""

from __future__ import annotations

import hashlib
import json
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT, cpu, versions

FOLDER = "unfinished"  # in the storage
DAMAGED = "damaged"  # in that folder: what could not be read
WEEK = 7 * 86_400.0  # seconds after which rows of other sources will not be asked for any more
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


@cache
def state_of_sources() -> str:
    """Their digest when it was first asked for in this process."""
    return digest_of_sources()


@dataclass(frozen=True)
class Unfinished:
    """The rows in one storage, by the name of their test, for one state of the sources.

    state  of which the rows are; empty for that of the sources
    tell   is given a sentence for each row that is set aside
    """

    storage: Path
    state: str = ""
    tell: Callable[[str], None] = print

    @property
    def folder(self) -> Path:
        """Of the rows of this state."""
        return self.storage / FOLDER / (self.state or state_of_sources())

    def path(self, name: str) -> Path:
        """Of the row of a test."""
        return self.folder / f"{hashlib.sha256(name.encode()).hexdigest()[:16]}.json"

    def keep(self, name: str, row: dict[str, Any]) -> None:
        """Store a row, whole or not at all."""
        whole = {"fullname": name, "digest": _digest(row), "row": row}
        write(self.path(name), json.dumps(whole))

    def row(self, name: str) -> dict[str, Any] | None:
        """What was kept; None when there is nothing that can be read, which is then measured."""
        try:
            kept = json.loads(self.path(name).read_text(encoding="utf-8"))
        except FileNotFoundError:
            return None
        except (OSError, ValueError) as error:
            self.set_aside(name, str(error))
            return None
        if not isinstance(kept, dict) or kept.get("fullname") != name:
            self.set_aside(name, "it is not what was written")
            return None
        if not isinstance(kept.get("row"), dict):
            self.set_aside(name, "it has no row")
            return None
        if kept.get("digest") != _digest(kept["row"]):
            self.set_aside(name, "its row is not the one that was written")
            return None
        return dict(kept["row"])

    def set_aside(self, name: str, why: str) -> None:
        """Move a row to where it is neither read again nor lost."""
        path = self.path(name)
        aside = self.storage / FOLDER / DAMAGED / path.name
        try:
            aside.parent.mkdir(parents=True, exist_ok=True)
            for k in range(1, 1000):
                if not aside.exists():
                    break
                aside = aside.with_name(f"{path.name}.{k}")
            os.replace(path, aside)
        except FileNotFoundError:  # another process set it aside
            return
        except OSError as error:
            self.tell(f"What was kept of {name} cannot be read, nor set aside ({error}).")
            return
        self.tell(f"What was kept of {name} cannot be read ({why}), and is now {aside}.")

    def remove(self, name: str) -> None:
        """Forget a row, and the folder when it was the last."""
        path = self.path(name)
        path.unlink(missing_ok=True)
        self._tidy()

    def remove_all(self) -> None:
        """Forget every row of this state at once."""
        gone = self.folder.with_name(f".{self.folder.name}.{os.getpid()}")
        try:
            os.replace(self.folder, gone)
        except FileNotFoundError:
            return
        shutil.rmtree(gone, ignore_errors=True)
        self._tidy()

    def _tidy(self) -> None:
        """Remove what is left of other states after a week, and folders that are empty."""
        for other in (self.storage / FOLDER).glob("*"):
            if other.name != DAMAGED and other != self.folder and _age(other) > WEEK:
                shutil.rmtree(other, ignore_errors=True)
        for folder in (self.folder, self.storage / FOLDER):
            try:
                folder.rmdir()
            except FileNotFoundError:
                continue
            except OSError:
                return


def _digest(row: dict[str, Any]) -> str:
    """Of its text, which is the same once it was read back, to the last bit of every number."""
    return hashlib.sha256(json.dumps(row).encode()).hexdigest()


def _age(folder: Path) -> float:
    """Seconds since something was put into it, or taken away."""
    try:
        return time.time() - folder.stat().st_mtime
    except OSError:  # another process removed it
        return 0.0

"""Rows of a bench that was stopped: each is kept as soon as it is known, and taken up again.

They belong to one state of the sources and one machine; others neither see nor remove them.
"""

from __future__ import annotations

import hashlib
import json
import shutil
import time
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any

from benchmarks.atomic import write
from benchmarks.provenance import ROOT, cpu, versions

FOLDER = "unfinished"  # in the storage
WEEK = 7 * 86_400.0  # seconds after which rows of other sources will not be asked for any more
SOURCES = ("galvi", "references", "benchmarks")


@cache
def state_of_sources() -> str:
    """A digest of the sources, the versions and the processor."""
    digest = hashlib.sha256(json.dumps([versions(), cpu()]).encode())
    for folder in SOURCES:
        for path in sorted((ROOT / folder).rglob("*.py")):
            digest.update(str(path.relative_to(ROOT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


@dataclass(frozen=True)
class Unfinished:
    """The rows in one storage, by the name of their test, for one state of the sources."""

    storage: Path

    def path(self, name: str) -> Path:
        """Of the row of a test."""
        digest = hashlib.sha256(name.encode()).hexdigest()[:16]
        return self.storage / FOLDER / state_of_sources() / f"{digest}.json"

    def keep(self, name: str, row: dict[str, Any]) -> None:
        """Store a row, whole or not at all."""
        write(self.path(name), json.dumps({"fullname": name, "row": row}))

    def row(self, name: str) -> dict[str, Any] | None:
        """What was kept; None when there is nothing that can be read, which is then measured."""
        try:
            kept = json.loads(self.path(name).read_text(encoding="utf-8"))
            row = kept["row"] if kept["fullname"] == name else None
        except (OSError, ValueError, KeyError, TypeError):
            return None
        return row if isinstance(row, dict) else None

    def remove(self, name: str) -> None:
        """Forget a row, and the folder when it was the last."""
        path = self.path(name)
        path.unlink(missing_ok=True)
        for other in path.parent.parent.glob("*"):
            if other != path.parent and time.time() - other.stat().st_mtime > WEEK:
                shutil.rmtree(other, ignore_errors=True)
        for folder in (path.parent, path.parent.parent):
            try:
                folder.rmdir()
            except OSError:
                return

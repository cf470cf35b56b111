"""provenance.json: the origin of each output file, so that old files are recognised."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from benchmarks.store.atomic import write

NAME = "provenance.json"


def note_origin(folder: Path, file: str, provenance: Mapping[str, str], quick: bool) -> None:
    """Record date, commit and command of a file; entries of other files are kept."""
    known = read_origins(folder)
    known[file] = {**provenance, "setting": "quick" if quick else "default"}
    write(folder / NAME, json.dumps(known, indent=2) + "\n")


def read_origins(folder: Path) -> dict[str, dict[str, str]]:
    """The recorded origins by file; empty when provenance.json is missing or unreadable."""
    try:
        known = json.loads((folder / NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}

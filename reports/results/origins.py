"""provenance.json: where each written file comes from, so that an old one cannot pass for new."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path

from benchmarks.store.atomic import write

NAME = "provenance.json"


def note_origin(folder: Path, file: str, provenance: Mapping[str, str], quick: bool) -> None:
    """Record under the file's name when, by which commit and how it was made; keep the others."""
    known = read_origins(folder)
    known[file] = {**provenance, "setting": "quick" if quick else "default"}
    write(folder / NAME, json.dumps(known, indent=2) + "\n")


def read_origins(folder: Path) -> dict[str, dict[str, str]]:
    """The recorded origins by file; empty when there is no such file or it cannot be read."""
    try:
        known = json.loads((folder / NAME).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return known if isinstance(known, dict) else {}

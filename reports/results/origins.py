"""provenance.json: the origin of each output file, by which old files are recognised.

An origin holds date, commit, command, setting (quick or default), versions and machine.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Mapping
from pathlib import Path

from benchmarks.store.atomic import write

PROVENANCE_FILE = "provenance.json"


def note_origin(folder: Path, file: str, provenance: Mapping[str, str], quick: bool) -> None:
    """Record the origin of a file in provenance.json; entries of other files are unchanged."""
    origins = read_origins(folder)
    origins[file] = {**provenance, "setting": "quick" if quick else "default"}
    write(folder / PROVENANCE_FILE, json.dumps(origins, indent=2) + "\n")


def read_origins(folder: Path) -> dict[str, dict[str, str]]:
    """The recorded origins by file; empty when provenance.json is missing or unreadable."""
    try:
        origins = json.loads((folder / PROVENANCE_FILE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return origins if isinstance(origins, dict) else {}


def describe_origins(origins: Iterable[Mapping[str, str]]) -> str:
    """Origins, at least one, as text: "2026-01-02 03:04 UTC, commit 0123456789ab, in the quick
    setting"."""
    entries = list(origins)
    dates = sorted({origin.get("date") or "at an unknown time" for origin in entries})
    commits = list(
        dict.fromkeys(short_commit(origin.get("commit") or "unknown") for origin in entries)
    )
    quick = [origin.get("setting") == "quick" for origin in entries]
    parts = [
        " to ".join(dict.fromkeys((dates[0], dates[-1]))),
        f"commit{'s' if len(commits) > 1 else ''} {' and '.join(commits)}",
    ]
    parts += [f"{'' if all(quick) else 'partly '}in the quick setting"] if any(quick) else []
    return ", ".join(parts)


def short_commit(commit: str) -> str:
    """The first 12 digits of a commit's hash, with a remark on uncommitted changes ("+")."""
    digits, plus, dirty = commit.partition("+")
    return f"{digits[:12]}{' with changes' if plus and dirty else ''}"

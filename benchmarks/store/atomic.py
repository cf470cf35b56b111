"""Write files of a report, with the folder that they are in."""

from __future__ import annotations

from pathlib import Path

from galvi.whole_files import write_whole


def write(path: Path, content: str | bytes) -> Path:
    """Write content (text as UTF-8) to path as `write_whole` does, creating its folder; returns the
    path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content)
    return path

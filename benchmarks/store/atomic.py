"""Write files as a whole, and create their folder."""

from __future__ import annotations

from pathlib import Path

from galvi.whole_files import write_whole


def write(path: Path, content: str | bytes) -> Path:
    """Write content (text as UTF-8) to `path` with `write_whole`, creating its folder; returns
    `path`."""
    path.parent.mkdir(parents=True, exist_ok=True)
    write_whole(path, content)
    return path

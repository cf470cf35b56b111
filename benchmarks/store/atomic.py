"""Atomic writes: to a temporary file in the same folder, then renamed."""

from __future__ import annotations

from pathlib import Path

from galvi.run.saving.files import write_whole


def write(path: Path, content: str | bytes) -> Path:
    """Write content (text as UTF-8) to path atomically, creating its folder; returns the path."""
    path.parent.mkdir(parents=True, exist_ok=True)
    data = content.encode() if isinstance(content, str) else content
    write_whole(path, lambda partial: partial.write_bytes(data))
    return path

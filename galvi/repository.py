"""The git repository that a user's files are in."""

from __future__ import annotations

from pathlib import Path


def repository_of(folder: Path) -> Path:
    """The root of the git repository that a folder is in, or the folder itself outside of any."""
    above = (folder, *folder.parents)
    return next((ancestor for ancestor in above if (ancestor / ".git").exists()), folder)


def path_in_repository(file: str) -> str:
    """The path of a file from the root of the repository that the current folder is in, with
    slashes; "" for a file elsewhere, and for none."""
    root, path = repository_of(Path.cwd()).resolve(), Path(file).resolve()
    return path.relative_to(root).as_posix() if file and path.is_relative_to(root) else ""

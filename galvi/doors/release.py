"""galvi's version: the tag of a release, or else the coming release and the commit.

``setup.py`` runs this file by itself, so it imports nothing that has to be installed.
"""

from __future__ import annotations

import subprocess
from importlib import metadata
from pathlib import Path

RELEASE = "0.1.0"
DESCRIBE = ("describe", "--tags", "--always", "--dirty", "--abbrev=12", "--match=v[0-9]*")


def galvi_version() -> str:
    """The version of a checkout, of an installed wheel, or RELEASE without git and installation."""
    try:
        return version_in_git(Path(__file__).parents[2]) or metadata.version("galvi")
    except metadata.PackageNotFoundError:
        return f"{RELEASE}+unknown"


def version_in_git(top: Path) -> str:
    """The version of a git checkout with this top folder; "" where git does not tell."""
    if not (top / ".git").exists():
        return ""
    command = ("git", "-C", str(top), *DESCRIBE)
    try:
        said = subprocess.run(command, capture_output=True, text=True, check=True, timeout=10)
    except (OSError, subprocess.SubprocessError):
        return ""
    # v0.1.0, v0.1.0-7-g1234567890ab so many commits after it, or 1234567890ab; and then -dirty
    name, *changed = said.stdout.strip().split("-dirty")
    tag, _, commit = name.rpartition("-g")
    if name.startswith("v") and not tag:
        return name[1:] + ("+dirty" if changed else "")
    return f"{RELEASE}.dev0+g{commit}{'.dirty' if changed else ''}"

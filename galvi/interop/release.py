"""galvi's version: the tag of a release, or else the coming release and the commit, from git or
from what git wrote into an archive, such as GitHub's.

``setup.py`` runs this file by itself, so it imports nothing that has to be installed.
"""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from importlib import metadata
from pathlib import Path

RELEASE = "0.1.0"
RELEASED = r"v(\d+(?:\.\d+)*(?:(?:a|b|rc)\d+)?)(-dirty)?"  # a tag of a release, as PEP 440 has it
# Where this file is in an archive: the commit, and the last tag with how many commits ago that was.
# The attribute export-subst in .gitattributes makes git fill them in.
ARCHIVED = "$Format:%H %(describe:tags=true,match=v[0-9]*)$"


@cache
def galvi_version() -> str:
    """The version of a checkout, of an installed wheel, or RELEASE without git and installation."""
    try:
        return version_in_git(Path(__file__).parents[2]) or metadata.version("galvi")
    except metadata.PackageNotFoundError:
        return f"{RELEASE}+unknown"


def commit_in(version: str) -> str:
    """The commit that a version names, with '+dirty' for changed files; "" where it names none."""
    named = re.search(r"\+g([0-9a-f]+)(\.dirty)?$", version)
    return named[1] + ("+dirty" if named[2] else "") if named else ""


def version_in_git(top: Path) -> str:
    """The version of a git checkout with this top folder, or of an archive; "" where git has
    none."""
    if not (top / ".git").exists():
        return version_in_archive(ARCHIVED)
    description = _git(top, "--tags", "--match=v[0-9]*", "--exact-match")
    tag = re.fullmatch(RELEASED, description)
    if tag:
        return tag[1] + ("+dirty" if tag[2] else "")
    commit, *changed = _git(top, "--exclude=*").split("-dirty")
    return f"{RELEASE}.dev0+g{commit}{'.dirty' if changed else ''}" if commit else ""


def version_in_archive(filled_in: str) -> str:
    """The version in ARCHIVED; "" where git did not fill it in."""
    commit, _, described = filled_in.partition(" ")
    tag = re.fullmatch(RELEASED, described)
    if tag:
        return tag[1]
    return "" if commit.startswith("$") else f"{RELEASE}.dev0+g{commit[:12]}"


def _git(top: Path, *options: str) -> str:
    """The output of ``git describe`` for this checkout, whatever repository the environment
    names."""
    command = ("git", "-C", str(top), "describe", "--always", "--dirty", "--abbrev=12", *options)
    environment = {name: text for name, text in os.environ.items() if not name.startswith("GIT_")}
    try:
        completed = subprocess.run(
            command, capture_output=True, text=True, timeout=10, env=environment
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return completed.stdout.strip() if completed.returncode == 0 else ""

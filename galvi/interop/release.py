"""galvi's version: the tag of a release, else the coming release and the commit, from git or from
the text that git writes into an archive, such as GitHub's.

``setup.py`` runs this file alone, so it imports the standard library only.
"""

from __future__ import annotations

import os
import re
import subprocess
from functools import cache
from importlib import metadata
from pathlib import Path

RELEASE = "0.1.0"  # the coming release
RELEASE_TAG = r"v(\d+(?:\.\d+)*(?:(?:a|b|rc)\d+)?)(-dirty)?"  # with a version as in PEP 440
# In an archive: the commit, then the last tag and the number of commits since. git fills them in,
# as the attribute export-subst in .gitattributes demands.
ARCHIVED = "$Format:%H %(describe:tags=true,match=v[0-9]*)$"


@cache
def galvi_version() -> str:
    """The version of the checkout, else of the installed package, else RELEASE+unknown."""
    try:
        return version_in_git(Path(__file__).parents[2]) or metadata.version("galvi")
    except metadata.PackageNotFoundError:
        return f"{RELEASE}+unknown"


def commit_in(version: str) -> str:
    """The commit in a version, with '+dirty' for changed files; "" for a version without."""
    named = re.search(r"\+g([0-9a-f]+)(\.dirty)?$", version)
    return named[1] + ("+dirty" if named[2] else "") if named else ""


def version_in_git(top: Path) -> str:
    """The version of the git checkout with this top folder, or of an archive without .git; "" where
    git does not answer or did not fill in the archive."""
    if not (top / ".git").exists():
        return version_in_archive(ARCHIVED)
    description = _git(top, "--tags", "--match=v[0-9]*", "--exact-match")
    tag = re.fullmatch(RELEASE_TAG, description)
    if tag:
        return tag[1] + ("+dirty" if tag[2] else "")
    commit, *changed = _git(top, "--exclude=*").split("-dirty")
    return f"{RELEASE}.dev0+g{commit}{'.dirty' if changed else ''}" if commit else ""


def version_in_archive(filled_in: str) -> str:
    """The version in ARCHIVED; "" where git did not fill it in."""
    commit, _, described = filled_in.partition(" ")
    tag = re.fullmatch(RELEASE_TAG, described)
    if tag:
        return tag[1]
    return "" if commit.startswith("$") else f"{RELEASE}.dev0+g{commit[:12]}"


def _git(top: Path, *options: str) -> str:
    """The output of ``git describe`` for this checkout, without variables such as GIT_DIR, which
    may name another repository; "" where it fails."""
    command = ("git", "-C", str(top), "describe", "--always", "--dirty", "--abbrev=12", *options)
    environment = {name: text for name, text in os.environ.items() if not name.startswith("GIT_")}
    try:
        completed = subprocess.run(
            command, capture_output=True, text=True, timeout=10, env=environment
        )
    except (OSError, subprocess.SubprocessError):
        return ""
    return completed.stdout.strip() if completed.returncode == 0 else ""

"""Two states of galvi in folders of their own: a revision, and the working tree as it is.

Each has its own cache of kernels, in its own folder. It starts with what the checkout's cache
holds; galvi loads of it only what was compiled from the same sources, byte for byte.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

PACKAGE = "galvi"
FOR_AN_INSTALLATION = ("pyproject.toml", "README.md", "constraints.txt")
CACHES = "__pycache__/galvi-kernels-*"


class CannotCompare(Exception):
    """Nothing can be compared; a sentence says why, and what would do."""


@dataclass(frozen=True)
class Tree:
    """folder: holds galvi; name: for people, e.g. "a1b2c3d4e5f6"; changed: not as committed."""

    folder: Path
    name: str
    changed: bool = False


@contextmanager
def two_trees(revision: str, root: Path) -> Iterator[tuple[Tree, Tree]]:
    """The revision and the checkout's working tree; both go afterwards, whatever happens.

    Raises CannotCompare for a revision that git does not know, one without galvi, and a folder that
    is no checkout.
    """
    commit = _commit(revision, root)
    with tempfile.TemporaryDirectory(prefix="galvi-track-") as place:
        base = Tree(_archived(commit, root, Path(place) / "base"), commit[:12])
        yield base, working_tree(root, Path(place) / "head")


def working_tree(root: Path, folder: Path) -> Tree:
    """A copy of galvi as it stands in the checkout: what git tracks, and what it would."""
    listed = _git(root, "ls-files", "--cached", "--others", "--exclude-standard", "-z", PACKAGE,
                  *FOR_AN_INSTALLATION)  # fmt: skip
    for name in filter(None, listed.decode().split("\0")):
        if (root / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(root / name, folder / name)
    seed(root, folder)
    commit = _git(root, "rev-parse", "HEAD").decode().strip()[:12]
    changed = bool(_git(root, "status", "--porcelain", "--", PACKAGE).strip())
    name = f"the working tree ({commit} with changes)" if changed else commit
    return Tree(folder, name, changed)


def seed(root: Path, folder: Path) -> None:
    """Copy compiled kernels; another process may remove some of them meanwhile."""
    for cache in sorted((root / PACKAGE).rglob(CACHES)):
        to = folder / cache.relative_to(root)
        if not to.parent.parent.is_dir():
            continue
        try:
            shutil.copytree(cache, to, dirs_exist_ok=True)
        except (OSError, shutil.Error):
            shutil.rmtree(to, ignore_errors=True)


def _commit(revision: str, root: Path) -> str:
    asked = ["rev-parse", "--verify", "--quiet", "--end-of-options", f"{revision}^{{commit}}"]
    try:
        return _git(root, *asked).decode().strip()
    except subprocess.CalledProcessError:
        pass
    if not (root / ".git").exists():
        raise CannotCompare("track --against needs a git checkout; this folder is none.")
    raise CannotCompare(
        f"--against expects a revision that git knows; received {revision!r}. "
        "Name a commit, a branch or a tag; in a shallow clone, fetch it first."
    )


def _archived(commit: str, root: Path, folder: Path) -> Path:
    there = set(_git(root, "ls-tree", "--name-only", "-z", commit).decode().split("\0"))
    if PACKAGE not in there:
        raise CannotCompare(
            f"--against expects a revision that has {PACKAGE}; {commit[:12]} has none."
        )
    wanted = [name for name in (PACKAGE, *FOR_AN_INSTALLATION) if name in there]
    packed = _git(root, "archive", "--format=tar", commit, *wanted)
    with tarfile.open(fileobj=io.BytesIO(packed)) as archive:
        archive.extractall(folder, filter="data")
    seed(root, folder)
    return folder


def _git(root: Path, *arguments: str) -> bytes:
    try:
        done = subprocess.run(["git", *arguments], cwd=root, capture_output=True, check=True)
    except FileNotFoundError:
        raise CannotCompare("track --against needs git, which is not installed.") from None
    return done.stdout

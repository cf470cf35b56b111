"""Two copies of galvi in separate folders: a revision, and the current working tree.

Each has its own kernel cache, initially a copy of the working tree's; galvi loads only kernels
compiled from identical sources.
"""

from __future__ import annotations

import io
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path

from galvi.kernels.compile.cache import FOLDER

PACKAGE = "galvi"
FOR_AN_INSTALLATION = ("pyproject.toml", "README.md", "constraints.txt")
KERNELS = f"__pycache__/{FOLDER}"


class CannotCompare(Exception):
    """Nothing can be compared; the message gives the reason and the remedy."""


@dataclass(frozen=True)
class Checkout:
    """A copy of galvi.

    folder  contains the package
    name    for messages, e.g. "a1b2c3d4e5f6"
    python  interpreter to run it with
    places  where it imports from; () for the folder alone
    """

    folder: Path
    name: str
    python: str = sys.executable
    places: tuple[Path, ...] = ()


@contextmanager
def checkouts(revision: str, root: Path) -> Iterator[tuple[Checkout, Checkout]]:
    """The revision and the working tree of the repository at root; both are removed afterwards.

    Raises CannotCompare for a revision that git does not know, for one without galvi, and when the
    current folder belongs to another repository.
    """
    _check_current_folder(root)
    commit = commit_of(revision, root)
    with tempfile.TemporaryDirectory(prefix="galvi-track-") as place:
        base = committed(commit, root, Path(place) / "base")
        yield base, working_tree(root, Path(place) / "head")


def committed(commit: str, root: Path, folder: Path) -> Checkout:
    """Extract the files of a commit. Raises CannotCompare for a commit without galvi."""
    extract(commit, root, folder)
    if not (folder / PACKAGE).is_dir():
        raise CannotCompare(
            f"--against expects a revision that has {PACKAGE}; {commit[:12]} has none."
        )
    seed_kernels(root, folder)
    return Checkout(folder, commit[:12])


def extract(commit: str, root: Path, folder: Path) -> None:
    """All files of a commit."""
    with tarfile.open(fileobj=io.BytesIO(git(root, "archive", "--format=tar", commit))) as archive:
        archive.extractall(folder, filter="data")


def working_tree(root: Path, folder: Path) -> Checkout:
    """Copy the working tree, so that edits during a comparison have no effect on it."""
    kept = shutil.ignore_patterns("__pycache__")
    shutil.copytree(root / PACKAGE, folder / PACKAGE, ignore=kept)
    for name in FOR_AN_INSTALLATION:
        with suppress(FileNotFoundError):
            shutil.copyfile(root / name, folder / name)
    seed_kernels(root, folder)
    commit = git(root, "rev-parse", "HEAD").decode().strip()[:12]
    changed = git(root, "status", "--porcelain", "--", PACKAGE)
    return Checkout(folder, f"the working tree ({commit} with changes)" if changed else commit)


def seed_kernels(root: Path, folder: Path) -> None:
    """Copy the compiled kernels; another process may remove some of them meanwhile."""
    for cache in (root / PACKAGE).rglob(KERNELS):
        to = folder / cache.relative_to(root)
        if to.parent.parent.is_dir():
            with suppress(OSError):  # shutil.Error is one
                shutil.copytree(cache, to, dirs_exist_ok=True)


def _check_current_folder(root: Path) -> None:
    """Raise CannotCompare in another repository, whose HEAD would be mistaken for galvi's."""
    own, here = top_of(root), top_of(Path.cwd())
    theirs = "another project's integrators need --contender package.module:Class"
    if own is None:
        raise CannotCompare(
            f"track --against needs a git checkout of galvi, and {root} is none; {theirs}."
        )
    if own != here:
        raise CannotCompare(
            f"track --against compares revisions of its own checkout: expected to be run in {own}, "
            f"received {here or Path.cwd()}; change to {own} first, or, as {theirs}, give that."
        )


def top_of(folder: Path) -> Path | None:
    """The root of the repository that contains a folder; None outside of any."""
    try:
        return Path(git(folder, "rev-parse", "--show-toplevel").decode().strip())
    except subprocess.CalledProcessError:
        return None


def commit_of(revision: str, root: Path) -> str:
    """The full name of a revision. Raises CannotCompare for one that git does not know."""
    name = f"{revision}^{{commit}}"
    try:
        found = git(root, "rev-parse", "--verify", "--quiet", "--end-of-options", name)
    except subprocess.CalledProcessError:
        raise CannotCompare(
            f"--against expects a revision that git knows; received {revision!r}. "
            "Name a commit, a branch or a tag; in a shallow clone, fetch it first."
        ) from None
    return found.decode().strip()


def git(folder: Path, *arguments: str) -> bytes:
    """What git prints. Raises CannotCompare without git, CalledProcessError where git fails."""
    try:
        done = subprocess.run(["git", *arguments], cwd=folder, capture_output=True, check=True)
    except FileNotFoundError:
        raise CannotCompare("track --against needs git, which is not installed.") from None
    return done.stdout

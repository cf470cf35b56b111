"""Temporary copies of a repository: the base, a revision, and the head, the working tree.

Edits during a comparison do not affect them.

Copies of galvi's repository have kernel caches of their own, which begin as copies of the working
tree's; galvi loads only kernels that were compiled from identical sources.
"""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import dataclass, replace
from pathlib import Path

import galvi
from benchmarks.store.isolated_environment import EnvironmentUnavailable, interpreter_in, output_of
from galvi.command import places_in
from galvi.kernels.compile.cache import KERNELS_FOLDER

PACKAGE = "galvi"
KERNELS = f"__pycache__/{KERNELS_FOLDER}"
CONSTRAINTS = "constraints.txt"


class CannotCompare(Exception):
    """Nothing can be compared; the message gives the reason and the remedy."""


@dataclass(frozen=True)
class Checkout:
    """A copy of a repository.

    Attributes
    ----------
    folder
        folder of the copy
    commit
        full hash
    changed
        whether the copy differs from that commit
    places
        folders from which Python imports; () for `folder` alone
    python
        path of the interpreter to run it with
    """

    folder: Path
    commit: str
    changed: bool = False
    places: tuple[Path, ...] = ()
    python: str = sys.executable

    @property
    def name(self) -> str:
        """The name in messages: 12 digits of the hash, with a remark on a changed working tree."""
        digits = self.commit[:12]
        return f"the working tree ({digits} with changes)" if self.changed else digits


@contextmanager
def checkouts(revision: str, root: Path) -> Iterator[tuple[Checkout, Checkout]]:
    """Copies of the revision and of the working tree of galvi's repository at root, which are
    removed with the context.

    Raises CannotCompare for a revision that git does not know, for one without galvi, and if the
    current folder is in another repository, whose HEAD would be mistaken for galvi's.
    """
    top, current = top_of(root), top_of(Path.cwd())
    if top is None or top != current:
        raise CannotCompare(
            f"track --against expects to be run in {top or 'a git checkout of galvi'}; received "
            f"{current or Path.cwd()}. Change to the former, or name an integrator of the latter "
            "with --contender package.module:Class."
        )
    with _copies(revision, top) as both:
        if not (both[0].folder / PACKAGE).is_dir():
            raise CannotCompare(
                f"--against expects a revision that has {PACKAGE}; {both[0].name} has none."
            )
        for side in both:
            copy_kernels(top, side.folder)
        yield both


@contextmanager
def project_checkouts(revision: str, folder: Path) -> Iterator[tuple[Checkout, Checkout]]:
    """As `checkouts`, for the repository that contains a folder.

    Python imports galvi from its present location, and other modules from the copies of this
    folder, of the repository's root, and of a ``src`` in either. Raises CannotCompare outside of a
    repository, and for a revision that git does not know.
    """
    top = top_of(folder)
    if top is None:
        raise CannotCompare(f"track --against needs a git repository; {folder} is in none.")
    inner = folder.resolve().relative_to(top.resolve())
    with (
        _copies(revision, top) as both,
        tempfile.TemporaryDirectory(prefix="galvi-track-") as galvi_folder,
    ):
        # galvi alone, before a file of that name in the repository
        (Path(galvi_folder) / PACKAGE).symlink_to(
            Path(galvi.__file__).parent, target_is_directory=True
        )
        base, head = (
            replace(side, places=(Path(galvi_folder), *places_in(side.folder, inner)))
            for side in both
        )
        yield base, head


@contextmanager
def _copies(revision: str, top: Path) -> Iterator[tuple[Checkout, Checkout]]:
    try:
        name = f"{revision}^{{commit}}"
        commit = git(top, "rev-parse", "--verify", "--quiet", "--end-of-options", name).strip()
    except subprocess.CalledProcessError:
        raise CannotCompare(
            f"--against expects a revision that git knows; received {revision!r}. "
            "Name a commit, a branch or a tag; in a shallow clone, fetch it first."
        ) from None
    with tempfile.TemporaryDirectory(prefix="galvi-track-") as folder:
        base, head = Path(folder) / "base", Path(folder) / "head"
        base.mkdir()
        index = str(Path(folder) / "index")  # the repository's own stays as it is
        git(top, "read-tree", commit.decode(), GIT_INDEX_FILE=index)
        git(top, "checkout-index", "--all", f"--prefix={base}/", GIT_INDEX_FILE=index)
        copy_working_tree(top, head)
        # What a run leaves, such as its output and compiled modules, is no change of the code.
        new_modules = git(top, "ls-files", "--others", "--exclude-standard", "--", "*.py")
        changed = bool(git(top, "status", "--porcelain", "--untracked-files=no") or new_modules)
        head_commit = git(top, "rev-parse", "HEAD").decode().strip()
        yield Checkout(base, commit.decode()), Checkout(head, head_commit, changed)


def copy_working_tree(top: Path, folder: Path) -> None:
    """Copy the files that git tracks or would add; removed and ignored files are left out."""
    listed = git(top, "ls-files", "-z", "--cached", "--others", "--exclude-standard").decode()
    for name in filter(None, listed.split("\0")):
        if (top / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(top / name, folder / name)


def copy_kernels(root: Path, folder: Path) -> None:
    """Copy galvi's compiled kernels, except those that another process removes meanwhile."""
    for cache in (root / PACKAGE).rglob(KERNELS):
        target = folder / cache.relative_to(root)
        if target.parent.parent.is_dir():
            with suppress(OSError):  # shutil.Error is one
                shutil.copytree(cache, target, dirs_exist_ok=True)


def isolated(checkout: Checkout) -> Checkout:
    """The checkout, installed in a new virtual environment in its folder, with the Python of that.

    Raises CannotCompare if the installation fails.
    """
    environment = checkout.folder / "environment"
    python = str(interpreter_in(environment))
    pip = [python, "-I", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    constraints = checkout.folder / CONSTRAINTS
    pip += ["-c", str(constraints)] if constraints.is_file() else []
    try:
        output_of([sys.executable, "-I", "-m", "venv", str(environment)])
        output_of([*pip, str(checkout.folder)])
    except EnvironmentUnavailable as error:
        raise CannotCompare(
            f"--isolate could not install {checkout.name}: {error}. Without it, both sides share "
            "the packages installed here."
        ) from None
    return replace(checkout, python=python)


def top_of(folder: Path) -> Path | None:
    """The root of the repository that contains a folder; None outside of any."""
    try:
        return Path(git(folder, "rev-parse", "--show-toplevel").decode().strip())
    except subprocess.CalledProcessError:
        return None


def git(folder: Path, *arguments: str, **variables: str) -> bytes:
    """Run git in a folder, with `variables` added to the environment; returns its output.

    Raises CannotCompare if git is not installed, and CalledProcessError if it fails.
    """
    command, environment = ["git", *arguments], os.environ | variables
    try:
        return subprocess.run(
            command, cwd=folder, env=environment, capture_output=True, check=True
        ).stdout
    except FileNotFoundError:
        raise CannotCompare("track --against needs git, which is not installed.") from None

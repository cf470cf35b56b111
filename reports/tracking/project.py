"""A project's own benchmarks, checkouts and processes apart."""

from __future__ import annotations

import io
import os
import shutil
import subprocess
import sys
import tarfile
import tempfile
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.store.isolated_environment import NotHere, finished
from benchmarks.timings.case import TRAJECTORY, Case, Thresholds
from benchmarks.timings.worker import problem_of
from benchmarks.work_precision.participants import finest
from galvi.command import places_in
from galvi.kernels.compile.cache import KERNELS_FOLDER

CONSTRAINTS = "constraints.txt"


def isolated(checkout: Checkout) -> Checkout:
    """The checkout with the Python of a new virtual environment in its folder.

    Raises CannotCompare when the installation fails.
    """
    place = checkout.folder / "environment"
    python = str(place / "bin" / "python")
    pip = [python, "-I", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    limits = checkout.folder / CONSTRAINTS
    limited = ["-c", str(limits)] if limits.is_file() else []
    try:
        finished([sys.executable, "-I", "-m", "venv", str(place)])
        finished([*pip, *limited, str(checkout.folder)])
    except NotHere as error:
        raise CannotCompare(
            f"--isolate could not install {checkout.name}: {error}. Without it, both sides share "
            "the packages installed here."
        ) from None
    return replace(checkout, python=python)


# Two copies of galvi in separate folders: a revision, and the current working tree.
#
# Each has its own kernel cache, initially a copy of the working tree's; galvi loads only kernels
# compiled from identical sources.

PACKAGE = "galvi"
FOR_AN_INSTALLATION = ("pyproject.toml", "README.md", "constraints.txt")
KERNELS = f"__pycache__/{KERNELS_FOLDER}"


class CannotCompare(Exception):
    """Nothing can be compared; the message gives the reason and the remedy."""


@dataclass(frozen=True)
class Checkout:
    """A copy of galvi.

    folder  contains the package
    name    for messages, e.g. "a1b2c3d4e5f6"
    commit  in full, "" where nobody asks
    changed  whether it is not exactly that commit
    python  interpreter to run it with
    places  where it imports from; () for the folder alone
    """

    folder: Path
    name: str
    python: str = sys.executable
    places: tuple[Path, ...] = ()
    commit: str = ""
    changed: bool = False


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
        safe = {"filter": "data"} if hasattr(tarfile, "data_filter") else {}  # before 3.11.4
        archive.extractall(folder, **safe)  # type: ignore[arg-type]


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


@dataclass(frozen=True)
class TrackedProblem:
    """A problem that every integrator which supports it is compared on.

    name       in galvi.problems, called with the arguments
    duration   in the problem's unit of time
    truth      name of a reference, at its tolerance `tight`; 0 for its default
    accuracy   times the least error that is compared: how large the motion is, or how much less
               accurate the truth
    """

    name: str
    duration: float
    truth: str
    arguments: Mapping[str, Any] = field(default_factory=dict)
    tight: float = 0.0
    accuracy: float = 1.0


# All start in motion, so that a reversed time shows.
PROBLEMS = (
    TrackedProblem("harmonic_oscillator", 5.0, "oscillator, closed form", {"velocity": 0.5}),
    TrackedProblem("kepler", 5.0, "Kepler, closed form", {"eccentricity": 0.3}),
    TrackedProblem("planar_pendulum", 5.0, "pendulum, closed form", {"rate": -0.5}),
    TrackedProblem("henon_heiles", 5.0, "SciPy DOP853", tight=1e-13, accuracy=10.0),
    TrackedProblem("driven_oscillator", 5.0, "SciPy DOP853", tight=1e-13, accuracy=10.0),
    TrackedProblem("outer_solar_system", 7305.0, "REBOUND IAS15", accuracy=100.0),
    TrackedProblem("free_rigid_body", 5.0, "free rigid body, closed form"),
    TrackedProblem("pendulum_3d", 5.0, "stored truth, rigid bodies", accuracy=10.0),
    TrackedProblem("double_pendulum", 1.0, "SciPy DOP853, chains", {"rates": (0.5, -0.3)}, 1e-13,
                   30.0),
)  # fmt: skip
FEWEST = 100  # steps of an integrator that offers no settings
LOOK = """
import importlib, sys
for path in sys.argv[1:]:
    module, _, name = path.partition(":")
    try:
        if not hasattr(importlib.import_module(module), name):
            print("absent", path, flush=True)
    except ModuleNotFoundError as error:
        if f"{module}.".startswith(f"{error.name}."):
            print("absent", path, flush=True)
    except BaseException:  # it is there, and what it raises is told by its run
        pass
"""


@contextmanager
def project_checkouts(revision: str, here: Path) -> Iterator[tuple[Checkout, Checkout]]:
    """The revision and the working tree of the repository around a folder; both are removed
    afterwards.

    Python imports galvi from where it is, and else from this folder, the repository's root and a
    ``src`` in either, as copied. Files that git ignores are not copied. Raises CannotCompare
    outside of a repository, and for a revision that git does not know.
    """
    top = top_of(here)
    if top is None:
        raise CannotCompare(f"track --against needs a git repository; {here} is in none.")
    commit = commit_of(revision, top)
    inner = here.resolve().relative_to(top.resolve())
    with tempfile.TemporaryDirectory(prefix="galvi-track-") as place:
        folders = [Path(place) / side for side in ("base", "head")]
        extract(commit, top, folders[0])
        _copy(top, folders[1])
        changed = git(top, "status", "--porcelain")
        own = git(top, "rev-parse", "HEAD").decode().strip()
        name = own[:12]
        names = (commit[:12], f"the working tree ({name} with changes)" if changed else name)
        ours = Path(place) / "ours"  # galvi alone, before a file of that name in the repository
        ours.mkdir()
        (ours / "galvi").symlink_to(Path(galvi.__file__).parent, target_is_directory=True)
        sides = [
            Checkout(
                folder, name, places=(ours, *places_in(folder, inner)), commit=own, changed=edited
            )
            for folder, name, own, edited in zip(
                folders, names, (commit, own), (False, bool(changed)), strict=True
            )
        ]
        yield sides[0], sides[1]


def contender_cases(paths: Sequence[str], limit: float, thresholds: Thresholds) -> tuple[Case, ...]:
    """Its finest setting on each problem that an integrator supports, in the working tree.

    paths  "package.module:Class"
    limit  of each answer, in seconds

    Raises ContenderError for one that cannot be loaded, CannotCompare where none takes a problem,
    and where one fails to say which it takes.
    """
    found = []
    for path in dict.fromkeys(paths):
        external = ExternalIntegrator.open(path, limit)
        try:
            for tracked in PROBLEMS:
                problem = problem_of({"problem": tracked.name, "arguments": tracked.arguments})
                setting = finest(external, problem, tracked.duration, 1, FEWEST)
                if external.faults:
                    raise CannotCompare(external.faults[0])
                if setting is not None:
                    case = Case(
                        f"{external.name}, {problem.name}", TRAJECTORY, tracked.name, 0, 0,
                        tracked.duration, 1, tracked.truth, tracked.arguments,
                        truth_tolerance=tracked.tight, contender=path, setting=dict(setting),
                        slower=thresholds.slower, error_tolerance=thresholds.less_accurate,
                        rounding=thresholds.round_off * tracked.accuracy,
                    )  # fmt: skip
                    found.append(case)
        finally:
            external.close()
    if not found:
        raise CannotCompare(
            f"{' and '.join(paths)} take none of the problems compared on: "
            f"{', '.join(tracked.name for tracked in PROBLEMS)}."
        )
    return tuple(found)


def absent(checkout: Checkout, paths: Sequence[str], limit: float) -> tuple[str, ...]:
    """The paths "package.module:Class" whose module, or class in it, a checkout does not have.

    limit  seconds for their import
    """
    places = [str(one) for one in checkout.places]
    try:
        answer = subprocess.run(
            [checkout.python, "-P", "-c", LOOK, *paths], capture_output=True, text=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(places)}, timeout=limit,
        )  # fmt: skip
    except subprocess.TimeoutExpired:
        return ()  # it is there, and hangs, which is told by its run
    return tuple(path for path in paths if f"absent {path}" in answer.stdout.splitlines())


def _copy(top: Path, folder: Path) -> None:
    """The files that git knows, or would: neither ignored nor removed."""
    listed = git(top, "ls-files", "-z", "--cached", "--others", "--exclude-standard").decode()
    for name in filter(None, listed.split("\0")):
        if (top / name).is_file():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(top / name, folder / name)

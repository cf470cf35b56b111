"""Two copies of another project's repository, and the runs of its integrators to compare there."""

from __future__ import annotations

import os
import shutil
import subprocess
import tempfile
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

import galvi
from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.timings.case import TRAJECTORY, Case
from benchmarks.timings.worker import problem_of
from galvi.command import places_in
from reports.tracking.checkouts import CannotCompare, Checkout, commit_of, extract, git, top_of

PROBLEMS = {  # of galvi: arguments, duration, and the reference that is the truth
    "harmonic_oscillator": ({}, 5.0, "oscillator, closed form"),
    "kepler": ({"eccentricity": 0.3}, 5.0, "Kepler, closed form"),
    "planar_pendulum": ({}, 5.0, "pendulum, closed form"),
    "outer_solar_system": ({}, 7305.0, "REBOUND IAS15"),
    "free_rigid_body": ({}, 5.0, "free rigid body, closed form"),
    "pendulum_3d": ({}, 5.0, "stored truth, rigid bodies"),
    "double_pendulum": ({}, 1.0, "stored truth, chains"),
}
PATIENCE = 60.0  # seconds for an import
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
        name = git(top, "rev-parse", "HEAD").decode().strip()[:12]
        names = (commit[:12], f"the working tree ({name} with changes)" if changed else name)
        ours = Path(place) / "ours"  # galvi alone, before a file of that name in the repository
        ours.mkdir()
        (ours / "galvi").symlink_to(Path(galvi.__file__).parent, target_is_directory=True)
        sides = [
            Checkout(folder, name, places=(ours, *places_in(folder, inner)))
            for folder, name in zip(folders, names, strict=True)
        ]
        yield sides[0], sides[1]


def contender_cases(paths: Sequence[str]) -> tuple[Case, ...]:
    """Its finest setting on each problem that an integrator supports, in the working tree.

    paths  "package.module:Class"

    Raises ContenderError for one that cannot be loaded, CannotCompare where none takes a problem.
    """
    found = []
    for path in dict.fromkeys(paths):
        external = ExternalIntegrator.open(path)
        try:
            for name, (arguments, duration, truth) in PROBLEMS.items():
                problem = problem_of({"problem": name, "arguments": arguments})
                if not external.supports(problem):
                    continue
                offered = external.settings(problem, duration, FEWEST)
                if offered:
                    case = Case(
                        f"{external.name}, {problem.name}", TRAJECTORY, name, 0, 0, duration, 1,
                        truth, arguments, contender=path, setting=dict(offered[-1]),
                    )  # fmt: skip
                    found.append(case)
            if external.faults:
                raise CannotCompare(external.faults[0])
        finally:
            external.close()
    if not found:
        raise CannotCompare(
            f"{' and '.join(paths)} take none of the problems compared on: {', '.join(PROBLEMS)}."
        )
    return tuple(found)


def absent(checkout: Checkout, paths: Sequence[str]) -> tuple[str, ...]:
    """The paths "package.module:Class" whose module, or class in it, a checkout does not have."""
    places = [str(one) for one in checkout.places]
    try:
        answer = subprocess.run(
            [checkout.python, "-P", "-c", LOOK, *paths], capture_output=True, text=True,
            env=os.environ | {"PYTHONPATH": os.pathsep.join(places)}, timeout=PATIENCE,
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

"""Releases of an engine: those installed and on the package index, and an interpreter of each."""

from __future__ import annotations

import importlib
import re
import sys
from collections.abc import Iterator, Sequence
from contextlib import ExitStack, contextmanager
from pathlib import Path

from benchmarks.store.isolated_environment import EnvironmentUnavailable, environment, output_of

# Releases that are compared with the installed one where none are named.
USUAL_RELEASES = {
    "mujoco": ("3.6.0", "3.10.0", "3.11.0", "3.13.0", "3.17.0"),
    "rebound": ("3.28.4", "4.0.3", "4.6.0", "5.0.1"),
}
CORE_PACKAGE = "mujoco-core"  # package of the library, from release 4 on
RANGE = ".."
NO_WHEEL = "No matching distribution"  # beginning of pip's message
PATTERN = re.compile(r"\d+(\.\d+)+(\.post\d+)?")


def installed(package: str) -> str:
    """The release of a package in this environment; "" where it is not installed."""
    try:
        return str(importlib.import_module(package).__version__)
    except ImportError:
        return ""


def by_age(version: str) -> tuple[int, ...]:
    """A sort key of releases, by which 3.6.0 comes before 3.10.0."""
    return tuple(map(int, re.findall(r"\d+", version)))


def requirement(package: str, version: str) -> str:
    """The requirement for pip of a release of an engine."""
    of_core = package == "mujoco" and by_age(version) >= (4,)
    return f"{CORE_PACKAGE if of_core else package}=={version}"


def requested_releases(package: str, texts: Sequence[str]) -> tuple[list[str], bool]:
    """The requested releases, oldest first, and whether they are the ends of a range.

    Parameters
    ----------
    texts
        such as ["3.17.0", "4.0.1"] or ["3.6.0..4.0.1"]; an empty list stands for USUAL_RELEASES

    Raises
    ------
    ValueError
        For texts of another form.
    """
    is_range = len(texts) == 1 and RANGE in texts[0]
    versions = texts[0].split(RANGE) if is_range else list(texts or USUAL_RELEASES[package])
    versions = [version.strip() for version in versions]
    wrong = [version for version in versions if not PATTERN.fullmatch(version)]
    if wrong or (is_range and len(versions) != 2):
        raise ValueError(
            f"--releases expects releases as 3.17.0,4.0.1, or two ends as 3.6.0{RANGE}4.0.1; "
            f"received {','.join(texts)!r}."
        )
    return sorted(dict.fromkeys(versions), key=by_age), is_range


def listed(package: str) -> list[str]:
    """All final releases on the package index, oldest first.

    Raises EnvironmentUnavailable where pip fails or lists none.
    """
    versions: set[str] = set()
    for name in (package, CORE_PACKAGE) if package == "mujoco" else (package,):
        pip = [sys.executable, "-I", "-m", "pip", "--disable-pip-version-check", "index"]
        output = output_of([*pip, "versions", "--only-binary=:all:", name])
        line = re.search("^Available versions: (.*)$", output, re.MULTILINE)
        if line is None:
            raise EnvironmentUnavailable(f"pip lists no releases of {name}.")
        versions |= {version for version in line[1].split(", ") if PATTERN.fullmatch(version)}
    return sorted(versions, key=by_age)


@contextmanager
def interpreter(package: str, version: str, folder: Path) -> Iterator[Path]:
    """The interpreter of an environment with this release, which is removed afterwards.

    It is that of this environment where the release is installed here. Raises
    EnvironmentUnavailable where the release cannot be installed.
    """
    if version == installed(package):
        yield Path(sys.executable)
    else:
        with ExitStack() as stack:
            try:
                python = stack.enter_context(environment(requirement(package, version), folder))
            except EnvironmentUnavailable as error:
                if not str(error).startswith(NO_WHEEL):
                    raise
                system = f"Python {sys.version_info.major}.{sys.version_info.minor}"
                raise EnvironmentUnavailable(
                    f"{error}: no such release, no wheel of it for {system}, or no package index"
                ) from None
            yield python

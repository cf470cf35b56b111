"""The command ``galvi``, which runs the suite.

In a wheel the suite's folders are in ``galvi/_suite``, in a checkout beside ``galvi``. The folder
that contains them is the first on sys.path, so that a user's folders of these names are not
imported instead. The last are the current folder, the root of its repository and a ``src`` in
either, for integrators and problems named on the command line.
"""

from __future__ import annotations

import importlib
import json
import runpy
import sys
from pathlib import Path

from galvi.environment import NOT_INSTALLED
from galvi.repository import repository_of

HERE = Path(__file__).parent
SUITE = HERE / "_suite"
INSTALL = "pip install 'galvi[suite]'"
CANNOT = 2  # exit status of a command that cannot be carried out


def called(program: str) -> list[str]:
    """The command line by which the program was called, for usage and provenance."""
    path = Path(program)
    return ["python", "-m", path.parent.name] if path.name == "__main__.py" else [path.stem]


def main() -> int:
    """Run the suite's command line; returns its exit status, also where it cannot be imported."""
    put_suite_first()
    try:
        runpy.run_module("reports", {"CALLED": called(sys.argv[0])}, "__main__", alter_sys=True)
    except ModuleNotFoundError as error:
        print(missing_package(error), file=sys.stderr)
        return NOT_INSTALLED
    except ImportError as error:
        print(f"The command cannot be imported: {error}. Repair it: {INSTALL}.", file=sys.stderr)
        return CANNOT
    except SystemExit as ended:
        return ended.code if isinstance(ended.code, int) else int(ended.code is not None)
    return 0


def serve_checks() -> None:
    """Answer the plugin of pytest, see `benchmarks.applications.external.served_checks`, or print a
    JSON line with the reason where a package of the suite is missing."""
    put_suite_first()
    try:
        served_checks = importlib.import_module("benchmarks.applications.external.served_checks")
    except ModuleNotFoundError as error:
        print(json.dumps({"usage": missing_package(error)}), flush=True)
    else:
        served_checks.serve()


def missing_package(error: ModuleNotFoundError) -> str:
    """A sentence on the package that is not installed, and the command that installs it."""
    return (
        f"The command needs the packages of the suite, of which {error.name} is not installed. "
        f"Install them: {INSTALL}."
    )


def put_suite_first() -> None:
    """Put the suite's folder first on sys.path, and the folders of the caller's modules last."""
    suite_folder, folder = str(SUITE if SUITE.is_dir() else HERE.parent), Path.cwd()
    top = repository_of(folder)
    search_paths = places_in(top, folder.relative_to(top))
    own_paths = [str(path) for path in search_paths if path.is_dir() and str(path) != suite_folder]
    other_paths = [path for path in sys.path if path not in (suite_folder, "", str(folder))]
    sys.path[:] = [
        suite_folder,
        *other_paths,
        *(path for path in own_paths if path not in other_paths),
    ]


def places_in(top: Path, inner: Path) -> tuple[Path, ...]:
    """The folders of a repository in which modules are looked up by a command that is called in its
    folder ``inner``."""
    return tuple(dict.fromkeys((top / inner, top / inner / "src", top, top / "src")))

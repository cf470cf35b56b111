"""Environments of their own for both sides, each with what its own revision asks for."""

from __future__ import annotations

import sys

from benchmarks.studies.isolated_environment import NotHere, finished
from reports.tracking.trees import CannotCompare, Tree

CONSTRAINTS = "constraints.txt"


def interpreters(base: Tree, head: Tree) -> tuple[str, str]:
    """Python of two new virtual environments, in the trees' folders, which go with them.

    Raises CannotCompare when one cannot be made.
    """
    return _installed(base), _installed(head)


def _installed(tree: Tree) -> str:
    place = tree.folder / "environment"
    interpreter = place / "bin" / "python"
    pip = [str(interpreter), "-I", "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
    limits = tree.folder / CONSTRAINTS
    limited = ["-c", str(limits)] if limits.is_file() else []
    try:
        finished([sys.executable, "-I", "-m", "venv", str(place)])
        finished([*pip, *limited, str(tree.folder)])
    except NotHere as error:
        raise CannotCompare(
            f"--isolate could not install {tree.name}: {error}. Without it, both sides share "
            "the packages that are installed here."
        ) from None
    return str(interpreter)

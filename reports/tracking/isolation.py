"""A separate environment for a checkout, with the packages that its revision requires."""

from __future__ import annotations

import sys
from dataclasses import replace

from benchmarks.store.isolated_environment import NotHere, finished
from reports.tracking.checkouts import CannotCompare, Checkout

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

"""The command `galvi`, as `python -m reports`; `--help` lists what it does."""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING

from reports.cli.commands import PROGRAM, run

if TYPE_CHECKING:
    from reports.results.suite import Suite


def load() -> Suite:
    """The report's suite, imported when called, so that usage errors are reported at once."""
    from reports.contents import load

    return load()


if __name__ == "__main__":
    sys.exit(run(load, sys.argv[1:], globals().get("CALLED", PROGRAM)))

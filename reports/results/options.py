"""The options of the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from benchmarks.store.provenance import ROOT

CONTENDER_PREFIX = "A-"  # prefix of the ids of `benchmarks.applications.external.checks`
PROJECT_FOLDER = "galvi-out"  # of another project
OUT = Path("reports/out" if Path.cwd() == ROOT and (ROOT / "galvi").is_dir() else PROJECT_FOLDER)


@dataclass(frozen=True)
class Options:
    """The options of a command.

    Attributes
    ----------
    quick
        the quick setting
    claims
        ids of the selected claims; () for all
    out
        output folder
    command
        as typed
    called
        the words before the command, such as "galvi"
    fail_under
        percent of the checks that must come out as expected
    require
        engines that must be available
    contenders
        external integrators, as package.module:Class
    anew
        do not resume an interrupted build
    """

    quick: bool = False
    claims: tuple[str, ...] = ()
    out: Path = OUT
    command: str = "python -m reports"
    require: tuple[str, ...] = ()
    contenders: tuple[str, ...] = ()
    anew: bool = False
    called: str = "python -m reports"
    fail_under: float = 100.0

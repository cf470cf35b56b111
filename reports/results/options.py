"""What may be asked for on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

OUT = Path("reports/out")


@dataclass(frozen=True)
class Options:
    """What a command was asked for.

    quick       the short form
    claims      ids of those that were chosen; () for all
    out         folder to write in
    command     as typed
    require     engines whose absence is a failure
    contenders  external integrators, as package.module:Class
    anew        take up nothing of a build that was stopped
    """

    quick: bool = False
    claims: tuple[str, ...] = ()
    out: Path = OUT
    command: str = "python -m reports"
    require: tuple[str, ...] = ()
    contenders: tuple[str, ...] = ()
    anew: bool = False

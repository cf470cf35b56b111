"""What was asked for on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

OUT = Path("reports/out")


@dataclass(frozen=True)
class Order:
    """quick: the short form; claims: chosen ids, () for all; out: folder; command: as typed;
    require: engines that must be there; contenders: paths of outsiders, as typed; anew: nothing of
    a build that did not end is taken up.
    """

    quick: bool = False
    claims: tuple[str, ...] = ()
    out: Path = OUT
    command: str = "python -m reports"
    require: tuple[str, ...] = ()
    contenders: tuple[str, ...] = ()
    anew: bool = False

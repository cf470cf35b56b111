"""What was asked for on the command line."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

OUT = Path("reports/out")


@dataclass(frozen=True)
class Order:
    """quick: the short form; claims: chosen ids, () for all; out: folder; command: as typed;
    require: engines that must be there.
    """

    quick: bool = False
    claims: tuple[str, ...] = ()
    out: Path = OUT
    command: str = "python -m reports"
    require: tuple[str, ...] = ()

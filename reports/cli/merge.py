"""`merge`: rows and benches of other machines beside those of this one."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

import typer


def merge_command(out: Path, folders: Sequence[Path]) -> int:
    """Bring them in, and print what came. Raises typer.BadParameter for a folder without any."""
    from reports.results.machines import merge

    try:
        print("\n".join(merge(out, folders)))
    except ValueError as error:
        raise typer.BadParameter(f"merge: {error}") from None
    return 0

"""Files that are there as a whole or not at all."""

from __future__ import annotations

import os
import uuid
from collections.abc import Callable
from pathlib import Path


def write_whole(path: Path, write: Callable[[Path], object]) -> None:
    """Write a file under another name, and then rename it; nothing is left when that fails.

    write  (a path) writes it

    Its permissions are those of any new file, as the user's umask has them.
    """
    partial = path.with_name(f".{uuid.uuid4().hex}.partial")
    try:
        write(partial)
        os.replace(partial, path)
    except BaseException:
        partial.unlink(missing_ok=True)
        raise

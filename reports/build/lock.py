"""Allow one build at a time per folder: two would mix their files and disturb their timings."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from filelock import FileLock, Timeout

LOCK = ".build"  # in the folder


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Lock the folder until the context or the process ends.

    Raises typer.BadParameter while another process holds the lock, and when the folder is not
    writable.
    """
    lock = FileLock(folder / LOCK)
    try:
        lock.acquire(blocking=False)
    except Timeout:
        raise typer.BadParameter(
            f"another build is at work in {folder}; wait until it ends, or choose another folder "
            "with --out."
        ) from None
    except OSError as error:
        raise typer.BadParameter(f"--out expects a folder to write in; {error}.") from None
    try:
        yield
    finally:
        lock.release()

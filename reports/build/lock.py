"""One build at a time in a folder: the files of two would be mixed, and their times disturbed."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer
from filelock import FileLock, Timeout

LOCK = ".build"  # in the folder


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Hold the folder until the end, or the death, of this process.

    Raises typer.BadParameter, in a sentence, while another process holds it, and when no file can
    be written in it.
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

"""One build at a time in a folder: the files of two would be mixed, and their times disturbed."""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import typer

LOCK = ".build"  # in the folder; empty, or the number of the process that last built there


@contextmanager
def alone(folder: Path) -> Iterator[None]:
    """Hold the folder until the end, or the death, of this process.

    Raises typer.BadParameter, in a sentence, while another process holds it, and when no file can
    be written in it. Where the system has no such locks, nothing is held.
    """
    try:
        import fcntl
    except ImportError:
        yield
        return
    try:
        opened = (folder / LOCK).open("a+", encoding="utf-8")
    except OSError as error:
        raise typer.BadParameter(f"--out expects a folder to write in; {error}.") from None
    with opened as file:
        try:
            fcntl.lockf(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            file.seek(0)
            raise typer.BadParameter(
                f"another build is at work in {folder} (process {file.read().strip()}); wait until "
                "it ends, or choose another folder with --out."
            ) from None
        except OSError:  # a file system without locks
            yield
            return
        file.truncate(0)
        file.write(f"{os.getpid()}\n")
        file.flush()
        yield

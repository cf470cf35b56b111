"""One process compiles a kernel, the others that need it wait for what it keeps on disk."""

from __future__ import annotations

import time
from contextlib import suppress
from pathlib import Path
from typing import IO

PATIENCE = 120.0  # seconds: more than the longest compilation takes on a busy machine
PAUSE = 0.05


class Turn:
    """The right to compile what will be kept at a path; it ends with its process at the latest."""

    def __init__(self, path: Path) -> None:
        self.path = path.with_suffix(".turn")
        self.file: IO[str] | None = None

    def take(self, patience: float = PATIENCE) -> bool:
        """Wait for it; whether somebody else had it meanwhile, and may have kept something."""
        waited, end = False, time.monotonic() + patience
        with suppress(OSError, ImportError):  # no file or no locks: as if there were no others
            import fcntl

            self.path.parent.mkdir(exist_ok=True)
            file = self.path.open("a")
            try:
                while self.file is None and time.monotonic() < end:
                    try:
                        fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
                        self.file = file
                    except BlockingIOError:
                        waited = True
                        time.sleep(PAUSE)
            finally:
                if self.file is None:
                    file.close()
        return waited

    def end(self) -> None:
        """Let the next one have it."""
        if self.file is not None:
            with suppress(OSError):
                self.path.unlink(missing_ok=True)
            self.file.close()
            self.file = None

"""The output of an external integrator, read apart from galvi's: a count and the first lines."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

from benchmarks.store.foreign_texts import LONGEST_LOG_LINE, log_line

FIRST_LINES = 20  # lines that are kept
READ_BYTES = 1 << 16  # bytes of a read


@dataclass(eq=False)
class Printed:
    """The output of the processes of one integrator.

    Attributes
    ----------
    lines
        number of lines; an unfinished one counts
    first
        the first FIRST_LINES lines, each as one line of a log
    """

    lines: int = 0
    first: list[str] = field(default_factory=list)
    _readers: list[threading.Thread] = field(default_factory=list)

    def read(self, pipe: Connection) -> None:
        """Read from a pipe, in a thread, until its other ends are closed."""
        reader = threading.Thread(target=self._read, args=(pipe,), daemon=True)
        self._readers.append(reader)
        reader.start()

    def wait(self) -> None:
        """Wait for the readers of processes that have ended, at most 1 s for each."""
        while self._readers:
            self._readers.pop().join(1.0)

    def forget(self) -> None:
        """Reset the number of lines and the first lines."""
        self.lines, self.first = 0, []

    def sentence(self) -> str:
        """A sentence with the number of printed lines and the first one; "" without lines."""
        if not self.lines:
            return ""
        count = f"{self.lines:,} lines, the first of them" if self.lines > 1 else "a line:"
        return f'printed {count} "{self.first[0]}".'

    def _read(self, pipe: Connection) -> None:
        line = b""  # the unfinished one
        with pipe:
            while block := _block(pipe):
                *completed, unfinished = (line + block).split(b"\n")
                self.lines += len(completed)
                self.first += map(_text, completed[: FIRST_LINES - len(self.first)])
                line = unfinished[: 8 * LONGEST_LOG_LINE]  # more bytes than are shown
        if line:
            self.lines += 1
            self.first += [_text(line)] if len(self.first) < FIRST_LINES else []


def _text(line: bytes) -> str:
    return log_line(line.decode("utf-8", "replace"))


def _block(pipe: Connection) -> bytes:
    try:
        return os.read(pipe.fileno(), READ_BYTES)
    except OSError:
        return b""

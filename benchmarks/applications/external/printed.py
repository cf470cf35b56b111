"""What an external integrator prints: kept apart from galvi's output, its first lines as text."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

from benchmarks.store.foreign_texts import LONGEST, log_line

FIRST = 20  # lines that are kept
BLOCK = 1 << 16  # bytes of a read


@dataclass(eq=False)
class Printed:
    """The output of the processes of one integrator.

    Attributes
    ----------
    lines
        number of lines; an unfinished one counts
    first
        the first FIRST lines, as in a log
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
        """Wait until all is read that was printed by processes that have ended."""
        while self._readers:
            self._readers.pop().join(1.0)

    def forget(self) -> None:
        """Reset the number of lines and the first lines."""
        self.lines, self.first = 0, []

    def sentence(self) -> str:
        """The number of printed lines and the first one; empty without lines."""
        if not self.lines:
            return ""
        many = f"{self.lines:,} lines, the first of them" if self.lines > 1 else "a line:"
        return f'printed {many} "{self.first[0]}".'

    def _read(self, pipe: Connection) -> None:
        line = b""  # the unfinished one
        with pipe:
            while block := _block(pipe):
                *ended, unfinished = (line + block).split(b"\n")
                self.lines += len(ended)
                self.first += map(_text, ended[: FIRST - len(self.first)])
                line = unfinished[: 8 * LONGEST]  # more bytes than are shown
        if line:
            self.lines += 1
            self.first += [_text(line)] if len(self.first) < FIRST else []


def _text(line: bytes) -> str:
    return log_line(line.decode("utf-8", "replace"))


def _block(pipe: Connection) -> bytes:
    try:
        return os.read(pipe.fileno(), BLOCK)
    except OSError:
        return b""

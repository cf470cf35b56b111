"""What an external integrator prints: kept apart from galvi's output, its first lines as text."""

from __future__ import annotations

import os
import threading
from dataclasses import dataclass, field
from multiprocessing.connection import Connection

FIRST, LONGEST = 20, 200  # lines that are kept, and characters of each
BLOCK = 1 << 16  # bytes of a read


@dataclass(eq=False)
class Printed:
    """The output of the processes of one integrator.

    lines  number of lines; an unfinished one counts
    first  the first FIRST lines of at most LONGEST printable characters each, harmless in the log
           of a CI service
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

    def sentence(self) -> str:
        """How much was printed; empty for nothing."""
        if not self.lines:
            return ""
        many = f"{self.lines:,} lines, the first of them" if self.lines > 1 else "a line:"
        return f'printed {many} "{self.first[0]}".'

    def _read(self, pipe: Connection) -> None:
        line = b""  # the unfinished one
        with pipe:
            while block := _block(pipe):
                *ended, rest = (line + block).split(b"\n")
                self.lines += len(ended)
                self.first += map(harmless, ended[: FIRST - len(self.first)])
                line = rest[: 4 * LONGEST]  # bytes of as many characters
        if line:
            self.lines += 1
            self.first += [harmless(line)] if len(self.first) < FIRST else []


def _block(pipe: Connection) -> bytes:
    try:
        return os.read(pipe.fileno(), BLOCK)
    except OSError:
        return b""


def harmless(line: bytes) -> str:
    """Its printable characters, without what a CI service takes for a command."""
    text = line[: 4 * LONGEST].decode("utf-8", "replace").replace("\t", " ")
    text = "".join(character for character in text if character.isprintable())[:LONGEST]
    return text.replace("::", ": :").replace("##[", "# #[")

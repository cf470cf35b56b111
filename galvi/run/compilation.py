"""What goes on while a kernel is compiled: other processes wait for it, and the user is told."""

from __future__ import annotations

import logging
from pathlib import Path
from typing import Any

from numba.core import event

from galvi.kernels.compile.cache import use_locks

PATIENCE = 180.0  # seconds: more than the longest compilation takes on a busy machine
# Seconds of processor time that what is called first of a kernel takes to compile, with all that it
# calls: column `cold_processor` of benchmarks/studies/start_up.py.
SECONDS = {
    "galvi.kernels.nystrom.advance.advance": 20,
    "galvi.kernels.lanes.nbody.advance": 7,
    "galvi.kernels.lanes.body.advance_body": 6,
    "galvi.kernels.on_group.advance.advance_group": 40,
    "galvi.kernels.on_group.solve.guess_curve": 15,  # the rest of that kernel is interpreted
}
LOG = logging.getLogger("galvi")


class CompilationNotice(event.Listener):
    """One sentence for each kernel that has to be compiled, in the log named galvi.

    A log that nobody has set up prints it to stderr; it is silenced by
    ``logging.getLogger("galvi").setLevel("ERROR")``.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._said: set[str] = set()

    def on_start(self, event: Any) -> None:
        """A function is about to be compiled; those that it calls follow before it ends."""
        function = event.data["dispatcher"].py_func
        name = f"{function.__module__}.{function.__qualname__}"
        if self._depth == 0 and name in SECONDS and name not in self._said:
            self._said.add(name)
            LOG.warning(
                "galvi is compiling a kernel for this kind of system: about %d s of processor "
                "time, once; later runs load it.",
                SECONDS[name],
            )
        self._depth += 1

    def on_end(self, event: Any) -> None:
        """It was compiled, or could not be."""
        self._depth -= 1


def file_lock(path: Path) -> Any:
    """A lock that ends with its process; ``acquire`` raises OSError after PATIENCE."""
    import filelock  # takes 0.1 s, and only who compiles needs it

    return filelock.FileLock(path, timeout=PATIENCE)


def watch_compilation() -> None:
    """Let kernels be compiled by one process at a time, and say so."""
    use_locks(file_lock)
    event.register("numba:compile", CompilationNotice())  # type: ignore[no-untyped-call]

"""Ctrl-C during a run takes effect between kernel calls, so that no step is left incomplete.

It ends the run, which is returned with its status. Where no step is left to end, it raises
`Interrupted`, which carries the run.
"""

from __future__ import annotations

import signal
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from galvi.trajectory import Trajectory


class Interrupted(KeyboardInterrupt):
    """Ctrl-C when the steps of ``run``, one or several, were all done, or one had failed."""

    def __init__(self, run: Trajectory | tuple[Trajectory, ...]) -> None:
        super().__init__("what was computed is the attribute run of this exception")
        self.run = run


class Interrupts:
    """Whether Ctrl-C was pressed; while ``at_once``, or the second time, it raises."""

    def __init__(self) -> None:
        self._pressed = self._told = self._at_once = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed; the caller acts on it."""
        self._told = self._pressed
        return self._told

    @property
    def lost(self) -> bool:
        """Whether Ctrl-C was pressed and nobody was told."""
        return self._pressed and not self._told

    @contextmanager
    def at_once(self) -> Iterator[None]:
        """Ctrl-C raises within."""
        self._at_once = True
        try:
            yield
        finally:
            self._at_once = False

    def note(self, signum: int, frame: Any) -> None:
        """A handler of signals."""
        if self._pressed or self._at_once:
            self._pressed = self._told = True
            raise KeyboardInterrupt
        self._pressed = True


@contextmanager
def defer_interrupts() -> Iterator[Interrupts]:
    """Ctrl-C within is noted; a second one raises at once, one that nobody asked about at the end.

    Replaces only Python's default handler, and only in the main thread, where signals arrive: a
    handler of the calling program stays in place, and so does an ignored SIGINT, as under nohup.
    """
    interrupts = Interrupts()
    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if ours:
        signal.signal(signal.SIGINT, interrupts.note)
    try:
        yield interrupts
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)
    if interrupts.lost:
        raise KeyboardInterrupt


def uninterrupted(run: Trajectory) -> Trajectory:
    """The run itself; KeyboardInterrupt if it was interrupted. For callers that need all of it."""
    if run.interrupted:
        raise KeyboardInterrupt
    return run

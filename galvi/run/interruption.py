"""Ctrl-C during a run: noted, and acted on between kernel calls, so no state is half done."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from galvi.trajectory import Trajectory


@contextmanager
def defer_interrupts() -> Iterator[Callable[[], bool]]:
    """Yields a function that says whether Ctrl-C was pressed; a second Ctrl-C raises at once.

    Only replaces Python's own handler, and only in the main thread, where signals arrive: a handler
    of the program's stays, and so does Ctrl-C being ignored, as under nohup.
    """
    pressed = False

    def note(signum: int, frame: Any) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    ours = (
        threading.current_thread() is threading.main_thread()
        and signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if ours:
        signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        if ours:
            signal.signal(signal.SIGINT, signal.default_int_handler)


def uninterrupted(run: Trajectory) -> Trajectory:
    """The run, for callers to whom a part of it is of no use: KeyboardInterrupt if that is all."""
    if run.interrupted:
        raise KeyboardInterrupt
    return run

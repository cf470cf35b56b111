"""Ctrl-C during a run takes effect between kernel calls, so that no step is left incomplete."""

from __future__ import annotations

# As signal, which spends 3 us on making an enumeration of a handler.
import _signal  # type: ignore[import-not-found]
import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from galvi.trajectory import Trajectory


@contextmanager
def defer_interrupts() -> Iterator[Callable[[], bool]]:
    """Yields a function that returns whether Ctrl-C was pressed; a second Ctrl-C raises at once.

    Replaces only Python's default handler, and only in the main thread, where signals arrive: a
    handler of the calling program stays in place, and so does an ignored SIGINT, as under nohup.
    """
    pressed = False

    def note(signum: int, frame: Any) -> None:
        nonlocal pressed
        if pressed:
            raise KeyboardInterrupt
        pressed = True

    ours = (
        threading.current_thread() is threading.main_thread()
        and _signal.getsignal(signal.SIGINT) is signal.default_int_handler
    )
    if ours:
        _signal.signal(signal.SIGINT, note)
    try:
        yield lambda: pressed
    finally:
        if ours:
            _signal.signal(signal.SIGINT, signal.default_int_handler)


def uninterrupted(run: Trajectory) -> Trajectory:
    """The run itself; KeyboardInterrupt if it was interrupted. For callers that need all of it."""
    if run.interrupted:
        raise KeyboardInterrupt
    return run

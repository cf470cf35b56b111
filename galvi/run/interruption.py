"""Ctrl-C during a run takes effect between kernel calls, so that no step is left incomplete.

It ends the run, which is returned with its status. Where no step is left to end, it raises
`Interrupted`, which carries the run.
"""

from __future__ import annotations

import threading

# The module behind `signal`, which makes no enums of handlers: 8 us less a run.
from _signal import SIGINT, default_int_handler, getsignal, signal  # type: ignore[import-not-found]
from typing import Any

from galvi.trajectory import Trajectory


class Interrupted(KeyboardInterrupt):
    """Ctrl-C when the steps of ``run``, one or several, were all done, or one had failed."""

    def __init__(self, run: Trajectory | tuple[Trajectory, ...]) -> None:
        super().__init__("what was computed is the attribute run of this exception")
        self.run = run


class Interrupts:
    """Whether Ctrl-C was pressed; the second time it raises."""

    def __init__(self) -> None:
        self._pressed = self._polled = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed; the caller acts on it."""
        self._polled = self._pressed
        return self._polled

    @property
    def unhandled(self) -> bool:
        """Whether Ctrl-C was recorded and never polled."""
        return self._pressed and not self._polled

    def note(self, signum: int, frame: Any) -> None:
        """A handler of signals."""
        if self._pressed:
            self._pressed = self._polled = True
            raise KeyboardInterrupt
        self._pressed = True


class Deferral:
    """The context of `defer_interrupts`, as a class: a generator would take 2 us more."""

    def __enter__(self) -> Interrupts:
        self._interrupts = Interrupts()
        self._replaces_handler = (
            threading.current_thread() is threading.main_thread()
            and getsignal(SIGINT) is default_int_handler
        )
        if self._replaces_handler:
            signal(SIGINT, self._interrupts.note)
        return self._interrupts

    def __exit__(self, exception_type: type[BaseException] | None, *raised: object) -> None:
        if self._replaces_handler:
            signal(SIGINT, default_int_handler)
        if exception_type is None and self._interrupts.unhandled:
            raise KeyboardInterrupt


def defer_interrupts() -> Deferral:
    """Defers Ctrl-C: the first is recorded, a second raises, one never polled raises on exit.

    Replaces only Python's default handler, and only in the main thread, where signals arrive: a
    handler of the calling program stays in place, and so does an ignored SIGINT, as under nohup.
    """
    return Deferral()


def uninterrupted(run: Trajectory) -> Trajectory:
    """The run itself; KeyboardInterrupt if it was interrupted. For callers that need all of it."""
    if run.interrupted:
        raise KeyboardInterrupt
    return run

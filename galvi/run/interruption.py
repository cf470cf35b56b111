"""Ctrl-C during a run takes effect between kernel calls, so that no step is left incomplete.

It ends the run, which is returned with its status. After the last step, or one that failed, it
raises `Interrupted`, which carries the run.
"""

from __future__ import annotations

import threading

# The module behind `signal`, which makes no enums of handlers: 8 us less a run.
from _signal import SIGINT, default_int_handler, getsignal, signal  # type: ignore[import-not-found]
from typing import Any

from galvi.trajectory import Trajectory


class Interrupted(KeyboardInterrupt):
    """Ctrl-C after the last step of a run, or of several runs, or after a step that failed.

    Attributes
    ----------
    run
        the trajectory, or the tuple of trajectories
    """

    def __init__(self, run: Trajectory | tuple[Trajectory, ...]) -> None:
        super().__init__("what was computed is the attribute run of this exception")
        self.run = run


class Interrupts:
    """Records the first Ctrl-C; a second one raises KeyboardInterrupt."""

    def __init__(self) -> None:
        self._pressed = self._polled = False

    def __call__(self) -> bool:
        """Whether Ctrl-C was pressed; the caller must act on it."""
        self._polled = self._pressed
        return self._polled

    @property
    def unhandled(self) -> bool:
        """Whether Ctrl-C was recorded and not polled since."""
        return self._pressed and not self._polled

    def note(self, signum: int, frame: Any) -> None:
        """Handle SIGINT; KeyboardInterrupt the second time."""
        if self._pressed:
            self._pressed = self._polled = True
            raise KeyboardInterrupt
        self._pressed = True


class Deferral:
    """The context of `defer_interrupts`; a generator would take 2 us more."""

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
    """A context in which the first Ctrl-C is recorded; a second one raises at once, and one that
    was not polled raises on exit.

    Replaces only Python's default handler, and only in the main thread, where signals arrive: a
    handler of the calling program stays in place, and so does an ignored SIGINT, as under nohup.
    """
    return Deferral()


def uninterrupted(run: Trajectory) -> Trajectory:
    """The run itself; KeyboardInterrupt if it was interrupted."""
    if run.interrupted:
        raise KeyboardInterrupt
    return run

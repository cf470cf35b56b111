"""Messages to the user about compilation, and Ctrl-C during it."""

from __future__ import annotations

import logging
import signal
import threading
from functools import cache
from typing import Any

from galvi.kernels.compile.cache import KernelCache
from galvi.kernels.compile.internals import event

GENERATED = "galvi:generated"  # numba event; ``seconds`` is the time to compile generated code

# Processor time in seconds to compile each entry point of a kernel and all it calls, measured with
# an empty NUMBA_CACHE_DIR. For common systems: column `cold` of benchmarks/studies/start_up.py.
SECONDS = {
    "galvi.kernels.nystrom.advance.advance": 7,
    "galvi.lanes.nbody.advance": 7,
    "galvi.lanes.frames.collocation.advance_frame": 7,
    "galvi.lanes.loops.advance_run": 3,
    "galvi.kernels.on_group.advance.advance_group": 21,
    "galvi.kernels.on_group.solve.guess_curve": 12,  # the rest of it is interpreted
}
LEAST_REPORTED_SECONDS = 3.0  # shortest compilation of a law that is reported
ONCE = "once; later runs load it"
IN_EACH_PROCESS = (
    "in each process, since no folder for it can be written; set NUMBA_CACHE_DIR to one that can"
)
LOG = logging.getLogger("galvi")


class CompilationNotice(event.Listener):
    """Logs a sentence for each kernel in SECONDS that is compiled, as a warning of logger
    ``galvi``.

    Without logging configuration it is printed to stderr;
    ``logging.getLogger("galvi").setLevel("ERROR")`` silences it.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._announced: set[str] = set()
        self._when = ONCE

    def on_start(self, event: Any) -> None:
        """Called before a function is compiled, and, with ``seconds``, before a generated law is
        optimised, which takes most of the time. Functions that it calls are compiled in between."""
        if "seconds" in event.data:
            if event.data["seconds"] >= LEAST_REPORTED_SECONDS:
                self._say("the law of this system", event.data["seconds"])
            return
        dispatcher = event.data["dispatcher"]
        function = dispatcher.py_func
        name = f"{function.__module__}.{function.__qualname__}"
        if self._depth == 0:
            cached = isinstance(getattr(dispatcher, "_cache", None), KernelCache)
            self._when = ONCE if cached else IN_EACH_PROCESS
            if name in SECONDS and name not in self._announced:
                self._announced.add(name)
                self._say("a kernel for this kind of system", SECONDS[name])
        self._depth += 1

    def _say(self, subject: str, seconds: float) -> None:
        LOG.warning(
            "galvi is compiling %s: about %d s of processor time, %s.", subject, seconds, self._when
        )

    def on_end(self, event: Any) -> None:
        """Called after a function was compiled, or failed to compile."""
        self._depth -= 1


class DeferredInterrupts(event.Listener):
    """Defers a Ctrl-C that arrives while numba compiles or loads a function until that is done.

    LLVM calls back into Python, where an exception would be printed and dropped. The handler of the
    calling program, or Python's own, is called afterwards, or at once at a second Ctrl-C. This
    applies to the main thread, where signals arrive, and to a SIGINT with a handler in Python.
    """

    def __init__(self) -> None:
        self._depth = 0
        self._handler: Any = None
        self._pressed: list[tuple[int, Any]] = []

    def on_start(self, event: Any) -> None:
        """Called before the compiler's lock is acquired; it may be held several times."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth += 1
        handler = signal.getsignal(signal.SIGINT)
        if self._depth == 1 and callable(handler):
            self._handler, self._pressed = handler, []
            signal.signal(signal.SIGINT, self._note)

    def on_end(self, event: Any) -> None:
        """Called after the compiler's lock was released."""
        if threading.current_thread() is not threading.main_thread():
            return
        self._depth = max(0, self._depth - 1)
        handler = self._handler
        if self._depth or handler is None:
            return
        self._handler = None
        if signal.getsignal(signal.SIGINT) == self._note:
            signal.signal(signal.SIGINT, handler)
        if self._pressed:
            handler(*self._pressed.pop())

    def _note(self, signum: int, frame: Any) -> None:
        if not self._pressed:
            self._pressed.append((signum, frame))
            return
        handler, self._handler, self._pressed, self._depth = self._handler, None, [], 0
        signal.signal(signal.SIGINT, handler)
        handler(signum, frame)


@cache
def watch_compilation() -> None:
    """Report later compilations and defer Ctrl-C in them; called before the first compilation."""
    event.register("numba:compiler_lock", DeferredInterrupts())
    notice = CompilationNotice()
    for kind in ("numba:compile", GENERATED):
        event.register(kind, notice)

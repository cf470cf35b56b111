"""How a command ends: its exit status, and one sentence on stderr where it was not carried out."""

from __future__ import annotations

import errno
import io
import os
import select
import sys
import traceback
from collections.abc import Callable
from contextlib import suppress
from typing import TextIO

import typer

from benchmarks.store.foreign_texts import visible
from galvi.command import CANNOT, missing_package
from galvi.environment import NOT_INSTALLED

INTERRUPTED, NO_READER = 130, 141  # 141: what a shell reports of a closed pipe
TRACEBACK = "GALVI_TRACEBACK"  # environment variable: where the exception was raised is shown
LONGEST = 500  # characters of an exception's words that are shown
FULL = (errno.ENOSPC, errno.EDQUOT)


def ended(command: Callable[[], int]) -> int:
    """The exit status of a command, which is CANNOT for whatever it raises, and NOT_INSTALLED for a
    package that is missing.

    Characters that standard output cannot encode are replaced by "?".
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    try:
        status = command()
        if sys.stdout is not None:
            sys.stdout.flush()
    except (KeyboardInterrupt, typer.Abort):
        _say("Interrupted; the files that were written are whole.")
        return INTERRUPTED
    except BaseException as error:
        if _lost_its_reader(error):
            _discard_output()
            return NO_READER
        if os.environ.get(TRACEBACK):
            with suppress(OSError):
                traceback.print_exception(error)
        _say(explained(error))
        _discard_output()
        return NOT_INSTALLED if isinstance(error, ModuleNotFoundError) else CANNOT
    return status


def explained(error: BaseException) -> str:
    """One sentence on an exception that nobody caught, and one on what to do."""
    if isinstance(error, ModuleNotFoundError):
        return missing_package(error)
    words = _words(error)
    words = words if len(words) <= LONGEST else f"{words[:LONGEST]}..."
    named = f"{type(error).__name__}{': ' if words else ''}{words}".rstrip(".")
    return f"The command could not be carried out: {named}. {_remedy(error)}"


def _words(error: BaseException) -> str:
    """Its message on one line, control characters as escapes; "" where it has none."""
    try:
        return visible(" ".join(str(error).split()))
    except Exception:  # of a user's own class
        return ""


def _remedy(error: BaseException) -> str:
    if isinstance(error, OSError) and error.errno in FULL:
        return "Free some space, or write elsewhere."
    if isinstance(error, MemoryError):
        return "It needs a machine with more memory, or a smaller problem."
    return f"{TRACEBACK}=1 in the environment shows where it was raised."


def _say(sentence: str) -> None:
    with suppress(OSError):
        print(sentence, file=sys.stderr)


def _lost_its_reader(error: BaseException) -> bool:
    """Whether this was raised as nobody reads standard output, or stderr, any more."""
    if isinstance(error, SystemExit):  # of rich
        return isinstance(error.__context__, BrokenPipeError)
    return isinstance(error, BrokenPipeError) and not all(
        _written(stream) and _has_reader(stream) for stream in (sys.stdout, sys.stderr)
    )


def _has_reader(stream: TextIO | None) -> bool:
    """False for a pipe that nobody reads; what was not buffered is not written again."""
    with suppress(OSError, ValueError, AttributeError):  # no file, or a system without `poll`
        poll = select.poll()
        poll.register(stream.fileno(), 0)  # type: ignore[union-attr]
        return not any(flags & (select.POLLERR | select.POLLHUP) for _, flags in poll.poll(0))
    return True


def _written(stream: TextIO | None) -> bool:
    try:
        if stream is not None:
            stream.flush()
    except OSError:
        return False
    return True


def _discard_output() -> None:
    """What cannot be written of standard output goes nowhere, else Python says so at its exit."""
    if _written(sys.stdout) and _written(sys.stderr):
        return
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (sys.stdout, sys.stderr):
        if not _written(stream):
            with suppress(OSError, ValueError):
                os.dup2(nowhere, stream.fileno())
    os.close(nowhere)

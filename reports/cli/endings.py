"""How a command ends: its exit status, and one sentence on stderr where it was not carried out."""

from __future__ import annotations

import io
import os
import select
import signal
import sys
import textwrap
import traceback
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

import typer

from benchmarks.store.foreign_texts import visible
from galvi.command import CANNOT, missing_package
from galvi.environment import NOT_INSTALLED
from reports.cli.project import TABLE

# Public under this name alone; typer has carried its own copy of click since 0.2x.
UsageError: Any = typer.BadParameter.__bases__[0]
INTERRUPTED, NO_READER = 130, 141  # 141: what a shell reports of a closed pipe
# Environment variable; where it is set, tracebacks are printed:
TRACEBACK_VARIABLE = "GALVI_TRACEBACK"
MAX_MESSAGE_LENGTH = 500  # characters of an exception's message that are shown


def ended(command: Callable[[], int]) -> int:
    """Run a command; returns its exit status. An exception becomes a sentence on stderr.

    Characters that standard output cannot encode are replaced by "?".
    """
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    try:
        with _interrupts_raised():
            status = command()
            print(end="", flush=True)
        return status
    except BaseException as error:
        status, message = _ending(error)
    with suppress(OSError, AttributeError):  # nobody reads it, or there is none
        sys.stderr.write(message and f"{message}\n")
    _discard_output()
    return status


@contextmanager
def _interrupts_raised() -> Iterator[None]:
    """Make Ctrl-C raise KeyboardInterrupt during runs of galvi, too, so that it ends the command.

    Under Python's default handler, galvi ends the run alone, and its first steps would be taken for
    a measurement; galvi does not replace any other handler. An ignored SIGINT stays ignored.
    """
    previous_handler = signal.getsignal(signal.SIGINT)
    if previous_handler is not signal.default_int_handler:
        yield
        return
    signal.signal(signal.SIGINT, lambda *arguments: signal.default_int_handler(*arguments))
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, previous_handler)


def _ending(error: BaseException) -> tuple[int, str]:
    """The exit status and the sentence for an exception of a command."""
    if isinstance(error, UsageError):
        return CANNOT, usage_message(error)
    if isinstance(error, KeyboardInterrupt | typer.Abort):
        return INTERRUPTED, "Interrupted; the files that were written are whole."
    if _is_lost_reader(error):
        return NO_READER, ""
    if os.environ.get(TRACEBACK_VARIABLE):
        traceback.print_exception(error)
    if isinstance(error, ModuleNotFoundError):
        return NOT_INSTALLED, missing_package(error)
    description = visible("".join(traceback.format_exception_only(error)))
    description = textwrap.shorten(description, MAX_MESSAGE_LENGTH, placeholder="...").rstrip(".")
    return CANNOT, (
        f"The command could not be carried out: {description}. {TRACEBACK_VARIABLE}=1 in the "
        "environment "
        "shows where it was raised."
    )


def usage_message(error: Any) -> str:
    """The sentence of a usage error; it begins with TABLE if the value comes from that table."""
    parameter = getattr(error, "param", None)
    is_from_galvi = isinstance(error, typer.BadParameter) and parameter is None
    message = str(error.message if is_from_galvi else error.format_message()).rstrip().rstrip(".")
    message = message.replace("Value error, ", "")  # of pydantic's
    if "\n  " not in message:  # else it has one line an item
        message = " ".join(message.split())
    source = error.ctx and parameter and error.ctx.get_parameter_source(parameter.name)
    if source and source.name == "DEFAULT_MAP":
        message = f"{TABLE}: {message[0].lower()}{message[1:]}"
    if message.split()[0].isalpha():  # an option or a path stays as it is
        message = message[0].upper() + message[1:]
    return message + ("" if message.endswith("?") else ".")


@contextmanager
def as_usage_error(*errors: type[Exception], prefix: str = "") -> Iterator[None]:
    """Raise these exceptions as typer.BadParameter, with `prefix` in front of their messages."""
    try:
        yield
    except errors as error:
        raise typer.BadParameter(visible(f"{prefix}{error}")) from None


def _is_lost_reader(error: BaseException) -> bool:
    """Whether the exception was raised because the reader of stdout or stderr is gone."""
    if isinstance(error, SystemExit):  # of rich
        return isinstance(error.__context__, BrokenPipeError)
    streams = (sys.stdout, sys.stderr)
    return isinstance(error, BrokenPipeError) and any(map(_is_unread, filter(None, streams)))


def _is_unread(stream: TextIO) -> bool:
    """Whether the stream is a pipe whose other end is closed."""
    with suppress(OSError, ValueError, AttributeError):  # no file, or a system without `poll`
        poll = select.poll()
        poll.register(stream.fileno(), 0)
        return bool(poll.poll(0))
    return False


def _discard_output() -> None:
    """Redirect a stream that cannot be flushed to the null device, or Python would report the
    unwritten text at its exit."""
    for stream in filter(None, (sys.stdout, sys.stderr)):
        try:
            stream.flush()
        except OSError:
            os.dup2(os.open(os.devnull, os.O_WRONLY), stream.fileno())

"""The life of a contender's process: it ends with ours, and so does everything that it started.

Each is the head of a process group of its own. A guard in that group, a shell, waits for the end of
our process, which closes the pipe that it reads from, and then ends the group: a contender that
holds Python's interpreter, or never returns, cannot keep it from that.
"""

from __future__ import annotations

import multiprocessing
import os
import signal
import subprocess
import threading
from contextlib import suppress
from multiprocessing.connection import wait
from typing import Any

GUARD = ("/bin/sh", "-c", "read gone; kill -9 0")
GRACE = 2.0  # seconds in which a process that is asked to leave may clear up


def tie_to_parent() -> Any:
    """Of a process that multiprocessing started: end it when its parent is gone, killed or not.

    Returns what must be kept until then. Where the system has no process groups, a thread watches,
    which ends this process alone, and not while compiled code holds the interpreter.
    """
    parent = multiprocessing.parent_process()
    if parent is None:
        raise RuntimeError("only a process that multiprocessing started has a parent to end with")
    if hasattr(os, "setsid"):
        os.setsid()
        silent = subprocess.DEVNULL
        return subprocess.Popen(GUARD, stdin=parent.sentinel, stdout=silent, stderr=silent)
    watch = threading.Thread(target=_end_after, args=(parent.sentinel,), daemon=True)
    watch.start()
    return watch


def end(process: Any, connection: Any, gently: bool) -> None:
    """End a process that is tied to this one, and what it started.

    gently  its connection is closed, and it has GRACE seconds to leave by itself
    """
    connection.close()
    if gently:
        process.join(GRACE)
    if hasattr(os, "killpg"):
        with suppress(ProcessLookupError, PermissionError):  # before it had a group; all gone
            os.killpg(process.pid, signal.SIGKILL)
    process.kill()
    process.join()


def _end_after(sentinel: Any) -> None:
    wait([sentinel])
    os._exit(1)

"""Commands of the suite in a process of their own, to which a pickled value may be passed."""

from __future__ import annotations

import hashlib
import os
import subprocess
import sys
import time
from collections.abc import Sequence

from galvi.environment import NOT_INSTALLED

HANDED_OVER = "GALVI_HANDED_OVER"  # environment variable: SHA-256 of the pickle to be loaded
SILENT_SECONDS = 10.0  # lines of progress are shown after this time


def run_command(
    command: str, arguments: Sequence[str], pickled: bytes = b""
) -> ModuleNotFoundError | ValueError:
    """Run ``galvi COMMAND`` with the import path of this process.

    Parameters
    ----------
    pickled
        the pickle that the command may load, from a file among the arguments; empty for none

    Returns
    -------
    ModuleNotFoundError or ValueError
        the exception to raise where the command wrote no result: as `refusal`, with the text on
        stderr except progress
    """
    digest = hashlib.sha256(pickled).hexdigest() if pickled else ""
    import_path = os.pathsep.join(folder for folder in sys.path if folder)
    process = subprocess.Popen(
        [sys.executable, "-m", "galvi", command, *arguments],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
        env={**os.environ, HANDED_OVER: digest, "PYTHONPATH": import_path},
    )
    start, messages, progress = time.monotonic(), list[str](), f"{command}: "
    with process:
        assert process.stderr is not None
        for line in process.stderr:
            if not line.startswith(progress):
                messages.append(line.rstrip())
            elif time.monotonic() - start > SILENT_SECONDS:
                print(line, end="", file=sys.stderr, flush=True)
    return refusal("\n".join(messages), process.returncode)


def refusal(message: str, exit_code: int) -> ModuleNotFoundError | ValueError:
    """A ModuleNotFoundError where the exit code says that a package is not installed, else a
    ValueError; with the message, or the exit code where it is empty."""
    sentence = message or f"the command ended with {exit_code}."
    return ModuleNotFoundError(sentence) if exit_code == NOT_INSTALLED else ValueError(sentence)

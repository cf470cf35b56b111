"""The argument and the progress of a command that Python starts, as `galvi.judge` does."""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from pathlib import Path
from typing import Any

from galvi.interop.suite_process import HANDED_OVER


def handed_over(file: Path, call: str) -> Any:
    """The value that this process was started with.

    Parameters
    ----------
    call
        what writes such a file, as in "galvi.judge(problem)"

    Raises
    ------
    ValueError
        For any other file, since loading a pickle runs whatever it says.
    """
    pickled = file.read_bytes()
    if os.environ.get(HANDED_OVER) != hashlib.sha256(pickled).hexdigest():
        raise ValueError(
            f"a pickled file is loaded for {call} alone, which writes it; received {file}. Call "
            f"{call} in Python."
        )
    try:
        return pickle.loads(pickled)
    except (AttributeError, ImportError) as error:
        raise ValueError(
            f"what {call} is given goes to another process, which does not find its functions: "
            f"{error}. Define them in a module, not in the script that is run."
        ) from None


def show_progress(command: str, sentence: str) -> None:
    """Show a sentence: on a terminal in place of the last one, elsewhere on a line of its own."""
    if sys.stderr.isatty():
        print(f"\r\033[K{sentence}", end="", file=sys.stderr, flush=True)
    elif sentence:
        print(f"{command}: {sentence}", file=sys.stderr, flush=True)

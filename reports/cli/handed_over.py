"""Commands that a Python function such as `galvi.judge` starts: their argument and progress."""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from pathlib import Path
from typing import Any

from galvi.interop.suite_process import HANDED_OVER


def handed_over(file: Path, call: str) -> Any:
    """The pickled argument that the calling process wrote to `file`.

    Parameters
    ----------
    call
        the call that writes such a file, such as "galvi.judge(problem)"

    Raises
    ------
    ValueError
        If the hash of the file is not the one that the caller handed over, since loading a pickle
        can run any code; and if a function in it cannot be imported.
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
    """Print a sentence on stderr; on a terminal it replaces the previous one."""
    if sys.stderr.isatty():
        print(f"\r\033[K{sentence}", end="", file=sys.stderr, flush=True)
    elif sentence:
        print(f"{command}: {sentence}", file=sys.stderr, flush=True)

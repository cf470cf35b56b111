"""Studies for the workers of a build, in a module that is imported at once."""

from __future__ import annotations

import os
import time

import pandas as pd

from benchmarks.store.frames import frame


def quiet(seconds: float, quick: bool) -> pd.DataFrame:
    """The number of its process, after a while."""
    time.sleep(seconds)
    print("a line that nobody reads")
    return pd.DataFrame({"process": [os.getpid()], "quick": [quick]})


def broken(quick: bool) -> pd.DataFrame:
    raise RuntimeError("no engine here")


def dying(quick: bool) -> pd.DataFrame:
    os._exit(3)


def nothing(quick: bool) -> pd.DataFrame:
    """The frame of a claim's study that measured nothing."""
    return frame([])

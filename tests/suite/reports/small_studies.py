"""Studies for the workers of a build, in a module that is quick to import."""

from __future__ import annotations

import os
import time

import pandas as pd


def quiet(seconds, quick, report):
    """A table with the id of its process, after `seconds`."""
    time.sleep(seconds)
    print("a line that nobody reads")
    return pd.DataFrame({"process": [os.getpid()], "quick": [quick]})


def meet(own_file, other_file, quick, report):
    """As `quiet`, once the study with the other file has begun too."""
    own_file.touch()
    for _ in range(1200):
        if other_file.exists():
            return quiet(0.0, quick, report)
        time.sleep(0.1)
    raise TimeoutError("no other worker")


def broken(quick, report):
    raise RuntimeError("no engine here")


def dying(quick, report):
    os._exit(3)

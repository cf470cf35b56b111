"""The quick studies of the claims, each measured once in a run of pytest, by one worker."""

from __future__ import annotations

from pathlib import Path

import pandas as pd
from filelock import FileLock

import galvi
from benchmarks.checks.claim import Claim

folder = Path()  # common to all workers; set by conftest.py


def quick(claim: Claim) -> pd.DataFrame:
    """A new table of a claim's quick study with galvi's own methods."""
    path = folder / f"{claim.id}.pickle"
    with FileLock(path.with_suffix(".lock")):
        if not path.exists():
            claim.study(galvi.Galerkin, True, lambda sentence: None).to_pickle(path)
    return pd.read_pickle(path)

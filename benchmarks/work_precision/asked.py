"""The errors at which codes are compared, and which code a contender belongs to."""

from __future__ import annotations

import pandas as pd

from benchmarks.work_precision.dependable import resolution

ERRORS = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)  # the last is near the limit of doubles


def errors_of(runs: pd.DataFrame) -> tuple[float, ...]:
    """The errors at which one problem's codes are compared, none below its `resolution`."""
    limit = resolution(runs)
    return tuple(error for error in ERRORS if error >= limit)


def code_of(contender: str) -> str:
    """The code of a label, without its named options; "galvi" for all methods of galvi."""
    return "galvi" if contender.startswith("galvi") else contender.partition(",")[0]

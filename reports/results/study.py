"""A study with a section of its own on the page: what runs it, draws it and tables it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.checks.claim import Report
from reports.figures.figure import Figure

Measure = Callable[[bool, Report], pd.DataFrame]


@dataclass(frozen=True)
class Study:
    """One of them.

    name     of its files, e.g. "brouwer"
    title    its heading on the page
    text     what the reader should know, in a few sentences
    measure  (quick, report) -> frame
    figures  each draws the frame
    table    frame -> the table as text, and the class of its columns
    parts    (folder, report) -> the runs of its long form, each with title, done() and run(report);
             None when it has none
    stored   (folder, report) -> the rows of the long form that are there
    open     whether outsiders take part: its measure takes them as `outsiders`
    """

    name: str
    title: str
    text: str
    measure: Measure
    figures: tuple[Figure, ...]
    table: Callable[[pd.DataFrame], tuple[pd.DataFrame, Mapping[str, str]]]
    parts: Callable[[Path, Report], Sequence[Any]] | None = None
    stored: Callable[[Path, Report], pd.DataFrame] | None = None
    open: bool = False

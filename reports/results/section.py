"""A study with its own section on the page: measurement, table and figures."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.checks.claim import Report


@dataclass(frozen=True)
class Figure:
    """The description of a picture.

    Attributes
    ----------
    name
        base name of its files, e.g. "fig-2-03"
    title
        one line
    draw
        function that is called with (axes, table, **options)
    source
        the paper's figure, e.g. "H fig. 2.3"
    claims
        ids of claims; the table of the first one that was measured is drawn
    options
        further arguments of `draw`: quantities, labels, claimed rates
    caption
        explanation for the reader
    size
        width and height in inches, if the width is not limited
    min_width
        width in inches below which it would be unreadable, and is not drawn
    """

    name: str
    title: str
    draw: Callable[..., None]
    source: str = ""
    claims: tuple[str, ...] = ()
    options: Mapping[str, Any] = field(default_factory=dict)
    caption: str = ""
    size: tuple[float, float] = (6.4, 4.0)
    min_width: float = 0.0


Measure = Callable[..., pd.DataFrame]  # (quick, report) -> table
Table = tuple[pd.DataFrame, Mapping[str, str]]  # a table of texts, and column -> CSS class


@dataclass(frozen=True)
class LongForm:
    """The long form of a study: hours of runs, which are made and stored one by one.

    Attributes
    ----------
    runs
        (folder, report) -> runs, each with title, is_complete() and run(report)
    stored
        (folder, report) -> the rows of the finished runs
    """

    runs: Callable[[Path, Report], Sequence[Any]]
    stored: Callable[[Path, Report], pd.DataFrame]


@dataclass(frozen=True)
class Section:
    """A study with its own section.

    Attributes
    ----------
    name
        base name of its files, e.g. "brouwer"
    title
        its heading on the page
    text
        an introduction of a few sentences
    measure
        (quick, report) -> table
    table
        table -> the table as text, and the CSS classes of its columns
    summary
        table -> sentences on what its rows show, or ""
    figures
        figures of the table
    long_form
        the study's long form; None if it has none
    open
        whether external integrators take part
    compared
        whether `compare` measures it, too
    timed
        whether it measures times; a build measures all other studies in worker processes
    absent
        () -> which engine is missing, so that the study cannot run here; "" if it can
    """

    name: str
    title: str
    text: str
    measure: Measure
    table: Callable[[pd.DataFrame], Table]
    summary: Callable[[pd.DataFrame], str] = lambda table: ""
    figures: tuple[Figure, ...] = ()
    long_form: LongForm | None = None
    open: bool = False
    compared: bool = False
    timed: bool = False
    absent: Callable[[], str] = lambda: ""

    @property
    def anchor(self) -> str:
        """The id of its heading on the page."""
        return self.name.replace("_", "-")

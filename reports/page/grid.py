"""A table for the page: headings and cells of text, each with its CSS class."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass

import pandas as pd


@dataclass(frozen=True)
class Grid:
    """headings (text, class) and lines of cells (text, class)."""

    headings: tuple[tuple[str, str], ...]
    lines: tuple[tuple[tuple[str, str], ...], ...]


def grid(
    frame: pd.DataFrame,
    kinds: Mapping[str, str] | None = None,
    best: Iterable[tuple[int, str]] = (),
    absent: Iterable[str] = ("not reached", "not run"),
) -> Grid:
    """The grid of a frame of text.

    kinds   column -> CSS class
    best    cells (line, column) to highlight
    absent  texts that stand for a missing number
    """
    kinds, best, absent = dict(kinds or {}), set(best), set(absent)

    def cell(line: int, column: str, text: str) -> tuple[str, str]:
        classes = [kinds.get(column, "")]
        classes += ["absent"] if text in absent else []
        classes += ["best"] if (line, column) in best else []
        return text, " ".join(filter(None, classes))

    return Grid(
        headings=tuple((str(column), kinds.get(column, "")) for column in frame.columns),
        lines=tuple(
            tuple(cell(k, *pair) for pair in zip(frame.columns, map(str, line), strict=True))
            for k, line in enumerate(frame.itertuples(index=False, name=None))
        ),
    )

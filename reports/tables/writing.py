"""Write a table as CSV in full precision, and as readable Markdown and LaTeX."""

from __future__ import annotations

from numbers import Real
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from reports.tables.number_format import plain

PAGE = 45  # table rows that fit on a LaTeX page


def as_csv(frame: pd.DataFrame) -> str:
    """CSV text with numbers in full precision: they are read back unchanged."""
    return frame.to_csv(index=False, lineterminator="\n")


def as_markdown(frame: pd.DataFrame) -> str:
    """A GitHub Markdown table with few digits."""
    escaped = _text(frame).map(lambda cell: cell.replace("|", "\\|"))
    return f"{escaped.to_markdown(index=False, disable_numparse=True)}\n"


def as_latex(frame: pd.DataFrame) -> str:
    """A booktabs table with few digits, numbers right-aligned; a longtable beyond one page."""
    kinds = "".join("r" if any(map(_is_number, frame[name])) else "l" for name in frame)
    return _text(frame).to_latex(
        index=False, escape=True, column_format=kinds, longtable=len(frame) > PAGE
    )


def write_table(
    folder: Path, name: str, frame: pd.DataFrame, read: pd.DataFrame | None = None
) -> None:
    """Write name.csv from `frame`; name.md and name.tex from `read`, by default `frame`."""
    shown = frame if read is None else read
    write(folder / f"{name}.csv", as_csv(frame))
    write(folder / f"{name}.md", as_markdown(shown))
    write(folder / f"{name}.tex", as_latex(shown))


def _is_number(value: object) -> bool:
    return isinstance(value, Real) and not isinstance(value, bool) and not pd.isna(value)


def _text(frame: pd.DataFrame) -> pd.DataFrame:
    """Every cell as text; missing values are empty."""
    return frame.map(_cell).astype(object)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return plain(value)
    return "" if value is None or value is pd.NA else str(value)

"""A table in three forms: CSV to compute with, Markdown and LaTeX to read."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from reports.tables.number_format import plain


def as_csv(frame: pd.DataFrame) -> str:
    """Numbers in full, so that reading them back gives the same ones."""
    return frame.to_csv(index=False, lineterminator="\n")


def as_markdown(frame: pd.DataFrame) -> str:
    """Few digits; GitHub's tables."""
    escaped = _text(frame).map(lambda cell: cell.replace("|", "\\|"))
    return f"{escaped.to_markdown(index=False, disable_numparse=True)}\n"


def as_latex(frame: pd.DataFrame) -> str:
    """Few digits; a tabular with booktabs' rules."""
    return _text(frame).to_latex(index=False, escape=True)


def write_table(
    folder: Path, name: str, frame: pd.DataFrame, read: pd.DataFrame | None = None
) -> None:
    """Write name.csv from frame, name.md and name.tex from `read` (default: frame, few digits)."""
    shown = frame if read is None else read
    write(folder / f"{name}.csv", as_csv(frame))
    write(folder / f"{name}.md", as_markdown(shown))
    write(folder / f"{name}.tex", as_latex(shown))


def _text(frame: pd.DataFrame) -> pd.DataFrame:
    """Every cell as text; what is not known is empty."""
    return frame.map(_cell).astype(object)


def _cell(value: object) -> str:
    if isinstance(value, bool):
        return str(value)
    if isinstance(value, int):
        return str(value)
    if isinstance(value, float):
        return plain(value)
    return "" if value is None or value is pd.NA else str(value)

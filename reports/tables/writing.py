"""Write a table as CSV in full precision, and as readable Markdown and LaTeX.

Texts that a spreadsheet would run, and control characters, are made harmless in CSV and Markdown by
`benchmarks.store.foreign_texts`, and in LaTeX by `escape`.
"""

from __future__ import annotations

from collections.abc import Mapping
from numbers import Real
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from benchmarks.store.foreign_texts import guarded
from reports.tables.latex import as_latex, caption_of
from reports.tables.number_format import plain


def as_markdown(table: pd.DataFrame) -> str:
    """A GitHub Markdown table with few digits; characters that would end a cell or start a tag are
    escaped, and missing values are empty."""
    return f"{table.astype(object).map(_cell).to_markdown(index=False, disable_numparse=True)}\n"


def write_table(
    folder: Path,
    name: str,
    table: pd.DataFrame,
    readable: pd.DataFrame | None = None,
    origin: Mapping[str, str] | None = None,
    caption: str = "",
) -> list[Path]:
    """Write name.csv from `table`, and name.md and name.tex from `readable`; returns the paths.

    Parameters
    ----------
    read
        the table for readers; None for `table`
    origin
        origin of the rows, for the caption of name.tex
    caption
        caption of name.tex, used if there is no origin
    """
    shown = table if readable is None else readable
    caption = caption_of(name, origin) if origin else caption
    return [
        write(folder / f"{name}.csv", as_csv(table)),
        write(folder / f"{name}.md", as_markdown(shown)),
        write(folder / f"{name}.tex", as_latex(shown, caption, f"tab:{name}")),
    ]


def _cell(value: object) -> str:
    if isinstance(value, Real) and not isinstance(value, int):
        return plain(value)
    text = "" if pd.isna(value) else guarded(" ".join(str(value).split()))
    return text.replace("\\", "\\\\").replace("|", "\\|").replace("<", "&lt;")

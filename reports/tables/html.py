"""Tables for web pages: a caption, headings with their scope, and classes of cells."""

from __future__ import annotations

from collections.abc import Collection, Iterable
from pathlib import Path

import pandas as pd
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from markupsafe import Markup

TEMPLATES = Environment(
    loader=FileSystemLoader(Path(__file__).parent),
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def html_table(
    table: pd.DataFrame,
    caption: str,
    numbers: Collection[str] = (),
    best: Iterable[tuple[int, str]] = (),
    id: str = "",
) -> Markup:
    """A table in a region that scrolls; the cells of the first column are headings of the rows.

    Parameters
    ----------
    numbers
        columns whose cells and heading have the class `number`
    best
        (line, column) of cells with the class `best`
    id
        id of the table

    Notes
    -----
    Cells that say that a number is missing have the class `absent`. Texts are escaped unless they
    are Markup, which pandas preserves only in columns of dtype object. Missing values are empty
    cells.
    """
    return Markup(
        TEMPLATES.get_template("table.html.j2").render(
            columns=list(table),
            rows=table.astype(object).where(table.notna(), "").to_numpy().tolist(),
            caption=caption,
            numbers=list(numbers),
            best=list(best),
            id=id,
        )
    )

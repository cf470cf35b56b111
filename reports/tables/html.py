"""Tables for web pages by pandas: a caption, headings with their scope, and classes of cells."""

from __future__ import annotations

import re
from collections.abc import Collection, Iterable

import pandas as pd
from markupsafe import Markup, escape

ABSENT = ("not reached", "not run")  # texts that stand for a missing number
HEADING = re.compile(r'<th id="\S+" class="(row|col)_heading level0 \w+?(\d+)" ')
CORNER = '<th class="index_name level0" '
CELL = re.compile(r'<td (?:id="\S+" )?class="data row\d+ col\d+ *([^"]*)" ')


def html_table(
    frame: pd.DataFrame,
    caption: str,
    numbers: Collection[str] = (),
    best: Iterable[tuple[int, str]] = (),
    id: str = "",
) -> Markup:
    """A table within a region that scrolls; the first column are the headings of the rows.

    Parameters
    ----------
    numbers
        columns whose cells and heading have the class `number`
    best
        (line, column) of cells with the class `best`
    id
        of the table

    Notes
    -----
    Cells that say that a number is missing have the class `absent`. Texts are escaped, but for
    those that are Markup, which pandas keeps in columns of dtype object alone; a missing value is
    an empty cell. The table has two columns or more.
    """
    labels, cells = frame.iloc[:, 0], frame.iloc[:, 1:].reset_index(drop=True)
    classes = cells.map(lambda cell: "absent" if cell in ABSENT else "").astype(object)
    classes[cells.columns.intersection(list(numbers))] += " number"
    for line, name in best:
        classes.loc[line, name] += " best"
    styler = cells.rename_axis(columns=escape(frame.columns[0])).style.set_td_classes(classes)
    styler.format(escape, na_rep="").format_index(escape, axis="columns")
    headings = ["" if pd.isna(label) else escape(label) for label in labels]
    styler.format_index(headings.__getitem__)
    html = styler.to_html(cell_ids=False, caption=str(escape(caption)))

    def heading(match: re.Match[str]) -> str:
        is_number = match[1] == "col" and cells.columns[int(match[2])] in numbers
        return f'<th scope="{match[1]}" class="{"number" * is_number}"'

    _, _, table = html.partition(">\n  <caption>")  # after an empty style sheet
    table = HEADING.sub(heading, table.replace(CORNER, '<th scope="col"'))
    table = CELL.sub(r'<td class="\1"', table).replace(' class=""', "")
    label = f' id="{escape(id)}"' if id else ""
    title = escape(Markup(escape(caption)).striptags())
    return Markup(
        f'<div class="wide" tabindex="0" role="region" aria-label="{title}">'
        f"<table{label}>\n  <caption>{table}</div>"
    )

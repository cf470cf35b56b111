r"""Tables as LaTeX, written by pandas, that fit into the text block of a paper.

Columns with numbers are S columns of siunitx. Columns of texts are `l` columns if all texts are
short, else X columns, which share the remainder of ``\linewidth``. A long table breaks across
pages, and one of many columns stands sideways.
"""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from reports.tables.number_format import capital, is_finite, siunitx

NEEDS = (
    r"% needs \usepackage{booktabs,siunitx,tabularx,xltabular,pdflscape}; "
    "galvi export --columns chooses columns"
)
# Largest number of rows of a floating table; a longer one breaks across pages:
MAX_FLOATING_ROWS = 25
MAX_UPRIGHT_COLUMNS = 7  # largest number of columns of an upright table
# Largest number of columns of a sideways table in scriptsize; more are in tiny:
MAX_SCRIPTSIZE_COLUMNS = 12
MAX_UNBROKEN_TEXT = 12  # characters; columns of texts that are no longer have no line breaks
# Smallest mean length of texts, in characters, that counts for a column's width:
MIN_MEAN_LENGTH = 30
# Characters after which a word may break; half as many beyond MAX_SCRIPTSIZE_COLUMNS:
UNBROKEN_CHARACTERS = 12
MAX_TABLE_ROWS = 250  # largest number of rows of a table, for the sake of TeX's memory
TEXT_COLUMN = r">{\hsize=%.2f\hsize\raggedright\arraybackslash\hspace{0pt}}X"  # hyphens in any word
STYLE = (
    r"\setlength{\tabcolsep}{2pt}\sisetup{table-alignment-mode=none,table-number-alignment=right}"
)
LINE_END = r"\\"
UNCERTAINTY_OF = {
    "measured": "uncertainty",
    "fitted": "fitted_se",
}  # number -> uncertainty in its cell
PACKAGES = ("python", "numpy", "scipy", "numba", "rebound", "mujoco-core", "heyoka")
NOT_INSTALLED = "not installed"
TEX_OF_CHARACTER = str.maketrans({
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "{": r"\{",
    "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "_": r"\_",
    "[": "{[}", "*": "{*}",  # TeX would read these as options of a line's end
    "<": r"\ensuremath{<}", ">": r"\ensuremath{>}", "|": r"\ensuremath{|}",
    "\u2212": r"\ensuremath{-}", "\u00d7": r"\ensuremath{\times}", "\u00b7": r"\ensuremath{\cdot}",
    "\u03c9": r"\ensuremath{\omega}", "\u03c0": r"\ensuremath{\pi}", "\u00b1": r"\ensuremath{\pm}",
    "\u00b5": r"\ensuremath{\mu}", "\u2264": r"\ensuremath{\leq}", "\u2265": r"\ensuremath{\geq}",
    "\u2033": r"\ensuremath{''}", "\u200b": r"\allowbreak{}", "\n": " ", "\t": " ",
    "\u202f": r"\,", "\u2009": r"\,", "\u00a0": "~",
})  # fmt: skip
# Where a text may end its line, without hyphens:
BREAK_POSITION = r"(?<=[/_,;:=])(?=\w)|(?<=\S{%d})(?=\S)"
SUPERSCRIPTS = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@dataclass(frozen=True)
class _Column:
    """A column as TeX.

    Attributes
    ----------
    kind
        its type: "S", "l" or "X"
    weight
        relative width of an X column
    """

    heading: str
    kind: str
    cells: list[str]
    weight: float = 0.0


def as_latex(table: pd.DataFrame, caption: str = "", label: str = "") -> str:
    """The table as LaTeX, with few digits; numbers with an uncertainty have two digits of it.

    A column with a number is an S column of siunitx, in which texts stand in braces. A table of
    more than MAX_TABLE_ROWS rows is split into several.
    """
    uncertainties = {
        name: UNCERTAINTY_OF[name] for name in table if UNCERTAINTY_OF.get(name) in table
    }
    names = table.columns.drop(list(uncertainties.values()))
    unbroken = (
        UNBROKEN_CHARACTERS if len(names) <= MAX_SCRIPTSIZE_COLUMNS else UNBROKEN_CHARACTERS // 2
    )
    columns = [
        _column(str(name), table[name], table.get(uncertainties.get(name)), unbroken)
        for name in names
    ]
    tables = [_table(columns, slice(0, MAX_TABLE_ROWS), caption, label)]
    tables += [
        _table(
            columns,
            slice(first, first + MAX_TABLE_ROWS),
            f"{caption} Continued from row {first + 1}.",
            f"{label}-{first + 1}",
        )
        for first in range(MAX_TABLE_ROWS, len(table), MAX_TABLE_ROWS)
    ]
    return "\n".join([NEEDS, *tables])


def _table(columns: Sequence[_Column], rows: slice, caption: str, label: str) -> str:
    cells = pd.DataFrame({k: column.cells[rows] for k, column in enumerate(columns)}, dtype=object)
    sideways = len(columns) > MAX_UPRIGHT_COLUMNS
    longtable = sideways or len(columns[0].cells) > MAX_FLOATING_ROWS
    texts = [column.weight for column in columns if column.kind == "X"]
    kinds = [
        TEXT_COLUMN % (column.weight * len(texts) / sum(texts))
        if column.kind == "X"
        else column.kind
        for column in columns
    ]
    styler = cells.style.hide(axis="index")
    latex: str = styler.format_index(lambda k: columns[k].heading, axis="columns").to_latex(
        column_format="".join(kinds),
        hrules=True,
        siunitx=True,
        caption=escape(caption) or None,
        label=(label if caption else "") or None,
        environment="longtable" if longtable else "table",
    )
    if texts:
        before, fitted = ("longtable", "xltabular") if longtable else ("tabular", "tabularx")
        latex = latex.replace(f"\\begin{{{before}}}", f"\\begin{{{fitted}}}{{\\linewidth}}")
        latex = latex.replace(f"\\end{{{before}}}", f"\\end{{{fitted}}}")
    if not longtable:  # a float sets its own style
        return latex.replace("\\begin{table}\n", f"\\begin{{table}}\n\\footnotesize{STYLE}\n", 1)
    if sideways:
        size = "scriptsize" if len(columns) <= MAX_SCRIPTSIZE_COLUMNS else "tiny"
        return f"\\begin{{landscape}}\\{size}{STYLE}\n{latex}\\end{{landscape}}\n"
    return f"\\begingroup\\footnotesize{STYLE}\n{latex}\\endgroup\n"


def _column(
    name: str, values: pd.Series, uncertainties: pd.Series | None, unbroken: int
) -> _Column:
    """The column of these values; words may break after `unbroken` characters."""
    errors = [None] * len(values) if uncertainties is None else uncertainties
    numbers = [is_finite(value) and not isinstance(value, bool) for value in values]
    texts = ["" if pd.isna(value) else " ".join(str(value).split()) for value in values]
    heading = [escape(word) for word in re.split("[ _]", name)]
    stacked = rf"\shortstack{{{LINE_END.join(heading)}}}"
    if any(numbers):
        cells = [
            siunitx(value, error) if is_number else f"{{{escape(text)}}}"
            for value, error, is_number, text in zip(values, errors, numbers, texts, strict=True)
        ]
        return _Column(stacked, "S", cells)
    lengths = [*map(len, texts)]
    if max(lengths, default=0) <= MAX_UNBROKEN_TEXT:
        return _Column(stacked, "l", [*map(escape, texts)])
    cells = [escape(re.sub(BREAK_POSITION % unbroken, "\u200b", text)) for text in texts]
    # widths in proportion to the square root of the length minimise the total number of lines
    return _Column(
        " ".join(heading), "X", cells, max(MIN_MEAN_LENGTH, float(np.mean(lengths))) ** 0.5
    )


def caption_of(name: str, origin: Mapping[str, str], where: Sequence[str] = ()) -> str:
    """A caption with the conditions on the rows, and with the date, machine, versions and commit
    that `origin` has."""
    versions = ", ".join(
        f"{package} {origin[package]}"
        for package in PACKAGES
        if origin.get(package, NOT_INSTALLED) != NOT_INSTALLED
    )
    parts = (
        origin.get("date", ""),
        " ".join(filter(None, (origin.get("cpu", ""), origin.get("platform", "")))),
        versions,
        f"commit {origin['commit'][:12]}" if "commit" in origin else "",
        "quick setting" if origin.get("setting") == "quick" else "",
    )
    title = ", ".join([capital(name.replace("_", " ").replace("-", " ")), *where])
    measured = "; ".join(filter(None, parts))
    return f"{title}. {f'Measured {measured}.' if measured else ''}".strip()


def escape(text: str) -> str:
    """The text with TeX's characters escaped; superscript characters become superscripts."""
    printable = "".join(sign for sign in text if sign.isprintable() or sign in "\u200b\n\t")
    return SUPERSCRIPTS.sub(
        lambda raised: f"\\textsuperscript{{{raised[0].translate(LOWERED)}}}",
        printable.translate(TEX_OF_CHARACTER),
    )

r"""Tables for a paper by pandas, which TeX fits into its text block.

Texts are X columns, which share what the numbers leave of ``\linewidth``, or `l` where they are
short; numbers are S columns of siunitx. A long table breaks across pages, and one of many columns
stands sideways.
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
ROWS = 25  # most of a table that floats; a longer one breaks across pages
UPRIGHT, SIDEWAYS = 7, 12  # most columns of a table that stands so; more have a smaller font
SHORT = 12  # letters of the longest text of a column that has no line breaks
NARROW = 30  # letters on average of the narrowest column of paragraphs
WORD = (
    12  # letters of a word that stay together, of the narrow columns of a wide table half of them
)
PART = 250  # rows of a table that TeX's memory holds
TEXT = r">{\hsize=%.2f\hsize\raggedright\arraybackslash\hspace{0pt}}X"  # hyphens in any word
STYLE = (
    r"\setlength{\tabcolsep}{2pt}\sisetup{table-alignment-mode=none,table-number-alignment=right}"
)
LINE_END = r"\\"
PAIRS = {"measured": "uncertainty", "fitted": "fitted_se"}  # number: its uncertainty, shown with it
OF_ORIGIN = ("python", "numpy", "scipy", "numba", "rebound", "mujoco-core", "heyoka")
NOT_INSTALLED = "not installed"
SIGNS = str.maketrans({
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "{": r"\{",
    "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "_": r"\_",
    "[": "{[}", "*": "{*}",  # which are options of a line's end
    "<": r"\ensuremath{<}", ">": r"\ensuremath{>}", "|": r"\ensuremath{|}",
    "\u2212": r"\ensuremath{-}", "\u00d7": r"\ensuremath{\times}", "\u00b7": r"\ensuremath{\cdot}",
    "\u03c9": r"\ensuremath{\omega}", "\u03c0": r"\ensuremath{\pi}", "\u00b1": r"\ensuremath{\pm}",
    "\u00b5": r"\ensuremath{\mu}", "\u2264": r"\ensuremath{\leq}", "\u2265": r"\ensuremath{\geq}",
    "\u2033": r"\ensuremath{''}", "\u200b": r"\allowbreak{}", "\n": " ", "\t": " ",
    "\u202f": r"\,", "\u2009": r"\,", "\u00a0": "~",
})  # fmt: skip
BREAK = r"(?<=[/_,;:=])(?=\w)|(?<=\S{%d})(?=\S)"  # where a text may end its line, without hyphens
RAISED = re.compile("[⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+")
LOWERED = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


@dataclass(frozen=True)
class _Column:
    """A column as TeX: its heading, "S", "l" or "X", its cells, and the weight of its width."""

    heading: str
    kind: str
    cells: list[str]
    weight: float = 0.0


def as_latex(table: pd.DataFrame, caption: str = "", label: str = "") -> str:
    """The table with few digits; numbers with an uncertainty have two digits of it.

    A column with a number is an S column of siunitx, in which texts stand in braces. What is too
    long for the memory of TeX is several tables.
    """
    uncertainties = {name: PAIRS[name] for name in table if PAIRS.get(name) in table}
    names = table.columns.drop(list(uncertainties.values()))
    piece = WORD if len(names) <= SIDEWAYS else WORD // 2
    columns = [
        _column(str(name), table[name], table.get(uncertainties.get(name)), piece) for name in names
    ]
    tables = [_table(columns, slice(0, PART), caption, label)]
    tables += [
        _table(
            columns,
            slice(first, first + PART),
            f"{caption} Continued from row {first + 1}.",
            f"{label}-{first + 1}",
        )
        for first in range(PART, len(table), PART)
    ]
    return "\n".join([NEEDS, *tables])


def _table(columns: Sequence[_Column], rows: slice, caption: str, label: str) -> str:
    cells = pd.DataFrame({k: column.cells[rows] for k, column in enumerate(columns)}, dtype=object)
    sideways = len(columns) > UPRIGHT
    longtable = sideways or len(columns[0].cells) > ROWS
    texts = [column.weight for column in columns if column.kind == "X"]
    kinds = [
        TEXT % (column.weight * len(texts) / sum(texts)) if column.kind == "X" else column.kind
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
        size = "scriptsize" if len(columns) <= SIDEWAYS else "tiny"
        return f"\\begin{{landscape}}\\{size}{STYLE}\n{latex}\\end{{landscape}}\n"
    return f"\\begingroup\\footnotesize{STYLE}\n{latex}\\endgroup\n"


def _column(name: str, values: pd.Series, uncertainties: pd.Series | None, piece: int) -> _Column:
    """piece  letters of a word after which it may go on in the next line"""
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
    if max(lengths, default=0) <= SHORT:
        return _Column(stacked, "l", [*map(escape, texts)])
    cells = [escape(re.sub(BREAK % piece, "\u200b", text)) for text in texts]
    # the square root makes the least of all lines together
    return _Column(" ".join(heading), "X", cells, max(NARROW, float(np.mean(lengths))) ** 0.5)


def caption_of(name: str, origin: Mapping[str, str], where: Sequence[str] = ()) -> str:
    """A caption with the conditions on its rows, and date, machine, versions and commit, as far as
    they are known."""
    versions = ", ".join(
        f"{package} {origin[package]}"
        for package in OF_ORIGIN
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
    """Text in which nothing is a command of TeX; raised signs become exponents."""
    printable = "".join(sign for sign in text if sign.isprintable() or sign in "\u200b\n\t")
    return RAISED.sub(
        lambda raised: f"\\textsuperscript{{{raised[0].translate(LOWERED)}}}",
        printable.translate(SIGNS),
    )

r"""Tables for a paper: booktabs rules, siunitx columns, longtable beyond one page.

A document needs ``\usepackage{booktabs,longtable,siunitx}`` and
``\sisetup{table-align-text-pre=false}`` at most; without them nothing compiles.
"""

from __future__ import annotations

import math
import re
from collections.abc import Mapping, Sequence
from numbers import Real

import pandas as pd

from reports.tables.number_format import known

PAGE = 45  # table rows that fit on a page
WIDE = 34  # letters from which a column of text is a paragraph
PAIRS = {"measured": "uncertainty"}  # number: its uncertainty, shown with it
DIGITS = 3  # significant ones of a number without uncertainty
OF_ORIGIN = ("python", "numpy", "scipy", "numba", "rebound", "mujoco-core", "heyoka")
SPECIAL = {
    "\\": r"\textbackslash{}", "&": r"\&", "%": r"\%", "$": r"\$", "#": r"\#", "_": r"\_",
    "{": r"\{", "}": r"\}", "~": r"\textasciitilde{}", "^": r"\textasciicircum{}",
    "<": r"\ensuremath{<}", ">": r"\ensuremath{>}", "|": r"\ensuremath{|}",
    "\u2212": r"\ensuremath{-}", "\u00d7": r"\ensuremath{\times}", "\u00b7": r"\ensuremath{\cdot}",
    "\u03c9": r"\ensuremath{\omega}", "\u03c0": r"\ensuremath{\pi}", "\u00b1": r"\ensuremath{\pm}",
    "\u00b5": r"\ensuremath{\mu}", "\u2264": r"\ensuremath{\leq}", "\u2265": r"\ensuremath{\geq}",
    "\u202f": r"\,", "\u2009": r"\,", "\u00a0": "~", "\n": " ", "\t": " ",
}  # fmt: skip
RAISED = re.compile("([⁻⁰¹²³⁴⁵⁶⁷⁸⁹]+)")
SUPERSCRIPTS = str.maketrans("⁻⁰¹²³⁴⁵⁶⁷⁸⁹", "-0123456789")


def as_latex(frame: pd.DataFrame, caption: str = "", label: str = "") -> str:
    """The table with few digits; numbers with an uncertainty have two digits of it.

    A column with a number is an S column of siunitx, in which texts stand in braces; one of long
    texts is a paragraph.
    """
    shown = _joined(frame)
    columns = {str(name): [_cell(value) for value in shown[name]] for name in shown}
    numeric = {str(name): any(map(_is_number, shown[name])) for name in shown}
    kinds = [_numbers(cells) if numeric[n] else _texts(cells) for n, cells in columns.items()]
    heads = [f"{{{escape(name)}}}" if numeric[name] else escape(name) for name in columns]
    lines = [
        " & ".join(_set(cell, numeric[name]) for name, cell in zip(columns, line, strict=True))
        for line in zip(*columns.values(), strict=True)
    ]
    body = " \\\\\n".join(lines) + (" \\\\\n" if lines else "")
    head = f"{' & '.join(heads)} \\\\\n"
    title = f"\\caption{{{escape(caption)}}}" if caption else ""
    title += f"\\label{{{label}}}" if label and caption else ""
    if len(frame) > PAGE:
        first = f"{title} \\\\\n" if title else ""
        return (
            f"\\begin{{longtable}}{{{''.join(kinds)}}}\n{first}\\toprule\n{head}\\midrule\n"
            f"\\endfirsthead\n\\toprule\n{head}\\midrule\n\\endhead\n{body}"
            "\\bottomrule\n\\end{longtable}\n"
        )
    table = (
        f"\\begin{{tabular}}{{{''.join(kinds)}}}\n\\toprule\n{head}\\midrule\n{body}"
        "\\bottomrule\n\\end{tabular}\n"
    )
    if not title:
        return table
    return f"\\begin{{table}}\n\\centering\n{title}\n{table}\\end{{table}}\n"


def caption_of(name: str, origin: Mapping[str, str]) -> str:
    """A caption with date, machine, versions and commit, as far as they are known."""
    versions = ", ".join(
        f"{one} {origin[one]}" for one in OF_ORIGIN if origin.get(one, "not") != "not installed"
        and one in origin
    )  # fmt: skip
    parts = (
        origin.get("date", ""),
        " ".join(filter(None, (origin.get("cpu", ""), origin.get("platform", "")))),
        versions,
        f"commit {origin['commit'][:12]}" if "commit" in origin else "",
        "quick setting" if origin.get("setting") == "quick" else "",
    )
    words = name.replace("_", " ").replace("-", " ")
    said = "; ".join(filter(None, parts))
    return f"{words[:1].upper()}{words[1:]}. {f'Measured {said}.' if said else ''}".strip()


def number(value: float, uncertainty: float | None = None) -> str:
    """As siunitx reads it: 0.553(12) with two digits of the uncertainty, 1.23e-10, 12.4."""
    if uncertainty is not None and known(uncertainty) and 0.0 < uncertainty < abs(value) * 1e6:
        power = math.floor(math.log10(abs(value))) if value else 0
        shift = 0 if -3 <= power < 5 else power
        scaled, error = value / 10.0**shift, uncertainty / 10.0**shift
        decimals = 1 - math.floor(math.log10(error))
        if float(f"{error:.1e}") >= 9.95 * 10.0 ** math.floor(math.log10(error)):
            decimals -= 1  # rounds up to one more digit before the point
        if decimals < 0:
            return number(value)
        digits = round(error * 10**decimals)
        text = f"{scaled:.{decimals}f}({digits})"
        return f"{text}e{shift}" if shift else text
    if value == 0.0 or (float(value).is_integer() and abs(value) < 1e5):
        return f"{value:.0f}"
    mantissa, power = f"{value:.{DIGITS - 1}e}".split("e")
    if -3 <= int(power) < 5:
        return f"{float(f'{mantissa}e{power}'):.{max(0, DIGITS - 1 - int(power))}f}"
    return f"{mantissa}e{int(power)}"


def escape(text: str) -> str:
    """Text in which nothing is a command of TeX; raised signs become exponents."""
    return "".join(
        f"\\textsuperscript{{{part.translate(SUPERSCRIPTS)}}}"
        if RAISED.fullmatch(part)
        else "".join(
            SPECIAL.get(letter, letter)
            for letter in part
            if letter in SPECIAL or letter.isprintable()
        )
        for part in RAISED.split(text)
    )


def _joined(frame: pd.DataFrame) -> pd.DataFrame:
    """The frame with each number and its uncertainty in one column, as (number, uncertainty)."""
    frame = frame.astype(object)
    for name, error in PAIRS.items():
        if name in frame and error in frame:
            pairs = list(zip(frame[name], frame[error], strict=True))
            frame = frame.drop(columns=error)
            frame[name] = pd.Series(pairs, index=frame.index, dtype=object)
    return frame


def _number_of(value: object) -> float | None:
    """The number of a cell: itself, or a text that is one; None for anything else."""
    if isinstance(value, bool) or value is None or value is pd.NA:
        return None
    if isinstance(value, Real):
        return float(value) if math.isfinite(value) else None
    try:
        found = float(str(value))
    except ValueError:
        return None
    return found if math.isfinite(found) else None


def _is_number(value: object) -> bool:
    if isinstance(value, tuple):
        return _number_of(value[0]) is not None
    return not isinstance(value, str) and _number_of(value) is not None


def _cell(value: object) -> str:
    if isinstance(value, tuple):
        first = _number_of(value[0])
        return "" if first is None else number(first, _number_of(value[1]))
    if _is_number(value):
        return number(_number_of(value))  # type: ignore[arg-type]
    missing = value is None or value is pd.NA or isinstance(value, float)
    return "" if missing else " ".join(str(value).split())


NUMBER = re.compile(r"(-?)(\d+)(?:\.(\d+))?(?:\((\d+)\))?(?:e(-?)(\d+))?")


def _set(cell: str, numeric: bool) -> str:
    if numeric and NUMBER.fullmatch(cell):
        return cell
    text = escape(cell)
    return f"{{{text}}}" if numeric and text else text


def _numbers(cells: Sequence[str]) -> str:
    """An S column as wide as its numbers."""
    found = [match for cell in cells if (match := NUMBER.fullmatch(cell))]

    def longest(group: int) -> int:
        return max((len(match[group] or "") for match in found), default=0)

    sign = "-" if any(match[1] for match in found) else ""
    places = f".{longest(3)}" if longest(3) else ""
    error = f"({longest(4)})" if longest(4) else ""
    below = "-" if any(match[5] for match in found) else ""
    power = f"e{below}{longest(6)}" if longest(6) else ""
    return f"S[table-format={sign}{longest(2)}{places}{error}{power}]"


def _texts(cells: Sequence[str]) -> str:
    """A column of texts: as wide as they are, or a paragraph."""
    return "p{0.25\\linewidth}" if max(map(len, cells), default=0) > WIDE else "l"

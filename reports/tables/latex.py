r"""Tables for a paper by pandas: booktabs rules, siunitx columns, longtable beyond one page.

A document needs ``\usepackage{booktabs,longtable,siunitx}`` and
``\sisetup{table-align-text-pre=false}`` at most; without them nothing compiles.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from numbers import Real

import pandas as pd

from reports.tables.number_format import known

PAGE = 45  # table rows that fit on a page
LETTERS = 76  # of \footnotesize side by side in a line of `article`
SPACE = 1.5  # letters between two columns
WIDE = {"M": 0.9, "W": 1.1, "m": 0.7, "w": 0.5, "%": 0.7}  # letters that these take more than one
# Where a line may end within a word: not in a number, nor where a hyphen would seem one.
BREAKS = re.compile(r"(?<=[/_,;:])(?=\w)|(?<=[a-z]-)(?=[a-z])|(?<=\S{24})(?=\S)")
PAIRS = {"measured": "uncertainty", "fitted": "fitted_se"}  # number: its uncertainty, shown with it
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
    texts is a paragraph. What is wider than a page of `article` is split into several tables,
    each with the columns that tell its rows apart, or with their numbers.
    """
    shown = _joined(frame)
    columns = [_Column.of(str(name), shown[name]) for name in shown]
    parts = list(_parts(columns))
    tables = []
    for k, part in enumerate(parts, 1):
        of = f"Part {k} of {len(parts)}. " if len(parts) > 1 else ""
        tables.append(_table(part, len(frame), f"{caption} {of}".strip() if caption else "",
                             f"{label}-{k}" if k > 1 else label))  # fmt: skip
    return "\n".join(tables)


@dataclass(frozen=True)
class _Column:
    """A column as TeX.

    number       of siunitx, as wide as its numbers; "" for texts
    least, most  letters: its width with every line broken where it can be, and with none
    """

    head: str
    cells: list[str]
    number: str
    least: float
    most: float

    @staticmethod
    def of(name: str, values: pd.Series) -> _Column:
        texts = [_cell(value) for value in values]
        words = re.split("[ _]", name)
        longest = max(map(_letters, words))
        if any(map(_is_number, values)):
            head = "\\\\".join(map(escape, words))
            wide = max(longest, _reserved(texts), *map(_letters, texts))
            return _Column(f"{{\\shortstack{{{head}}}}}", texts, _numbers(texts), wide, wide)
        pieces = [word for one in texts for part in BREAKS.split(one) for word in part.split()]
        least, most = max([longest, *map(_letters, pieces)]), max(map(_letters, [name, *texts]))
        return _Column(" ".join(map(escape, words)), texts, "", least, most)


def _parts(columns: Sequence[_Column]) -> Iterator[list[_Column]]:
    """Columns side by side that fit on a page; where there are several parts, each after the
    keys."""
    if _width(columns) <= LETTERS:
        yield list(columns)
        return
    keys = _keys(columns)
    part = list(keys)
    for column in columns:
        if column in keys:
            continue
        if len(part) > len(keys) and _width([*part, column]) > LETTERS:
            yield part
            part = list(keys)
        part.append(column)
    yield part


def _width(columns: Iterable[_Column]) -> float:
    return sum(one.least + SPACE for one in columns)


def _keys(columns: Sequence[_Column]) -> list[_Column]:
    """The fewest first columns whose cells tell rows apart, or the number of the row where these
    leave no room for another column."""
    room = LETTERS - max(one.least + SPACE for one in columns)
    for count in range(1, len(columns)):
        first = list(columns[:count])
        if _width(first) > room:
            break
        rows = list(zip(*(one.cells for one in first), strict=True))
        if len(set(rows)) == len(rows):
            return first
    numbers = pd.Series(range(1, len(columns[0].cells) + 1), dtype=object)
    return [_Column.of("row", numbers)]


def _table(part: Sequence[_Column], rows: int, caption: str, label: str) -> str:
    texts = [one for one in part if not one.number]
    room = LETTERS - sum(one.least + SPACE for one in part)
    wish = sum(one.most - one.least for one in texts)
    share = min(1.0, max(room, 0.0) / wish) if wish else 0.0
    widths = [one.least + share * (one.most - one.least) for one in part]
    kinds = "".join(
        one.number or _texts(width, one.most) for one, width in zip(part, widths, strict=True)
    )
    cells = [
        [_set(cell, one, width) for cell in one.cells]
        for one, width in zip(part, widths, strict=True)
    ]
    lines = rows * max(one.most / width for one, width in zip(part, widths, strict=True) if width)
    table = pd.DataFrame(list(zip(*cells, strict=True)), columns=[one.head for one in part])
    latex: str = table.style.hide(axis="index").to_latex(
        column_format=kinds, hrules=True, caption=escape(caption) or None,
        label=(label if caption else "") or None,
        **({"environment": "longtable"} if lines > PAGE else {"position_float": "centering"}),
    )  # fmt: skip
    latex = latex.replace("\\centering\n", "\\centering\\footnotesize\n", 1)  # a float sets its own
    return f"\\begingroup\\footnotesize\\setlength{{\\tabcolsep}}{{3pt}}\n{latex}\\endgroup\n"


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


def _set(cell: str, column: _Column, width: float) -> str:
    """A text may break within a long word in a paragraph; in an S column it stands in braces."""
    if not column.number:
        parts = BREAKS.split(cell) if width < column.most else [cell]
        text = r"\allowbreak{}".join(map(escape, parts))
        return f"{{}}{text}" if text[:1] in ("[", "*") else text  # after a line's end, an option
    text = escape(cell)
    return f"{{{text}}}" if text and not NUMBER.fullmatch(cell) else text


def _numbers(cells: Sequence[str]) -> str:
    """An S column as wide as its numbers."""
    sign, digits, decimals, error, below, power = _widths(cells)
    places = f".{decimals}" if decimals else ""
    places += f"({error})" if error else ""
    exponent = f"e{'-' * below}{power}" if power else ""
    return f"S[table-format={'-' * sign}{digits}{places}{exponent}]"


def _widths(cells: Sequence[str]) -> tuple[int, ...]:
    """Letters of each group of NUMBER, the longest of the cells."""
    found = [match for cell in cells if (match := NUMBER.fullmatch(cell))]
    return tuple(max((len(match[k] or "") for match in found), default=0) for k in range(1, 7))


def _reserved(cells: Sequence[str]) -> float:
    """Letters that an S column keeps for its numbers."""
    sign, digits, decimals, error, below, power = _widths(cells)
    fixed = 1.5 * sign + digits + (decimals and decimals + 0.6) + (error and error + 1.6)
    return fixed + (power and 4.2 + 0.8 * (power + 1.5 * below))


def _letters(text: str) -> float:
    """Its width in letters, of which capitals and others count more."""
    return len(text) + sum(WIDE.get(one, 0.5 * one.isupper()) for one in text)


def _texts(letters: float, most: float) -> str:
    """A column of texts: as wide as they are, or a paragraph."""
    if letters >= most:
        return "l"
    return f">{{\\raggedright\\arraybackslash}}p{{{letters / LETTERS:.3f}\\linewidth}}"

"""Texts of other people's code, which run nothing where they are shown or opened.

Names, settings, messages and what is printed are such texts. Two things make them harmless in
tables, and a third in a log, see `log_line`:

- A control character, also one that changes the direction of writing, is shown by its escape, such
  as \\x1b. A line's end stays.
- A spreadsheet takes a text that begins with = + - or @ for a formula. Such a text has an
  apostrophe before it in a table, which spreadsheets do not show; numbers, lists of them,
  percentages and dashes have none. `benchmarks.store.cells.read_csv` takes it away again, so that
  a text without control characters is read as it was.
"""

from __future__ import annotations

import re

LONGEST = 200  # characters of a line in a log
STARTS = "=+-@\uff1d\uff0b\uff0d\uff20"  # of a formula, also in full width
CONTROLS = re.compile(
    "[\x00-\x09\x0b-\x1f\x7f-\x9f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb\U000e0000-\U000e007f]"
)
FORMULA = re.compile(rf"\s*[{re.escape(STARTS)}]")
NUMBERS = re.compile(r"\s*[-+](inf|nan|([-+\d.,()%\s]|(?<=[\d.])[eE](?=[-+]?\d))*)")


def visible(text: str) -> str:
    """The text with its control characters as escapes; of a text without them, the text itself."""
    return CONTROLS.sub(lambda sign: sign[0].encode("unicode_escape").decode(), text)


def log_line(text: str) -> str:
    """The text on one line of at most LONGEST characters, without what a CI service takes for a
    command of its own."""
    line = visible(" ".join(text.split()))
    line = line if len(line) <= LONGEST else f"{line[: LONGEST - 3]}..."
    return line.replace("::", ": :").replace("##[", "# #[")


def guarded(text: str) -> str:
    """The text as a spreadsheet shows it and runs nothing; `unguarded` is the inverse for a text
    without control characters."""
    shown = visible(text)
    return f"'{shown}" if _is_formula(shown) else shown


def unguarded(text: str) -> str:
    """The text that was `guarded`."""
    return text[1:] if text.startswith("'") and _is_formula(text) else text


def _is_formula(text: str) -> bool:
    """Whether it may be a formula without the apostrophes before it."""
    bare = text.lstrip("'")
    return FORMULA.match(bare) is not None and NUMBERS.fullmatch(bare) is None

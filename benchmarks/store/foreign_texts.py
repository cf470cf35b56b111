"""Make texts of other people's code harmless where they are shown or opened.

Names, settings, messages and printed lines are such texts. In tables two changes are made, and a
third in a log, see `log_line`:

- A control character, also one that changes the direction of writing, is replaced by its escape,
  such as \\x1b. Line feeds stay.
- A spreadsheet takes a text that begins with = + - or @ for a formula. In a table an apostrophe is
  put before such a text, which spreadsheets do not show; not before numbers, lists of them,
  percentages and dashes. `benchmarks.store.cells.read_csv` removes it, so that a text without
  control characters is read unchanged.
"""

from __future__ import annotations

import re

LONGEST_LOG_LINE = 200  # characters of a line in a log
FORMULA_STARTS = "=+-@\uff1d\uff0b\uff0d\uff20"  # of a formula, also in full width
CONTROLS = re.compile(
    "[\x00-\x09\x0b-\x1f\x7f-\x9f\u00ad\u061c\u200b-\u200f\u2028-\u202e\u2060-\u206f"
    "\ud800-\udfff\ufeff\ufff9-\ufffb\U000e0000-\U000e007f]"
)
FORMULA = re.compile(rf"\s*[{re.escape(FORMULA_STARTS)}]")
NUMBER_TEXT = re.compile(r"\s*[-+](inf|nan|([-+\d.,()%\s]|(?<=[\d.])[eE](?=[-+]?\d))*)")


def visible(text: str) -> str:
    """The text with its control characters replaced by escapes."""
    return CONTROLS.sub(lambda sign: sign[0].encode("unicode_escape").decode(), text)


def log_line(text: str) -> str:
    """The text on one line of about LONGEST_LOG_LINE characters at most, without the marks of
    commands to a CI service."""
    line = visible(" ".join(text.split()))
    line = line if len(line) <= LONGEST_LOG_LINE else f"{line[: LONGEST_LOG_LINE - 3]}..."
    return line.replace("::", ": :").replace("##[", "# #[")


def guarded(text: str) -> str:
    """The text so that a spreadsheet shows and does not execute it; `unguarded` is the inverse for
    a text without control characters."""
    escaped = visible(text)
    return f"'{escaped}" if _is_formula(escaped) else escaped


def unguarded(text: str) -> str:
    """The text without the apostrophe of `guarded`."""
    return text[1:] if text.startswith("'") and _is_formula(text) else text


def _is_formula(text: str) -> bool:
    """Whether a spreadsheet may take the text, without apostrophes before it, for a formula."""
    bare = text.lstrip("'")
    return FORMULA.match(bare) is not None and NUMBER_TEXT.fullmatch(bare) is None

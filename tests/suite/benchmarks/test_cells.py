"""Texts of others in tables: a spreadsheet runs nothing of them, a terminal obeys nothing."""

from __future__ import annotations

import csv
import io
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as draw

from benchmarks.applications.external.loading import describe_error
from benchmarks.store.cells import as_csv, read_csv
from benchmarks.store.foreign_texts import guarded, unguarded, visible
from benchmarks.store.row_files import RowFiles
from benchmarks.work_precision.participants import readable_setting
from reports.tables.writing import as_markdown

FORMULAS = ["=1+1", "=cmd|' /C calc'!A0", "@SUM(A1)", "+A1", "-2+cmd|'x'!A0", " =1", "\n=1", "'=1",
            '=HYPERLINK("http://a.b","c")', "-5 to 3", "\uff1d1+1", "-E1", "-e"]  # fmt: skip
PLAIN = ["", "-", "--", "+", "-1.5", "+6 %", "-inf", "-0.58, 31.93", "-1e-5", "+0.553(12)", "née",
         "a=b", "galvi degree 8, Gauss 8", "'quoted'", "it's", "x-1", "REBOUND IAS15"]  # fmt: skip
CONTROLS = [
    "\x1b[31mred\x1b[0m",
    "a\x00b",
    "\u202egnp.exe",
    "tab\there",
    "\r=1",
    "\ud800",
    "\x9b1m",
]
signs = draw.characters(exclude_categories=["Cc", "Cf", "Cs", "Zl", "Zp"])
texts = draw.one_of(
    draw.text(signs), draw.text(draw.sampled_from("'=+-@ 1.5eE%(),ab\n\"")),
    draw.sampled_from([*FORMULAS, *PLAIN]),
)  # fmt: skip


def test_a_formula_has_an_apostrophe_before_it_and_numbers_dashes_and_words_stay() -> None:
    for text in FORMULAS:
        assert guarded(text) == f"'{text}" and unguarded(guarded(text)) == text
    for text in PLAIN:
        assert guarded(text) == text == unguarded(text)


@pytest.mark.parametrize("text", CONTROLS)
def test_control_characters_are_shown(text: str) -> None:
    shown = visible(text)
    assert shown.isprintable() and shown == visible(shown) and "\\" in shown
    assert visible("a\nb") == "a\nb"


@given(draw.one_of(draw.text(), texts))
def test_any_text_is_harmless_and_read_as_it_is_shown(text: str) -> None:
    once = unguarded(guarded(text))
    assert once == visible(text) and unguarded(guarded(once)) == once
    assert guarded(text)[:1] not in ("=", "@", "\t", "\r")


@given(texts)
def test_a_text_without_control_characters_is_shown_as_it_is(text: str) -> None:
    assert visible(text) == text


@given(draw.lists(draw.tuples(texts.filter(bool), draw.floats()), min_size=1))
def test_a_table_is_read_as_it_was(rows: list[tuple[str, float]]) -> None:
    frame = pd.DataFrame(rows, columns=["text", "value"])
    again = read_csv(io.StringIO(as_csv(frame), newline=""), dtype={"text": str},
                     keep_default_na=False, na_values={"value": [""]})  # fmt: skip
    assert list(again["text"]) == list(frame["text"])
    assert np.array_equal(again["value"], frame["value"], equal_nan=True)


def test_cells_that_are_no_texts_are_written_as_pandas_writes_them() -> None:
    frame = pd.DataFrame(
        {"a": [1, None, "=1"], "b": [True, False, True], "c": [-1.5, np.nan, np.inf]}, dtype=object
    )
    assert as_csv(frame) == "a,b,c\n1,True,-1.5\n,False,\n'=1,True,inf\n"
    assert as_csv(frame.iloc[:2]) == frame.iloc[:2].to_csv(index=False)
    assert list(frame["a"]) == [1, None, "=1"]  # the frame itself stays


def test_kept_rows_are_read_as_they_were_and_damaged_ones_are_set_aside(tmp_path: Path) -> None:
    told: list[str] = []
    kept = RowFiles(tmp_path, {"name": str, "value": float}, told.append)
    names = [*FORMULAS, *PLAIN]
    frame = pd.DataFrame({"name": names, "value": 1e-3 * np.arange(float(len(names)))})
    kept.write("rows", frame)
    again = kept.read("rows")
    assert again is not None and again.equals(frame) and told == []
    path = tmp_path / "rows.csv"
    with path.open(newline="") as file:
        cells = [line[0] for line in csv.reader(file) if line]
    assert not [cell for cell in cells if cell[:1] in "=@" and cell]
    sound = path.read_bytes()
    for other in (sound[: len(sound) // 2], sound.replace(b"e-", b"e-1", 1), b"\xff\xfe\x00", b""):
        path.write_bytes(other)
        assert kept.read("rows") is None and not path.exists()
        assert "is set aside as" in told.pop() and told == []
    assert len(list(tmp_path.glob("rows.csv.damaged*"))) == 4 and kept.all().empty


def test_markdown_has_no_formula_tag_bar_or_control_character() -> None:
    texts = ["=1+1", "<img src=x>", "a|b", "a\\b", "two\nlines", "\x1b[2J", "-", "-1.5", "+6 %"]
    lines = as_markdown(pd.DataFrame({"text": texts})).splitlines()[2:]
    cells = [line.strip("| ").rstrip() for line in lines]
    assert cells == ["'=1+1", "&lt;img src=x>", "a\\|b", "a\\\\b", "two lines", "\\\\x1b[2J",
                     "-", "-1.5", "+6 %"]  # fmt: skip


def test_messages_and_settings_of_others_have_no_control_characters() -> None:
    assert describe_error(ValueError("a\x1b[31m\nb\x00.")) == "ValueError: a\\x1b[31m b\\x00"
    assert readable_setting({"\x1b": "\u202e", "step": 0.1}) == "\\x1b=\\u202e step=0.1"

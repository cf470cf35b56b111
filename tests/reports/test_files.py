"""What is written: columns, whole files or none, numbers that are known or blank."""

from __future__ import annotations

import math
import os

import pandas as pd
import pytest

from benchmarks.store.atomic import write
from reports.results.origins import note_origin, read_origins
from reports.tables.claims_table import COLUMNS, claims_frame
from reports.tables.writing import as_csv, write_table


def test_claims_csv_has_exactly_these_columns_in_this_order(make_row):
    assert as_csv(claims_frame([make_row()])).splitlines()[0] == (
        "id,quantity,source,setup,claimed,bound,measured,uncertainty,expected,reference,verdict,"
        "reason,slack,slopes,misses"
    )
    assert list(claims_frame([]).columns) == list(COLUMNS)


@pytest.mark.parametrize("missing", [None, math.nan])
def test_what_was_not_measured_is_blank_everywhere(make_row, tmp_path, missing):
    rows = [make_row(measured=missing, uncertainty=missing, verdict="not run"), make_row()]
    write_table(tmp_path, "claims", claims_frame(rows))
    for kind in ("csv", "md", "tex"):
        text = (tmp_path / f"claims.{kind}").read_text().lower()
        assert "nan" not in text and "none" not in text
    assert pd.read_csv(tmp_path / "claims.csv")["measured"].isna().tolist() == [True, False]


def test_a_table_s_numbers_survive_csv_and_its_bars_survive_markdown(tmp_path):
    frame = pd.DataFrame({"x": [0.1 + 0.2], "text": ["a | b_c & d"]})
    write_table(tmp_path, "t", frame)
    assert pd.read_csv(tmp_path / "t.csv")["x"][0] == 0.1 + 0.2
    assert "a \\| b_c & d" in (tmp_path / "t.md").read_text()
    assert "a \\ensuremath{|} b\\_c \\& d" in (tmp_path / "t.tex").read_text()


def test_a_write_that_fails_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    path = write(tmp_path / "deep" / "a.txt", "old")

    def fail(*places: object) -> None:
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write(path, "new")
    assert path.read_text() == "old"
    assert [each.name for each in path.parent.iterdir()] == ["a.txt"]


def test_each_file_keeps_its_own_origin(tmp_path):
    note_origin(tmp_path, "claims.csv", {"date": "monday"}, quick=True)
    note_origin(tmp_path, "cost.csv", {"date": "friday"}, quick=False)
    assert read_origins(tmp_path) == {
        "claims.csv": {"date": "monday", "setting": "quick"},
        "cost.csv": {"date": "friday", "setting": "default"},
    }


def test_origins_that_cannot_be_read_are_made_anew(tmp_path):
    (tmp_path / "provenance.json").write_text("{ half a file")
    note_origin(tmp_path, "cost.csv", {}, quick=False)
    assert set(read_origins(tmp_path)) == {"cost.csv"}

"""Files are written whole; `galvi export` writes tables and figures wherever they are asked for."""

from __future__ import annotations

import importlib.util
import math
import os
import shutil
import stat
import threading
from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.cli.commands import run
from reports.cli.export import with_bounds
from reports.results.origins import note_origin, read_origins
from reports.tables.claims_table import ROW_COLUMNS, claims_frame
from reports.tables.writing import write_table
from tests.suite.reports.small_reports import ROW, suite_of

ARROW = importlib.util.find_spec("pyarrow") is not None


def test_claims_csv_has_exactly_these_columns_in_this_order():
    assert as_csv(claims_frame([ROW])).splitlines()[0] == (
        "id,quantity,source,setup,claimed,bound,measured,uncertainty,expected,reference,verdict,"
        "reason,slack,slopes,misses,absent"
    )
    assert list(claims_frame([]).columns) == list(ROW_COLUMNS)


@pytest.mark.parametrize("missing", [None, math.nan])
def test_what_was_not_measured_is_blank_everywhere(tmp_path, missing):
    rows = [replace(ROW, measured=missing, uncertainty=missing, verdict="not run"), ROW]
    write_table(tmp_path, "claims", claims_frame(rows))
    for kind in ("csv", "md", "tex"):
        text = (tmp_path / f"claims.{kind}").read_text().lower().rpartition("\\midrule")[2]
        assert "nan" not in text and "none" not in text
    assert pd.read_csv(tmp_path / "claims.csv")["measured"].isna().tolist() == [True, False]


def test_a_table_s_numbers_survive_csv_and_its_bars_survive_markdown(tmp_path):
    write_table(tmp_path, "t", pd.DataFrame({"x": [0.1 + 0.2], "text": ["a | b_c & d"]}))
    assert pd.read_csv(tmp_path / "t.csv")["x"][0] == 0.1 + 0.2
    assert "a \\| b_c & d" in (tmp_path / "t.md").read_text()
    assert "a \\ensuremath{|} b\\_c \\& d" in (tmp_path / "t.tex").read_text()


def test_a_write_that_fails_leaves_the_old_file_and_no_other(tmp_path, monkeypatch):
    path = write(tmp_path / "deep" / "a.txt", "old")

    def fail(*places):
        raise OSError("disk full")

    monkeypatch.setattr(os, "replace", fail)
    with pytest.raises(OSError, match="disk full"):
        write(path, "new")
    assert path.read_text() == "old" and [entry.name for entry in path.parent.iterdir()] == [
        "a.txt"
    ]


def test_each_file_keeps_its_own_origin_and_what_cannot_be_read_is_made_anew(tmp_path):
    (tmp_path / "provenance.json").write_text("{ half a file")
    note_origin(tmp_path, "claims.csv", {"date": "monday"}, quick=True)
    note_origin(tmp_path, "cost.csv", {"date": "friday"}, quick=False)
    assert read_origins(tmp_path) == {
        "claims.csv": {"date": "monday", "setting": "quick"},
        "cost.csv": {"date": "friday", "setting": "default"},
    }


@pytest.fixture(scope="module")
def report(tmp_path_factory):
    """A folder with a compared report."""
    folder = tmp_path_factory.mktemp("report")
    assert run(suite_of, ["compare", "--out", str(folder)]) == 0
    return folder


@pytest.fixture
def export(ask, report):
    """A function that exports from a copy of the report in `out`, and returns the printed lines."""
    shutil.copytree(report, "out")

    def export(options):
        completed = ask(f"export {options}")
        assert completed.status == 0, completed.err
        return completed.out.splitlines()

    return export


def test_one_table_has_error_cost_and_counts_and_is_sorted(export):
    assert export("work_precision --sort contender,-error --to mine.csv") == ["mine.csv"]
    table = pd.read_csv("mine.csv")
    assert {"error", "seconds", "evaluations", "steps", "settings", "status"} <= set(table)
    assert list(table["contender"]) == sorted(table["contender"])
    galvi_errors = table[table["contender"] == "galvi degree 8, Gauss 8"]["error"]
    assert list(galvi_errors) == [1e-2, 1e-3, 1e-9]
    export("work_precision --sort error")
    by_error = pd.read_csv("out/tables/work_precision.csv")["error"].to_numpy()
    assert list(by_error[:4]) == sorted(table["error"].dropna()) and len(by_error) == 6


def test_rows_and_columns_are_chosen(export):
    options = "work_precision --where error=0.001 --columns error,contender --to few.csv"
    for condition in ("", " --where 'contender=galvi degree 8, Gauss 8'"):
        export(options + condition)
        few = pd.read_csv("few.csv")
        assert list(few) == ["error", "contender"] and set(few["error"]) == {1e-3}
        assert list(few["contender"]) == ["galvi degree 8, Gauss 8"]


def test_latex_has_few_digits_to_the_right_and_breaks_over_pages(export):
    table = pd.DataFrame({"who": ["a"] * 60, "ratio": [*[1.2345678901234567] * 59, "not reached"]})
    table.to_csv("out/ratios.csv", index=False)
    export("ratios --format latex")
    latex = Path("out/tables/ratios.tex").read_text()
    assert "\n\\begin{longtable}{lS}" in latex and "\\endfirsthead" in latex
    assert latex.count("a & 1.23 ") == 59 and "a & {not reached}" in latex
    assert "\\toprule" in latex and "commit 0123456789ab" in latex


@pytest.mark.skipif(not ARROW, reason="pyarrow is not installed; make install EXTRAS=...,parquet")
def test_parquet_keeps_every_digit(export):
    export("work_precision --format parquet --to a.parquet")
    parquet, table = pd.read_parquet("a.parquet"), pd.read_csv("out/work_precision.csv")
    assert list(parquet) == list(table) and list(parquet["contender"]) == list(table["contender"])
    assert np.array_equal(parquet["seconds"], table["seconds"], equal_nan=True)


def test_what_there_is_is_listed_and_all_of_it_is_written(export, ask):
    listed = export("--list")
    tables = [line.split()[0] for line in listed if line.endswith("  table")]
    figures = [line.split()[0] for line in listed if "  figure: " in line]
    assert "work_precision" in tables and figures
    errors = ask(f"export {figures[0]}").err
    assert errors == f"{figures[0]!r} is a figure: add --format pdf, svg or png.\n"
    assert len(export("--all --format markdown")) == len(tables)
    lines = export("--all --format svg")
    paths = [Path(line) for line in lines if line.endswith(".svg")]
    assert paths and all("cannot be drawn: " in line for line in lines if Path(line) not in paths)
    for path in paths:
        beside = path.with_name(f"{path.stem}-caption")
        assert beside.with_suffix(".txt").read_text().strip()
        assert beside.with_suffix(".tex").read_text().startswith("\\caption{")


# Targets of --to that are no files of their own: standard output, pipes, devices, links.

FIGURE = "work-precision-kepler-e-0-6"
TEXT = "who,x\nnée,0.30000000000000004\nb,\n"


@pytest.mark.parametrize("to", ["-", "/dev/stdout", "/dev/fd/1"])
def test_a_table_alone_is_in_standard_output_as_utf_8(tmp_path, capfdbinary, to):
    if to != "-" and not os.path.exists(to):
        pytest.skip(f"this system has no {to}")
    (tmp_path / "t.csv").write_text(TEXT)
    assert run(suite_of, ["export", "t", "--to", to, "--out", str(tmp_path)]) == 0
    assert capfdbinary.readouterr().out == TEXT.encode()
    assert [path.name for path in tmp_path.iterdir()] == ["t.csv"]


@pytest.mark.parametrize(
    ("name", "form"),
    [(FIGURE, "png"), ("cost", "markdown"), *([("work_precision", "parquet")] if ARROW else [])],
)
def test_bytes_in_standard_output_are_those_of_the_file(report, tmp_path, capfdbinary, name, form):
    arguments = ["export", name, "--format", form, "--out", str(report), "--to"]
    assert run(suite_of, [*arguments, str(tmp_path / "file")]) == 0
    capfdbinary.readouterr()
    assert run(suite_of, [*arguments, "-"]) == 0
    assert capfdbinary.readouterr().out == (tmp_path / "file").read_bytes()


def piped(export, options):
    """The bytes that a reader of a pipe receives; asserts that the pipe was not replaced."""
    os.mkfifo("pipe")
    received = list[bytes]()
    reader = threading.Thread(target=lambda: received.append(Path("pipe").read_bytes()))
    reader.start()
    assert export(f"{options} --to pipe") == ["pipe"]
    reader.join(30)
    assert stat.S_ISFIFO(Path("pipe").stat().st_mode)
    return received[0]


def test_a_figure_in_a_pipe_has_no_captions_beside_it(export, tmp_path):
    export(f"{FIGURE} --format pdf --to a.pdf")
    captions = {"a-caption.tex", "a-caption.txt"}
    assert {path.name for path in tmp_path.iterdir()} == {"out", "a.pdf", *captions}
    assert piped(export, f"{FIGURE} --format pdf")[:5] == b"%PDF-"
    assert {path.name for path in tmp_path.iterdir()} == {"out", "a.pdf", "pipe", *captions}


def test_a_pipe_and_a_link_stay_what_they_are(export):
    Path("out/t.csv").write_text(TEXT)
    assert piped(export, "t") == TEXT.encode()
    link, target = Path("link"), Path("target")
    link.symlink_to("target")
    for _ in range(2):  # first the link leads to nothing, then to a file
        export("t --to link")
        assert link.is_symlink() and target.read_text(encoding="utf-8") == TEXT
        target.write_text("old")
        target.chmod(0o600)
    assert target.stat().st_mode & 0o777 == 0o600


def test_an_exported_error_that_is_a_bound_is_said_to_be_one():
    table = pd.DataFrame({"contender": ["A", "B"], "error": [1e-3, 1e-12]})
    for bounds, shown in (([False, True], ["error", "error_is_bound"]), ([False] * 2, ["error"])):
        assert with_bounds(table.assign(error_is_bound=bounds), ["error"]) == shown
    assert with_bounds(table, ["contender"]) == ["contender"]

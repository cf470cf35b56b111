"""Files are written whole, and exported."""

from __future__ import annotations

import importlib.util
import math
import os
import stat
import threading
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.cli.commands import run
from reports.cli.export import with_bounds
from reports.results.origins import note_origin, read_origins
from reports.tables.claims_table import COLUMNS, claims_frame
from reports.tables.writing import write_table


def test_claims_csv_has_exactly_these_columns_in_this_order(make_row):
    assert as_csv(claims_frame([make_row()])).splitlines()[0] == (
        "id,quantity,source,setup,claimed,bound,measured,uncertainty,expected,reference,verdict,"
        "reason,slack,slopes,misses,absent"
    )
    assert list(claims_frame([]).columns) == list(COLUMNS)


@pytest.mark.parametrize("missing", [None, math.nan])
def test_what_was_not_measured_is_blank_everywhere(make_row, tmp_path, missing):
    rows = [make_row(measured=missing, uncertainty=missing, verdict="not run"), make_row()]
    write_table(tmp_path, "claims", claims_frame(rows))
    for kind in ("csv", "md", "tex"):
        text = (tmp_path / f"claims.{kind}").read_text().lower().rpartition("\\midrule")[2]
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


ARROW = importlib.util.find_spec("pyarrow") is not None


@pytest.fixture(scope="module")
def out(make_suite, tmp_path_factory):
    """A folder with a compared report."""
    folder = tmp_path_factory.mktemp("report")
    assert run(make_suite, ["compare", "--out", str(folder)]) == 0
    return folder


def test_one_table_has_error_cost_and_counts_and_is_sorted(make_suite, out, tmp_path, capsys):
    to = tmp_path / "mine.csv"
    words = ["export", "work_precision", "--sort", "contender,-error", "--to", str(to)]
    assert run(make_suite, [*words, "--out", str(out)]) == 0
    assert capsys.readouterr().out == f"{to}\n"
    table = pd.read_csv(to)
    assert {"error", "seconds", "evaluations", "steps", "settings", "status"} <= set(table)
    assert list(table["contender"]) == sorted(table["contender"])
    ours = table[table["contender"] == "galvi degree 8, Gauss 8"]["error"]
    assert list(ours) == [1e-2, 1e-3, 1e-9]
    table = pd.read_csv(out / "work_precision.csv")
    assert run(make_suite, ["export", "work_precision", "--sort", "error", "--out", str(out)]) == 0
    by_error = pd.read_csv(out / "tables" / "work_precision.csv")["error"].to_numpy()
    assert np.array_equal(by_error[:4], np.sort(table["error"].dropna())) and len(by_error) == 6


def test_latex_has_the_rules_of_booktabs_and_markdown_a_table(make_suite, out):
    for form in ("latex", "markdown"):
        words = ["export", "work_precision", "--format", form, "--out", str(out)]
        assert run(make_suite, words) == 0
    latex = (out / "tables" / "work_precision.tex").read_text()
    assert all(rule in latex for rule in ("\\toprule", "\\midrule", "\\bottomrule"))
    assert "{\\shortstack{seconds\\\\low}}" in latex and "nan" not in latex.lower()
    assert "commit 0123456789ab" in latex and "\\begin{landscape}" in latex
    assert "| galvi degree 8" in (out / "tables" / "work_precision.md").read_text()


def test_latex_has_few_digits_to_the_right_and_breaks_over_pages(make_suite, tmp_path):
    table = pd.DataFrame({"who": ["a"] * 60, "ratio": [*[1.2345678901234567] * 59, "not reached"]})
    table.to_csv(tmp_path / "ratios.csv", index=False)
    words = ["export", "ratios", "--format", "latex", "--out", str(tmp_path)]
    assert run(make_suite, words) == 0
    latex = (tmp_path / "tables" / "ratios.tex").read_text()
    assert "\n\\begin{longtable}{lS}" in latex
    assert latex.count("a & 1.23 ") == 59 and "a & {not reached}" in latex
    assert "\\endfirsthead" in latex and "\\caption{Ratios.}" in latex


@pytest.mark.skipif(not ARROW, reason="pyarrow is not installed; make install EXTRAS=...,parquet")
def test_parquet_keeps_every_digit(make_suite, out, tmp_path):
    to = tmp_path / "a.parquet"
    words = ["export", "work_precision", "--format", "parquet", "--to", str(to), "--out", str(out)]
    assert run(make_suite, words) == 0
    kept, table = pd.read_parquet(to), pd.read_csv(out / "work_precision.csv")
    assert list(kept) == list(table)
    assert np.array_equal(kept["seconds"], table["seconds"], equal_nan=True)
    assert list(kept["contender"]) == list(table["contender"])


def test_without_pyarrow_parquet_says_what_to_install(make_suite, out, capsys, monkeypatch):
    def absent(*words, **more):
        raise ImportError("Unable to find a usable engine.")

    monkeypatch.setattr(pd.DataFrame, "to_parquet", absent)
    words = ["export", "work_precision", "--format", "parquet", "--out", str(out)]
    assert run(make_suite, words) == 2
    assert capsys.readouterr().err.startswith("Parquet needs pyarrow (pip install pyarrow): ")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["work_precison"], "did you mean 'work_precision'"),
        (
            ["ratios", "--format", "tex"],
            "'--format': 'tex' is not one of 'csv', 'parquet', 'latex'",
        ),
        (["ratios", "--sort", "eror"], "did you mean 'error'"),
        (["ratios", "--to", "."], "'--to': file '.' is a directory."),
        (
            ["ratios", "--where", "problem=keppler"],
            "There is no problem 'keppler' among kepler e=0.6; did you mean",
        ),
        (["ratios", "--where", "problme=a"], "did you mean 'problem'"),
        (["ratios", "--where", "problem"], "--where expects column=value; received 'problem'."),
        (["ratios", "--columns", "problem,eror"], "did you mean 'error'"),
        ([], "Expected exactly one of NAME, --list and --all."),
        (["ratios", "--all"], "Expected exactly one of NAME"),
        (["--list", "ratios"], "Expected exactly one of NAME"),
        (["--all", "--to", "x"], "--all does not take --to"),
        (["--all", "--where", "a=b"], "are for one table"),
        (["fig-3-02", "--format", "pdf", "--columns", "a"], "are for one table"),
        (["--all", "--format", "pfd"], "'pfd' is not one of "),
        (
            ["--all", "--format", "pdf", "--width", "colum"],
            "'colum' is not one of 'column', 'page'",
        ),
    ],
)
def test_what_was_mistyped_is_answered_in_a_sentence(make_suite, out, capsys, words, said):
    assert run(make_suite, ["export", *words, "--out", str(out)]) == 2
    told = capsys.readouterr().err
    assert said in told and len(told.splitlines()) == 1


def test_rows_and_columns_are_chosen(make_suite, out, tmp_path):
    to = tmp_path / "few.csv"
    words = ["export", "work_precision", "--where", "error=0.001", "--columns", "error,contender"]
    assert run(make_suite, [*words, "--to", str(to), "--out", str(out)]) == 0
    few = pd.read_csv(to)
    assert list(few) == ["error", "contender"] and set(few["error"]) == {1e-3} and len(few)
    narrow = [*words, "--where", f"contender={few['contender'][0]}", "--to", str(to)]
    assert run(make_suite, [*narrow, "--out", str(out)]) == 0
    assert set(pd.read_csv(to)["contender"]) == {few["contender"][0]}


def test_an_empty_table_and_one_with_gaps_have_rows_to_choose_from(make_suite, tmp_path, capsys):
    pd.DataFrame({"who": ["a", None], "x": [1.0, np.nan]}).to_csv(
        tmp_path / "gaps.csv", index=False
    )
    pd.DataFrame({"who": []}).to_csv(tmp_path / "none.csv", index=False)
    for name in ("gaps", "none"):
        words = ["export", name, "--where", "who=b", "--out", str(tmp_path)]
        assert run(make_suite, words) == 2
        assert "There is no who 'b'" in capsys.readouterr().err
    assert run(make_suite, ["export", "--all", "--format", "svg", "--out", str(tmp_path)]) == 2


def test_what_there_is_is_listed_and_all_of_it_is_written(make_suite, out, capsys):
    assert run(make_suite, ["export", "--list", "--out", str(out)]) == 0
    listed = capsys.readouterr().out.splitlines()
    assert "work_precision  table" in listed and any("  figure: " in line for line in listed)
    figure = next(line.split()[0] for line in listed if "  figure: " in line)
    assert run(make_suite, ["export", figure, "--out", str(out)]) == 2
    assert capsys.readouterr().err == f"{figure!r} is a figure: add --format pdf, svg or png.\n"
    assert run(make_suite, ["export", "--all", "--format", "markdown", "--out", str(out)]) == 0
    written = capsys.readouterr().out.splitlines()
    assert len(written) == sum(line.endswith("  table") for line in listed)
    assert run(make_suite, ["export", "--all", "--format", "svg", "--out", str(out)]) == 0
    lines = capsys.readouterr().out.splitlines()
    paths = [Path(line) for line in lines if line.endswith(".svg")]
    assert paths and all("cannot be drawn: " in line for line in lines if Path(line) not in paths)
    for path in paths:
        beside = path.with_name(f"{path.stem}-caption")
        assert beside.with_suffix(".txt").read_text().strip()
        assert beside.with_suffix(".tex").read_text().startswith("\\caption{")


def test_an_empty_folder_and_a_damaged_table_are_told(make_suite, tmp_path, capsys):
    assert run(make_suite, ["export", "ratios", "--out", str(tmp_path)]) == 2
    assert "holds no table yet; run compare or build first." in capsys.readouterr().err
    (tmp_path / "ratios.csv").write_text("")
    assert run(make_suite, ["export", "ratios", "--out", str(tmp_path)]) == 2
    assert "ratios.csv cannot be read: No columns" in capsys.readouterr().err


# Targets of --to that are no files of their own: standard output, pipes, devices, links.


@pytest.fixture
def small(tmp_path):
    """A folder with one table, and its text."""
    folder = tmp_path / "report"
    frame = pd.DataFrame({"who": ["née", "b"], "x": [0.1 + 0.2, np.nan]})
    return folder, write(folder / "t.csv", as_csv(frame)).read_text(encoding="utf-8")


@pytest.mark.parametrize("to", ["-", "/dev/stdout", "/dev/fd/1"])
def test_a_table_alone_is_in_standard_output_as_utf_8(make_suite, small, capfdbinary, to):
    if to != "-" and not os.path.exists(to):
        pytest.skip(f"this system has no {to}")
    folder, text = small
    assert run(make_suite, ["export", "t", "--to", to, "--out", str(folder)]) == 0
    assert capfdbinary.readouterr().out == text.encode()
    words = ["export", "t", "--format", "markdown", "--to", to, "--out", str(folder)]
    assert run(make_suite, words) == 0
    assert "née" in capfdbinary.readouterr().out.decode()
    assert sorted(path.name for path in folder.parent.rglob("*")) == ["report", "t.csv"]


def a_figure(make_suite, out, capsys) -> str:
    """The name of the first figure that was drawn of all."""
    assert run(make_suite, ["export", "--all", "--format", "svg", "--out", str(out)]) == 0
    printed = capsys.readouterr().out
    lines = (printed if isinstance(printed, str) else printed.decode()).splitlines()
    return Path(next(line for line in lines if line.endswith(".svg"))).stem.removesuffix("-page")


def test_a_figure_in_standard_output_or_a_pipe_has_no_captions_beside_it(
    make_suite, out, tmp_path, capsys, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    figure = a_figure(make_suite, out, capsys)
    words = ["export", figure, "--format", "pdf", "--out", str(out), "--to"]
    assert run(make_suite, [*words, "a.pdf"]) == 0
    assert sorted(path.name for path in tmp_path.iterdir()) == [
        "a-caption.tex", "a-caption.txt", "a.pdf",
    ]  # fmt: skip
    capsys.readouterr()
    os.mkfifo("pipe")
    received = list[bytes]()
    reader = threading.Thread(target=lambda: received.append(Path("pipe").read_bytes()))
    reader.start()
    assert run(make_suite, [*words, "pipe"]) == 0
    reader.join(30)
    assert received[0][:5] == b"%PDF-" and capsys.readouterr().out == "pipe\n"
    assert len(list(tmp_path.iterdir())) == 4


@pytest.mark.parametrize("form", ["png", *(["parquet"] if ARROW else [])])
def test_bytes_in_standard_output_are_those_of_the_file(
    make_suite, out, tmp_path, capfdbinary, form
):
    name = "work_precision" if form == "parquet" else a_figure(make_suite, out, capfdbinary)
    words = ["export", name, "--format", form, "--out", str(out), "--to"]
    assert run(make_suite, [*words, str(tmp_path / "file")]) == 0
    capfdbinary.readouterr()
    assert run(make_suite, [*words, "-"]) == 0
    assert capfdbinary.readouterr().out == (tmp_path / "file").read_bytes()


def test_a_pipe_a_link_and_a_device_stay_what_they_are(make_suite, small, capsys):
    folder, text = small
    pipe, link, target = (folder.parent / name for name in ("pipe", "link", "target"))
    words = ["export", "t", "--out", str(folder), "--to"]
    os.mkfifo(pipe)
    received = list[str]()
    reader = threading.Thread(target=lambda: received.append(pipe.read_text(encoding="utf-8")))
    reader.start()
    assert run(make_suite, [*words, str(pipe)]) == 0
    reader.join(30)
    assert received == [text] and stat.S_ISFIFO(pipe.stat().st_mode)
    link.symlink_to("target")
    for _ in range(2):  # of a link to nothing, and to a file
        assert run(make_suite, [*words, str(link)]) == 0
        assert link.is_symlink() and target.read_text(encoding="utf-8") == text
        target.write_text("old")
        target.chmod(0o600)
    assert target.stat().st_mode & 0o777 == 0o600


def test_a_target_that_cannot_be_written_is_told_in_a_sentence(make_suite, small, capsys):
    folder, _ = small
    (folder / "a").symlink_to("b")
    (folder / "b").symlink_to("a")
    for to in (folder / "a", folder / "t.csv" / "c"):
        words = ["export", "t", "--out", str(folder), "--to", str(to)]
        assert run(make_suite, words) == 2
        told = capsys.readouterr().err
        assert told.startswith("The command could not be carried out: ") and str(folder) in told
        assert len(told.splitlines()) == 1


def test_an_exported_error_that_is_a_bound_is_said_to_be_one() -> None:
    table = pd.DataFrame({"contender": ["A", "B"], "error": [1e-3, 1e-12]})
    for bounds, shown in (([False, True], ["error", "error_is_bound"]), ([False] * 2, ["error"])):
        columns = with_bounds(table.assign(error_is_bound=bounds), ["error"])
        assert columns == shown
    assert with_bounds(table, ["contender"]) == ["contender"]

"""Stored data: provenance, benches, the catalogue of timings, and foreign texts in tables, which
are harmless in spreadsheets and terminals."""

from __future__ import annotations

import csv
import io
import json
import math
import subprocess
import sys
from dataclasses import asdict, replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from hypothesis import given
from hypothesis import strategies as draw

import galvi
from benchmarks.applications.external.loading import describe_error
from benchmarks.store import provenance
from benchmarks.store.cells import as_csv, read_csv
from benchmarks.store.foreign_texts import guarded, unguarded, visible
from benchmarks.store.row_files import RowFiles
from benchmarks.timings.case import ROUND_OFF, STEP, TRAJECTORY, Case
from benchmarks.timings.catalogue import CASES
from benchmarks.timings.truth import Unknown, error_of, true_ends
from benchmarks.work_precision.participants import readable_setting
from references import reference
from reports.tables.writing import as_markdown


def test_it_names_the_versions_that_run() -> None:
    versions = provenance.provenance("make report")
    assert versions["numpy"] == np.__version__
    assert versions["python"] == ".".join(map(str, sys.version_info[:3]))
    assert versions["command"] == "make report"
    assert int(versions["threads"]) >= 1
    assert all(isinstance(value, str) and value for value in versions.values())


def test_the_command_is_the_one_typed_without_folders(monkeypatch: pytest.MonkeyPatch) -> None:
    program = str(Path("somewhere") / "deep" / "reports" / "__main__.py")
    monkeypatch.setattr(sys, "argv", [program, "verify", "--quick"])
    assert provenance.provenance()["command"] == "python -m reports verify --quick"
    monkeypatch.setattr(sys, "argv", [str(Path("somewhere") / "pytest"), "-q"])
    assert provenance.provenance()["command"] == "pytest -q"


@pytest.mark.parametrize(
    ("version", "commit"),
    [
        ("0.1.0.dev0+gf6e5c5a015ae.dirty", "f6e5c5a015ae+dirty"),
        ("0.1.0", "unknown"),
    ],
)
def test_the_commit_of_an_installation_is_that_of_its_version(
    version: str, commit: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Also inside of another project's checkout, whose commit is none of galvi's."""
    subprocess.run(["git", "init", "-q", tmp_path], check=True)
    identity = ["-c", "user.name=me", "-c", "user.email=me@localhost"]
    arguments = ["commit", "-q", "--allow-empty", "-m", "theirs"]
    subprocess.run(["git", "-C", tmp_path, *identity, *arguments], check=True)
    installed = tmp_path / "site-packages"
    installed.mkdir()
    monkeypatch.setattr(provenance, "ROOT", installed)
    monkeypatch.setattr(provenance, "galvi_version", lambda: version)
    assert provenance.commit() == commit


def test_an_engine_that_is_absent_is_said_to_be(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(provenance, "ENGINES", ("numpy", "no-such-engine"))
    assert provenance.versions()["no-such-engine"] == "not installed"


ROOT = Path(__file__).parents[3]


@pytest.mark.slow(
    beside="tests/suite/reports/test_track_history.py::test_each_quantity_of_each_bench_is_a_row"
)
def test_a_bench_is_stored_with_what_is_read_of_it(tmp_path: Path) -> None:
    command = ["-m", "pytest", "benchmarks/timings", "-q", "-k", "oscillator and closed"]
    command += ["--benchmark-enable", "--benchmark-only", "-p", "no:cacheprovider"]
    command += [f"--benchmark-storage=file://{tmp_path}"]
    subprocess.run([sys.executable, *command], cwd=ROOT, capture_output=True, check=True)
    (path,) = tmp_path.rglob("*.json")
    rows = json.loads(path.read_text())["benchmarks"]
    assert rows and len(rows) == len({row["name"] for row in rows})
    for row in rows:
        assert row["extra_info"]["yardstick"]["seconds"] > 0.0 and row["stats"]["data"]
        assert {"error", "counts", "status", "settings", "versions"} < set(row["extra_info"])


def test_every_problem_has_cases_of_each_kind_by_names_of_their_own_and_as_plain_data() -> None:
    for kind in (STEP, TRAJECTORY):
        problems = {case.problem for case in CASES if case.kind == kind}
        assert problems == set(galvi.problems.__all__)
    assert len({case.name for case in CASES}) == len(CASES)
    for case in CASES:
        plain = json.loads(json.dumps(asdict(case)))
        assert json.loads(json.dumps(asdict(Case(**plain)))) == plain
        problem = getattr(galvi.problems, case.problem)(**case.arguments)
        assert not case.truth or reference(case.truth).supports(problem), case.name
    quick = [case for case in CASES if case.quick]
    assert {case.kind for case in quick} == {STEP, TRAJECTORY, ROUND_OFF}
    assert len(quick) < len(CASES) / 2


def test_a_case_without_a_truth_says_so() -> None:
    with pytest.raises(Unknown, match="no truth but galvi's own"):
        true_ends(replace(CASES[0], truth=""))


def test_the_error_is_the_rms_over_starts_and_nan_for_a_failed_run() -> None:
    truth = [[0.0, 0.0], [0.0, 0.0]]
    assert error_of([[3.0, 0.0], [0.0, -4.0]], truth) == pytest.approx(12.5**0.5)
    assert math.isnan(error_of([[math.nan, 0.0], [0.0, 0.0]], truth))


def test_a_version_of_changed_files_is_not_that_of_the_commit() -> None:
    digits, plus, digest = provenance.version().partition("+")
    assert len(digits) in (7, 12) and (not plus or len(digest) == 8)


# ---- texts of others

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
    draw.text(signs),
    draw.text(draw.sampled_from("'=+-@ 1.5eE%(),ab\n\"")),
    draw.sampled_from([*FORMULAS, *PLAIN]),
)


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
    shown = unguarded(guarded(text))
    assert shown == visible(text) and unguarded(guarded(shown)) == shown
    assert guarded(text)[:1] not in ("=", "@", "\t", "\r")


@given(texts)
def test_a_text_without_control_characters_is_shown_as_it_is(text: str) -> None:
    assert visible(text) == text


@given(draw.lists(draw.tuples(texts.filter(bool), draw.floats()), min_size=1))
def test_a_table_is_read_as_it_was(rows: list[tuple[str, float]]) -> None:
    table = pd.DataFrame(rows, columns=["text", "value"])
    read_back = read_csv(
        io.StringIO(as_csv(table), newline=""),
        dtype={"text": str},
        keep_default_na=False,
        na_values={"value": [""]},
    )
    assert list(read_back["text"]) == list(table["text"])
    assert np.array_equal(read_back["value"], table["value"], equal_nan=True)


def test_cells_that_are_no_texts_are_written_as_pandas_writes_them() -> None:
    table = pd.DataFrame(
        {"a": [1, None, "=1"], "b": [True, False, True], "c": [-1.5, np.nan, np.inf]}, dtype=object
    )
    assert as_csv(table) == "a,b,c\n1,True,-1.5\n,False,\n'=1,True,inf\n"
    assert as_csv(table.iloc[:2]) == table.iloc[:2].to_csv(index=False)
    assert list(table["a"]) == [1, None, "=1"]  # the table itself is unchanged


def test_kept_rows_are_read_as_they_were_and_damaged_ones_are_set_aside(tmp_path: Path) -> None:
    messages: list[str] = []
    row_files = RowFiles(tmp_path, {"name": str, "value": float}, messages.append)
    names = [*FORMULAS, *PLAIN]
    table = pd.DataFrame({"name": names, "value": 1e-3 * np.arange(float(len(names)))})
    row_files.write("rows", table)
    read_back = row_files.read("rows")
    assert read_back is not None and read_back.equals(table) and messages == []
    path = tmp_path / "rows.csv"
    with path.open(newline="") as file:
        cells = [line[0] for line in csv.reader(file) if line]
    assert not [cell for cell in cells if cell[:1] in "=@" and cell]
    intact = path.read_bytes()
    for damaged in (
        intact[: len(intact) // 2],
        intact.replace(b"e-", b"e-1", 1),
        b"\xff\xfe\x00",
        b"",
    ):
        path.write_bytes(damaged)
        assert row_files.read("rows") is None and not path.exists()
        assert "is set aside as" in messages.pop() and messages == []
    assert len(list(tmp_path.glob("rows.csv.damaged*"))) == 4 and row_files.all().empty


def test_markdown_has_no_formula_tag_bar_or_control_character() -> None:
    texts = ["=1+1", "<img src=x>", "a|b", "a\\b", "two\nlines", "\x1b[2J", "-", "-1.5", "+6 %"]
    lines = as_markdown(pd.DataFrame({"text": texts})).splitlines()[2:]
    cells = [line.strip("| ").rstrip() for line in lines]
    assert cells == [
        "'=1+1",
        "&lt;img src=x>",
        "a\\|b",
        "a\\\\b",
        "two lines",
        "\\\\x1b[2J",
        "-",
        "-1.5",
        "+6 %",
    ]


def test_messages_and_settings_of_others_have_no_control_characters() -> None:
    assert describe_error(ValueError("a\x1b[31m\nb\x00.")) == "ValueError: a\\x1b[31m b\\x00"
    assert readable_setting({"\x1b": "\u202e", "step": 0.1}) == "\\x1b=\\u202e step=0.1"

"""Mutants: which are found, which tests are asked, and that a compiled line reaches its callers."""

import ast
import json
from dataclasses import replace

import pandas as pd
import pytest

from benchmarks.applications.mutation import mutants, study, trial
from benchmarks.applications.mutation.reach import (
    Reach,
    copied,
    write_durations,
)
from benchmarks.store.provenance import ROOT
from reports.studies.faults import mutants_table

SOURCE = "def half(x):\n    return x / 2\n"
TEST = "from small import half\n\ndef test_half():\n    assert half(4) == 2\n"
CHANGES = {
    "x * 2": "killed",
    "x / 2.0": "survived",
    "half(x)": "killed",
    "exec('while True: pass')": "killed",
}


class Known(Reach):
    """A small project whose tests are known."""

    def tests(self, file, line):
        return ["test_small.py::test_half"] if line == 2 else []


@pytest.fixture
def project(tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", str(ROOT))
    (tmp_path / "small.py").write_text(SOURCE)
    (tmp_path / "test_small.py").write_text(TEST)
    (tmp_path / "durations.json").write_text(json.dumps({"test_small.py::test_half": 0.01}))
    monkeypatch.setattr(trial, "START", 2.0)
    return Known(tmp_path, tmp_path)


@pytest.mark.slow_cases(but=["half(x)"])
@pytest.mark.parametrize("change", CHANGES)
def test_a_fault_that_a_test_sees_is_found_and_one_that_computes_the_same_is_not(
    project, monkeypatch, change
):
    monkeypatch.setattr(mutants, "_mutated", lambda text, *where: text.replace("x / 2", change))
    mutant = mutants.Mutant("small.py", "", 0, 2, "return x / 2", f"return {change}", "")
    assert trial.tried(mutant, project, project.root).outcome == CHANGES[change]
    assert trial.tried(replace(mutant, line=1), project, project.root).outcome == "not reached"
    assert (project.root / "small.py").read_text() == SOURCE


@pytest.mark.slow(
    beside="test_a_fault_that_a_test_sees_is_found_and_one_that_computes_the_same_is_not"
)
def test_what_the_first_tests_do_not_find_the_others_may(project, monkeypatch):
    (project.root / "test_small.py").write_text(TEST + "\n\ndef test_0():\n    pass\n")
    names = ["test_small.py::test_0", "test_small.py::test_half"]
    (project.root / "durations.json").write_text(json.dumps(dict.fromkeys(names, 0.01)))
    monkeypatch.setattr(Known, "tests", lambda self, file, line: names)
    monkeypatch.setattr(mutants, "_mutated", lambda text, *where: text.replace("x / 2", "x * 2"))
    mutant = mutants.Mutant("small.py", "", 0, 2, "return x / 2", "return x * 2", "")
    for first in (1, 2):
        monkeypatch.setattr(trial, "SOON", first)
        assert trial.tried(mutant, project, project.root).test == names[1]


def test_the_quickest_tests_are_asked_first_and_no_more_than_two_minutes_of_them(tmp_path):
    (tmp_path / "durations.json").write_text(json.dumps({"a": 1.0, "b": 100.0, "c": 50.0}))
    reach = Reach(tmp_path, tmp_path)
    assert reach.chosen(["a", "b", "c"]) == ["a", "b"]
    assert reach.chosen(["b", "c"]) == ["b"]


def test_of_a_kernels_line_those_that_import_it_are_asked_first(tmp_path):
    """The time for tests would be spent on runs before one of an error is asked."""
    file, slow, quick = "galvi/kernels/small.py", "tests/test_small.py::a", "tests/test_run.py::b"
    (tmp_path / "galvi/kernels").mkdir(parents=True)
    (tmp_path / file).write_text("def half(x):\n    return x / 2\n")
    (tmp_path / "galvi/run.py").write_text("from galvi.kernels.small import half\n\nhalf(3)\n")
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/test_small.py").write_text("from galvi.kernels.small import half\n")
    (tmp_path / "tests/test_run.py").write_text("import galvi.run\n")
    (tmp_path / "durations.json").write_text(json.dumps({slow: 9.0, quick: 1.0}))
    reach = Reach(tmp_path, tmp_path)
    reach.__dict__["_lines"] = {"galvi/run.py": {3: {quick}}}
    assert reach.tests(file, 2) == [slow, quick]


def test_what_runs_at_import_is_reached_by_all_that_call_a_function_of_the_file(tmp_path):
    """By whichever test was first alone, a constant would hardly be looked at."""
    text = (
        "LIMIT = 2\n\ndef over(x=1):\n    y = (\n        x\n        > LIMIT\n    )\n    return y\n"
    )
    (tmp_path / "small.py").write_text(text)
    reach = Reach(tmp_path, tmp_path)
    reach.__dict__["_lines"] = {"small.py": {1: {"first"}, 4: {"a"}, 8: {"a", "b"}}}
    importing, other = "tests/test_small.py::c", "tests/test_other.py::d"
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests/test_small.py").write_text("from small import over\n")
    (tmp_path / "tests/test_other.py").write_text("from smaller import over\n")
    (tmp_path / "durations.json").write_text(
        json.dumps({"a": 3.0, "b": 4.0, importing: 2.0, other: 1.0})
    )
    asked = {line: reach.tests("small.py", line) for line in (1, 3, 4, 6, 8)}
    both, one = ["a", "b", importing], ["a", importing]
    assert asked == {1: both, 3: both, 4: one, 6: one, 8: both}


def test_a_test_that_fails_without_a_fault_is_not_asked(tmp_path):
    cases = (
        '<testcase file="a.py" name="good" time="2"/><testcase file="a.py" name="bad"><failure/>'
    )
    (tmp_path / "tests.xml").write_text(f"<suite>{cases}</testcase></suite>")
    write_durations(tmp_path)
    reach = Reach(tmp_path, tmp_path)
    reach.__dict__["_lines"] = {"small.py": {1: {"a.py::good", "a.py::bad"}}}
    (tmp_path / "small.py").write_text("x = 1\n")
    assert reach.tests("small.py", 1) == ["a.py::good"]


def test_a_copy_leaves_out_what_is_built_or_held_and_no_room_of_that_name(tmp_path):
    for name in ("build/lib.py", "reports/build/room.py", "reports/out/rows.csv", ".git/head",
                 "galvi/kernel.lock"):  # fmt: skip
        (tmp_path / "root" / name).parent.mkdir(parents=True)
        (tmp_path / "root" / name).touch()
    copy = copied(tmp_path / "root", tmp_path / "copy")
    assert [one.name for one in copy.rglob("*") if one.is_file()] == ["room.py"]


def test_what_is_no_python_is_no_mutant_and_a_change_is_shown_whole():
    assert mutants._difference(["a", "b(", "  1,", "c"], ["a", "b( 2,", "c"]) == ("b( 1,", "b( 2,")
    assert mutants._difference(["x", "x", "y"], ["x", "z", "y"]) == ("x", "z")


def test_annotations_are_no_place_for_a_fault():
    text = "def half(x: int | None = 2 | 1) -> 3 | 4:\n    y: 5 = x | 6\n    return y\n"
    idle = mutants._not_executed(ast.parse(text))
    lines = text.splitlines()
    found = {lines[row - 1][first:last] for (row, first), (_, last) in idle}
    assert found == {"int | None", "3 | 4", "5"}


def test_what_is_called_equivalent_changes_a_line_of_today():
    lines = {file: (ROOT / file).read_text().splitlines() for file, _, _ in study.equivalents()}
    for file, before, after in study.equivalents():
        assert before != after
        assert any(line.strip() == before for line in lines[file]), (file, before)


def test_what_survived_is_tried_again_when_the_tests_change_and_what_is_equivalent_never(tmp_path):
    blank = dict.fromkeys(study.COLUMNS, "") | {"line": 1, "seconds": 1.0, "seed": 1}
    file, before, after = min(study.equivalents())
    same = {"file": file, "before": before, "after": after}
    rows = [
        blank | {"mutant": "a", "outcome": "killed", "tests": "before"},
        blank | {"mutant": "b", "outcome": "survived", "tests": "before"},
        blank | {"mutant": "c", "outcome": "survived", "tests": "before"} | same,
        blank | {"mutant": "d", "outcome": "survived", "tests": "now"},
    ]
    all_four = [mutants.Mutant("", "", 0, 1, "", "", code) for code in "abcd"]
    all_four[2] = mutants.Mutant(file, "", 0, 1, before, after, "c")
    files = study.row_files(tmp_path, print)
    part = study.Part("integrators", 0, tuple(all_four), files, "now")
    files.write(part.name, pd.DataFrame(rows))
    assert not part.done() and set(part._known()) == {"a", "c", "d"}
    assert part._tried(all_four[2], Reach(tmp_path, tmp_path), tmp_path).outcome == "equivalent"


def test_the_table_counts_and_names_what_no_test_found():
    row = {"sample": "integrators", "line": 3, "before": "a < b", "after": "a <= b", "commit": "5b"}
    rows = [
        row | {"file": "galvi/run/loop.py", "outcome": "killed"},
        row | {"file": "galvi/run/status.py", "outcome": "survived"},
        row | {"file": "galvi/method.py", "outcome": "not reached"},
    ]
    table, _ = mutants_table(pd.DataFrame(rows))
    shown = dict(zip(table["where"], table["found"], strict=True))
    assert shown["galvi/run/"] == "1 (50%)" and shown["all: integrators"] == "1 (33%)"
    assert shown["found at: integrators"] == "5b (1)"
    assert shown["galvi/run/status.py:3: a < b  ->  a <= b"] == "survived"

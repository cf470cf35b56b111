"""A problem of one's own in work-precision: settings and truth that are found, and refusals."""

import re
import sys
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.applications.external.loading import ContenderError
from benchmarks.applications.external.own_problems import load_problem
from benchmarks.work_precision import own_problem as own
from benchmarks.work_precision import truths
from benchmarks.work_precision.run import work_precision
from reports.cli.commands import run
from reports.contents import load

ROOT = Path(__file__).parents[3]
BAD = """
import galvi
def raises(): raise RuntimeError("no, thanks")
def alone(): return galvi.problems.kepler(0.3)
def backwards(): return galvi.problems.kepler(0.3), -1.0
def text(): return galvi.problems.kepler(0.3), "long"
def local(): return galvi.Problem(galvi.Canonical(1.0, lambda q: q[0] ** 4), [1.0], [0.0]), 1.0
number = 3
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A place that Python imports from, with the page's problem and some that go wrong."""
    page = (ROOT / "docs" / "suite.md").read_text()
    (example,) = re.findall(r"^```python\n# my_problem\.py\n(.*?)^```$", page, re.M | re.S)
    (tmp_path / "my_problem.py").write_text(example)
    (tmp_path / "bad_problems.py").write_text(BAD)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in ("my_problem", "bad_problems"):
        sys.modules.pop(name, None)


@pytest.fixture
def few(monkeypatch):
    """Fewer participants and less patience."""
    monkeypatch.setattr(own, "FIXED", {"Stormer-Verlet": {}})
    monkeypatch.setattr(own, "OURS", (8,))
    monkeypatch.setattr(own, "PATIENCE", 0.2)


def test_the_pages_problem_is_compared_with_the_codes_that_take_it(folder, few, capsys):
    words = ["compare", "--quick", "--problem", "my_problem:spring", "--out", str(folder / "out")]
    assert run(load, words) == 0, capsys.readouterr().err
    printed = capsys.readouterr().out
    assert "spring: times at matched error" in printed and "SciPy DOP853" in printed
    assert printed.endswith(f"Tables are in {folder / 'out' / 'tables'}.\n")
    rows = pd.read_csv(folder / "out" / "work_precision.csv", keep_default_na=False)
    assert set(rows["problem"]) == {"spring"}
    codes = {"galvi degree 8, Gauss 8", "Stormer-Verlet", "SciPy DOP853"}
    assert set(rows["contender"]) - {"heyoka, Lagrangians"} == codes
    errors = rows["error"].astype(float)
    assert (errors > 0.0).all() and errors.min() < 1e-9 and (rows["seconds"] > 0.0).all()
    assert not rows["status"].str.contains("differenced").any()


@pytest.mark.slow(beside="test_the_pages_problem_is_compared_with_the_codes_that_take_it")
def test_a_force_without_a_gradient_or_a_formula_is_said_to_be_differenced(folder, few):
    from my_problem import gradient, potential

    for function, given in ((potential, gradient), (lambda q: float(potential(q)), None)):
        spring = galvi.Canonical(1.0, function, given)
        case = own.own_problem(galvi.Problem(spring, [1.0, 0.3], [0.0, 0.2]), 5.0, quick=True)
        rows = work_precision(quick=True, cases=(case,))
        said = rows["status"].str.contains(own.DIFFERENCED, regex=False)
        theirs = rows["contender"].isin(own.OF_NEWTON)
        assert theirs.any() and not theirs.all()
        assert (said == (theirs & (given is None))).all()


@pytest.mark.slow(beside="test_the_pages_problem_is_compared_with_the_codes_that_take_it")
def test_steps_are_found_between_a_tenth_of_the_motion_and_the_truth(few):
    pytest.importorskip("rebound")
    problem = galvi.problems.kepler(0.3)
    case = own.own_problem(problem, 20.0)
    truth = case.truth()
    second = "heyoka, quadruple precision|REBOUND IAS15"
    assert re.match(f"Kepler, closed form; by its difference from ({second})$", truth.description)
    assert truth.error < 1e-12 and truth.source == ("Kepler, closed form", "")
    table = work_precision(quick=True, cases=(case,))
    equal = table[
        table["settings"].str.startswith("step=") & ~table["settings"].str.contains("tol")
    ]
    for _, rows in equal.groupby("contender"):
        assert rows["error"].is_monotonic_decreasing and len(rows) > 2
        assert rows["error"].iloc[0] < 0.2
    assert set(table["contender"]) >= {"REBOUND IAS15", "SciPy DOP853", "Stormer-Verlet"}


@pytest.mark.slow(beside="test_without_another_code_there_is_no_truth")
def test_a_truth_with_one_source_is_measured_against_itself(few, monkeypatch):
    only = {"SciPy DOP853": truths.TRUTHS["SciPy DOP853"]}
    monkeypatch.setattr(truths, "TRUTHS", only)
    case = own.own_problem(galvi.problems.henon_heiles(), 5.0, quick=True)
    truth = case.truth()
    assert "by its difference from itself at 30 times" in truth.description
    assert 1e-16 < truth.error < 1e-11


def test_without_another_code_there_is_no_truth():
    def height(q, v):
        return 0.5 * v @ v - 0.1 * q[2, 2]

    group = galvi.Lagrangian(height, galvi.SO3())
    problem = galvi.Problem(group, np.eye(3), [1.0, 0.2, 0.3], name="mine")
    with pytest.raises(ValueError, match=r"mine needs a truth that is not galvi's; received a Lag"):
        own.own_problem(problem, 1.0)


def test_a_problem_that_cannot_be_sent_to_an_integrator_is_a_sentence(folder, capsys):
    words = ["compare", "--problem", "bad_problems:local", "--contender", "mine:Leapfrog"]
    assert run(load, [*words, "--out", str(folder / "out")]) == 2
    error = capsys.readouterr().err
    assert "must be at the top level of their module" in error and error.count("\n") == 1


@pytest.mark.parametrize(
    ("path", "said"),
    [
        ("bad_problems:raises", "it raised RuntimeError: no, thanks"),
        ("bad_problems:alone", "must return a galvi.Problem and its duration; received Problem"),
        ("bad_problems:backwards", "its duration must be"),
        ("bad_problems:text", "its duration must be"),
        ("bad_problems:number", "must be a function; received a int"),
        ("bad_problems:raise", "did you mean 'raises'?"),
        ("bad_problems.raises", "did you mean 'bad_problems:raises'?"),
        ("nowhere:raises", "there is no module 'nowhere'"),
    ],
)
def test_what_is_no_problem_is_a_sentence(folder, path, said, capsys):
    with pytest.raises(ContenderError, match=re.escape(said)):
        load_problem(path)
    assert run(load, ["compare", "--problem", path, "--out", str(folder / "out")]) == 2
    error = capsys.readouterr().err
    assert said in error and error.count("\n") == 1

"""Somebody else's integrator beside ours: the page's example, and every way of going wrong."""

import re
import sys
from dataclasses import replace
from pathlib import Path

import pandas as pd
import pytest

from benchmarks.applications.external.integrator import ExternalIntegrator
from benchmarks.studies import ephemeris
from benchmarks.work_precision import run as work_precision
from benchmarks.work_precision.problems.planets import kepler
from references.jpl import states as jpl
from reports.cli.commands import run
from reports.studies.engines import EPHEMERIS

ROOT = Path(__file__).parents[3]
FEW = ("galvi degree 8, Gauss 8", "Stormer-Verlet")
TROUBLE = """
import numpy as np
import galvi

class Trouble:
    name = "trouble"

    def supports(self, problem):
        return isinstance(problem.system, galvi.Canonical)

    def run(self, problem, duration, setting):
        what = setting.get("samples", 1)
        if what == 2:
            raise RuntimeError("no, thanks")
        if what == 5:
            print("a line that is no part of any table")
            return {"q": 1.0}
        t = problem.t0 + duration * np.arange(what + 1) / what
        q = np.array([problem.q0] * (what + 1))
        p = np.array([problem.p0] * (what + 1))
        return galvi.Trajectory(problem, t, q, p, counts={"steps": what})
"""


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """A place that Python imports from, with the page's example and one that goes wrong."""
    folder = tmp_path_factory.mktemp("outside")
    page = (ROOT / "docs" / "suite.md").read_text()
    (example,) = re.findall(r"^```python\n(# mine\.py\n.*?)^```$", page, re.M | re.S)
    assert len(example.splitlines()) <= 30
    (folder / "mine.py").write_text(example)
    (folder / "trouble.py").write_text(TROUBLE)
    sys.path.insert(0, str(folder))
    yield folder
    sys.path.remove(str(folder))


@pytest.mark.slow(beside="test_what_goes_wrong_is_a_sentence_in_the_table_and_on_the_terminal")
def test_the_example_of_the_page_stands_beside_ours_everywhere(
    folder, make_suite, tmp_path, monkeypatch, capsys
):
    if jpl.missing():
        pytest.skip(jpl.missing())
    case = kepler(1, quick=True)
    few = tuple(one for one in case.participants if one.label in FEW)
    monkeypatch.setattr(
        work_precision, "work_precision_problems", lambda quick: (replace(case, participants=few),)
    )
    monkeypatch.setattr(ephemeris, "displacement", lambda gm, q, v, times: 0.0 * times)
    monkeypatch.setattr("reports.results.own_problems.contender_checks", lambda externals: ())
    base = make_suite(work_precision=work_precision.work_precision)
    suite = replace(base, sections=(*base.sections, EPHEMERIS))
    words = ["build", "--quick", "--contender", "mine:Leapfrog", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 0, capsys.readouterr().err
    rows = pd.read_csv(tmp_path / "work_precision.csv", keep_default_na=False)
    mine = rows[rows["contender"] == "my leapfrog"]
    assert len(mine) == 3 and (mine["status"] == "").all()
    errors, seconds = (mine[name].astype(float).to_numpy() for name in ("error", "seconds"))
    assert (errors[:-1] / errors[1:] > 12.0).all()  # 16 when this was written: order 2, steps / 4
    assert (seconds > 0.0).all() and seconds[2] > 4.0 * seconds[0]
    for table in ("ratios", "choices", "smallest", "ephemeris"):
        assert "my leapfrog" in (tmp_path / "tables" / f"{table}.csv").read_text() or (
            table == "choices"
        )
    assert "my leapfrog" in (tmp_path / "figures" / "work-precision-kepler-e-0-6.svg").read_text()
    assert "my leapfrog" in (tmp_path / "results" / "comparisons.html").read_text()


def test_a_check_of_a_contender_that_was_not_named_says_so(make_suite, tmp_path, capsys):
    words = ["verify", "--claims", "A-my-leapfrog", "--out", str(tmp_path / "out")]
    assert run(make_suite, words) == 2
    told = capsys.readouterr().err
    assert "add it with --contender package.module:Class, or as contenders of [tool.galvi]." in told


def test_what_goes_wrong_is_a_sentence_in_the_table_and_on_the_terminal(
    folder, make_suite, tmp_path, monkeypatch, capsys
):
    case = kepler(1, quick=True)
    few = tuple(one for one in case.participants if one.label in FEW)
    monkeypatch.setattr(
        work_precision, "work_precision_problems", lambda quick: (replace(case, participants=few),)
    )
    monkeypatch.setattr(
        ExternalIntegrator,
        "settings",
        lambda *of: [{"samples": samples} for samples in (2, 5, 1, 2)],
    )
    suite = make_suite(work_precision=work_precision.work_precision)
    words = ["compare", "--quick", "--contender", "trouble:Trouble", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 1
    printed = capsys.readouterr()
    assert (
        "trouble, kepler e=0.6, T = 6.28319, samples=2 and 1 more: "
        "It raised RuntimeError: no, thanks.\n"
    ) in printed.err
    assert "no part of any table" not in printed.out
    rows = pd.read_csv(tmp_path / "work_precision.csv", keep_default_na=False)
    assert set(rows["contender"]) == {*FEW, "trouble"}
    theirs = rows[rows["contender"] == "trouble"]
    assert list(theirs["status"])[:1] == ["It raised RuntimeError: no, thanks."]
    assert theirs["status"].iloc[1].startswith("Its run must return a galvi.Trajectory; received d")
    assert list(theirs["error"] != "") == [False, False, True, False]
    assert (rows[rows["contender"] != "trouble"]["seconds"] != "").all()


def test_a_mistyped_contender_gives_status_2_and_nothing_is_run(
    folder, make_suite, tmp_path, capsys
):
    words = ["compare", "--contender", "mine:Leepfrog", "--out", str(tmp_path / "out")]
    assert run(make_suite, words) == 2
    told = capsys.readouterr().err
    assert "--contender mine:Leepfrog: module mine has no 'Leepfrog'; did you mean 'Leapfrog'" in (
        " ".join(told.split())
    )
    assert len(told.splitlines()) == 1 and not (tmp_path / "out").exists()

"""`galvi convergence`: files, what the terminal shows, exit status and refusals."""

import json
import re
import sys
from pathlib import Path

import pandas as pd
import pytest

import galvi
from reports.cli.commands import run

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "tutorials" / "orders.md"
WORDS = ["convergence", "--quick", "--steps", "200,400,800", "--problem"]
MORE = """
import galvi

midpoint = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1))


def alone():
    return galvi.problems.kepler(0.3)


class Fails:
    name = "fails"

    def supports(self, problem):
        return True

    def run(self, problem, duration, setting):
        raise ZeroDivisionError
"""


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the page's problem and method, from which Python imports."""
    page = PAGE.read_text(encoding="utf-8")
    for name, text in re.findall(
        r'^Path\("(\w+\.py)"\)\.write_text\(\'\'\'(.*?)\'\'\'', page, re.M | re.S
    ):
        (tmp_path / name).write_text(text)
    (tmp_path / "more.py").write_text(MORE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    for name in ("my_problem", "mine", "more"):  # modules of other tests in this process
        monkeypatch.delitem(sys.modules, name, raising=False)
    yield tmp_path
    for name in ("my_problem", "mine", "more"):
        sys.modules.pop(name, None)


def test_tables_a_figure_and_sentences_of_the_pages_paper(folder, capsys):
    methods = ["textbook.rk4", "gauss:2", "scipy.dop853"]
    command = [*WORDS, "my_problem:galaxy", "--contender", "mine:BlanesMoan"]
    command += [word for method in methods for word in ("--method", method)]
    assert run(None, [*command, "--out", "out"]) == 0, capsys.readouterr().err
    printed = capsys.readouterr().out
    written = {path.name for path in Path("out").iterdir()}
    assert "Truth: " in printed and "Blanes-Moan S6: order 4.0" in printed
    tables, widths = ("convergence", "orders"), ("convergence", "convergence-column")
    assert {f"{name}.{form}" for name in tables for form in ("csv", "md", "tex")} <= written
    assert {f"{name}.{form}" for name in widths for form in ("pdf", "svg", "png")} <= written
    fits = pd.read_csv("out/orders.csv").set_index("method")
    assert list(fits.index) == ["RK4", "galvi degree 2, Gauss 2", "Blanes-Moan S6"]
    assert fits["fitted"]["Blanes-Moan S6"] == pytest.approx(4.0, abs=0.1)
    rows = pd.read_csv("out/convergence.csv")
    assert set(rows["method"]) == {*fits.index, "SciPy DOP853"}
    assert r"\label{tab:orders}" in Path("out/orders.tex").read_text()
    caption = Path("out/convergence-caption.tex").read_text()
    assert caption.startswith(r"\caption{Errors of methods on galaxy, T = 20; errors of the state")
    assert 'width="496.8pt"' in Path("out/convergence.svg").read_text()


def test_a_failed_run_is_exit_1_and_its_row_says_why(folder, capsys):
    command = ["convergence", "--quick", "--problem", "more:alone", "--duration", "1", "--steps",
               "5,10", "--contender", "more:Fails", "--method", "gauss:1"]  # fmt: skip
    assert run(None, [*command, "--out", "out"]) == 1
    rows = pd.read_csv("out/convergence.csv")
    failed = rows[rows["outcome"] == "failed"]
    assert set(failed["method"]) == {"fails"} and failed["note"].str.contains("ZeroDivision").all()


def test_python_gets_what_the_command_writes_of_ones_own_method_and_a_given_truth(
    folder, capsys, suite_in_this_process
):
    command = ["convergence", "--quick", "--problem", "more:alone", "--duration", "2.0", "--steps",
               "0.1,0.05,0.025", "--method", "more:midpoint", "--truth", "scipy.dop853", "--out",
               "out"]  # fmt: skip
    assert run(None, command) == 0, capsys.readouterr().err
    assert "SciPy DOP853" in capsys.readouterr().out
    fits = pd.read_csv("out/orders.csv")
    assert fits["fitted"][0] == pytest.approx(2.0, abs=0.1) and fits["method"][0] == "midpoint"
    midpoint = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1))
    table = galvi.convergence(
        galvi.problems.kepler(0.3),
        {"midpoint": midpoint},
        [0.1, 0.05, 0.025],
        2.0,
        truth="scipy.dop853",
        quick=True,
    )
    rows = pd.read_csv("out/convergence.csv")
    assert list(rows["error"]) == list(table["error"]) and list(rows) == list(table)
    assert json.loads(json.dumps(table.attrs))["truth"] == table.attrs["truth"]

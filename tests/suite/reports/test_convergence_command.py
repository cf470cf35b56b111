"""`galvi convergence`: files, what the terminal shows, exit status and refusals."""

import json
import re
import sys
from pathlib import Path

import pandas as pd
import pytest

from reports.cli.commands import run

ROOT = Path(__file__).parents[3]
PAGE = ROOT / "docs" / "tutorials" / "orders.md"
WORDS = ["convergence", "--quick", "--steps", "200,400,800", "--problem"]
MORE = """
import galvi

midpoint = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1))
number = 3


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
    for name, text in re.findall(r'^Path\("(\w+\.py)"\)\.write_text\(\'\'\'(.*?)\'\'\'', page,
                                 re.M | re.S):  # fmt: skip
        (tmp_path / name).write_text(text)
    (tmp_path / "more.py").write_text(MORE)
    monkeypatch.chdir(tmp_path)
    monkeypatch.syspath_prepend(str(tmp_path))
    yield tmp_path
    for name in ("my_problem", "mine", "more"):
        sys.modules.pop(name, None)


@pytest.fixture
def papers(folder, capsys):
    """What the page's command prints, and the folder with what it wrote."""
    methods = ["textbook.rk4", "gauss:2", "scipy.dop853"]
    words = [*WORDS, "my_problem:galaxy", "--contender", "mine:BlanesMoan"]
    words += [word for method in methods for word in ("--method", method)]
    assert run(None, [*words, "--out", "out"]) == 0, capsys.readouterr().err
    return capsys.readouterr().out, folder


def test_tables_a_figure_and_sentences_of_the_pages_paper(papers):
    printed, folder = papers
    assert "Truth: " in printed and "Blanes-Moan S6: order 4.0" in printed
    for name in ("convergence", "orders"):
        assert {f"{name}.{form}" for form in ("csv", "md", "tex")} <= set(names(folder))
    assert {f"convergence{width}.{form}" for width in ("", "-column") for form in
            ("pdf", "svg", "png")} <= set(names(folder))  # fmt: skip
    fits = pd.read_csv("out/orders.csv").set_index("method")
    assert list(fits.index) == ["RK4", "galvi degree 2, Gauss 2", "Blanes-Moan S6"]
    assert fits["fitted"]["Blanes-Moan S6"] == pytest.approx(4.0, abs=0.1)
    rows = pd.read_csv("out/convergence.csv")
    assert set(rows["method"]) == {*fits.index, "SciPy DOP853"}
    latex = Path("out/orders.tex").read_text()
    assert r"\label{tab:orders}" in latex and r"\begin{tabularx}{\linewidth}{" in latex
    caption = Path("out/convergence-caption.tex").read_text()
    assert caption.startswith(r"\caption{Errors of methods on galaxy, T = 20; errors of the state")
    assert r"\label{fig:convergence}" in caption and "function" not in caption
    svg = Path("out/convergence.svg").read_text()
    assert svg.count("<svg") == 1 and 'width="496.8pt"' in svg


def names(folder):
    return [path.name for path in (folder / "out").iterdir()]


def test_a_method_of_ones_own_module_a_duration_and_a_given_truth(folder, capsys):
    words = ["convergence", "--quick", "--problem", "more:alone", "--duration", "2.0",
             "--steps", "0.1,0.05,0.025", "--method", "more:midpoint", "--truth", "scipy.dop853",
             "--out", "out"]  # fmt: skip
    assert run(None, words) == 0, capsys.readouterr().err
    fits = pd.read_csv("out/orders.csv")
    assert fits["fitted"][0] == pytest.approx(2.0, abs=0.1) and fits["method"][0] == "midpoint"
    assert "SciPy DOP853" in capsys.readouterr().out


def test_a_failed_run_is_exit_1_and_its_row_says_why(folder, capsys):
    words = [*WORDS, "my_problem:galaxy", "--contender", "more:Fails", "--method", "gauss:1"]
    assert run(None, [*words, "--out", "out"]) == 1
    rows = pd.read_csv("out/convergence.csv")
    failed = rows[rows["outcome"] == "failed"]
    assert set(failed["method"]) == {"fails"} and failed["note"].str.contains("ZeroDivision").all()


@pytest.mark.parametrize(
    ("words", "says"),
    [
        ([], "--problem package.module:function"),
        (["--problem", "more:alone"], "duration"),
        (["--problem", "more:number"], "must be a function"),
        (
            ["--problem", "more:alone", "--duration", "1", "--steps", "2,x"],
            "'--steps': Expected numbers",
        ),
        (["--problem", "more:alone", "--duration", "1", "--method", "gauss:x"], "gauss:DEGREE"),
        (["--problem", "more:alone", "--duration", "1", "--method", "more:number"], "Galerkin"),
        (["--problem", "more:alone", "--duration", "1", "--method", "mujoco.rk4"], "mujoco.rk4"),
        (["--problem", "more:alone", "--duration", "1", "--contender", "more:Absent"], "Absent"),
        (["--problem", "more:alone", "--duration", "-1"], "duration must be positive"),
    ],
)
def test_what_cannot_be_asked_is_a_sentence_and_exit_2(folder, capsys, words, says):
    assert run(None, ["convergence", *words, "--out", "out"]) == 2
    said = [line for line in capsys.readouterr().err.splitlines() if line[:12] != "convergence:"]
    assert len(said) == 1 and says in said[0] and said[0][-1] in ".?"
    assert not list(folder.glob("out/*.csv"))


def test_two_methods_of_one_name_are_refused(folder, capsys):
    text = "from mine import BlanesMoan\nclass Twin(BlanesMoan): pass\n"
    Path("twins.py").write_text(text)
    words = [*WORDS, "my_problem:galaxy", "--contender", "mine:BlanesMoan"]
    assert run(None, [*words, "--contender", "twins:Twin", "--out", "out"]) == 2
    assert "wo methods are called 'Blanes-Moan S6'" in capsys.readouterr().err


def test_a_file_named_as_a_request_is_never_loaded(folder, capsys):
    Path("request").write_bytes(b"cos\nsystem\n(S'touch trace'\ntR.")
    words = ["convergence", "--request", "request", "--out", "out"]
    assert run(None, words) == 2
    assert "galvi.convergence" in capsys.readouterr().err and not Path("trace").exists()


def test_python_gets_what_the_command_writes(folder, suite_in_this_process):
    import galvi

    frame = galvi.convergence(galvi.problems.kepler(0.3), {"RK4": "textbook.rk4"}, [100, 200], 5.0,
                              quick=True)  # fmt: skip
    words = ["convergence", "--quick", "--problem", "more:alone", "--duration", "5", "--steps",
             "100,200", "--method", "textbook.rk4", "--out", "out"]  # fmt: skip
    assert run(None, words) == 0
    rows = pd.read_csv("out/convergence.csv")
    assert list(rows["error"]) == list(frame["error"]) and list(rows) == list(frame)
    assert json.loads(json.dumps(frame.attrs))["truth"] == frame.attrs["truth"]

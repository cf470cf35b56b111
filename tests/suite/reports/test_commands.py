"""The command line: exit statuses, what is written, one sentence for what was mistyped."""

import json
import platform
import subprocess
import sys
from itertools import product
from pathlib import Path
from types import SimpleNamespace

import numba
import numpy as np
import pandas as pd
import pytest
from joblib import Parallel

import galvi
from galvi.charts import CHARTS
from galvi.command import called, main
from galvi.interop.release import galvi_version
from galvi.lanes import vectors
from reports.build.warm import run_all
from reports.cli.commands import run
from reports.cli.options import output_folder

ROOT = Path(__file__).parents[3]


def test_verify_exits_0_when_every_verdict_is_the_expected_one(make_suite, tmp_path, capsys):
    assert run(make_suite, ["verify", "--out", str(tmp_path)]) == 0
    printed = capsys.readouterr()
    assert "1 claim in 1 check: 1 holds; every verdict is the expected one." in printed.out
    assert printed.err.startswith("[1/1] V1 title of V1: ")
    assert len(printed.err.splitlines()) == 1


def test_verify_exits_1_when_a_verdict_differs(make_suite, make_claim, make_row, tmp_path, capsys):
    wrong = make_claim("V1", (make_row(verdict="contradicted"), make_row()))
    assert run(lambda: make_suite(wrong), ["verify", "--out", str(tmp_path)]) == 1
    assert "1 differs from what was expected (V1)." in capsys.readouterr().out


def test_an_expected_contradiction_is_a_success(make_suite, make_claim, make_row, tmp_path):
    false = make_claim("V1", (make_row(verdict="contradicted", expected="contradicted"),))
    assert run(lambda: make_suite(false), ["verify", "--out", str(tmp_path)]) == 0


def test_a_study_that_raises_spoils_its_own_claim_only(make_suite, make_claim, tmp_path, capsys):
    broken = make_claim("V1", raises=RuntimeError("no engine here"))
    suite = make_suite(broken, make_claim("V2"))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1
    rows = pd.read_csv(tmp_path / "claims.csv", keep_default_na=False)
    assert list(rows["verdict"]) == ["not run", "holds"]
    assert list(rows["measured"]) == ["", "0.25"]
    assert rows["reason"][0] == "RuntimeError: no engine here"
    assert list(rows["expected"]) == ["holds", "holds"]
    assert "V1 base of the error was not run: RuntimeError: no engine" in capsys.readouterr().out


def test_a_row_that_was_not_run_is_listed_and_not_green(
    make_suite, make_claim, make_row, tmp_path, capsys
):
    absent = make_row(verdict="not run", measured=float("nan"), reason="REBOUND is not installed.")
    suite = make_suite(make_claim("V1", (absent,)))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 1
    printed = capsys.readouterr().out
    assert "was not run: There are too few numbers to judge by. Expected was holds:" in printed
    assert "REBOUND is not installed." in printed.replace("\n", " ")
    assert "nan" not in printed


def test_only_the_chosen_claims_run(make_suite, make_claim, tmp_path):
    suite = make_suite(*(make_claim(name) for name in ("V1", "V2", "V3")))
    assert run(lambda: suite, ["verify", "--claims", "V3,V1", "--out", str(tmp_path)]) == 0
    assert list(pd.read_csv(tmp_path / "claims.csv")["id"]) == ["V1", "V3"]


def test_compare_writes_both_tables_and_their_origin(make_suite, tmp_path):
    assert run(make_suite, ["compare", "--quick", "--out", str(tmp_path)]) == 0
    assert len(pd.read_csv(tmp_path / "work_precision.csv")) == 6
    assert len(pd.read_csv(tmp_path / "cost.csv")) == 2
    origins = json.loads((tmp_path / "provenance.json").read_text())
    assert len(pd.read_csv(tmp_path / "sky_and_model.csv")) == 2
    assert set(origins) == {"work_precision.csv", "cost.csv", "sky_and_model.csv"}
    assert origins["cost.csv"]["setting"] == "quick"
    assert origins["cost.csv"]["command"].startswith("python -m reports compare --quick")


def test_only_the_chosen_problems_are_compared(make_suite, tmp_path, capsys):
    asked = []

    def work_precision(quick, report, problem):
        asked.append(problem)
        return make_suite().work_precision(quick, report)

    def cost(quick, report, only):
        asked.append(tuple(only))
        return make_suite().cost(quick, report)

    suite = make_suite(
        work_precision=work_precision, cost=cost, problems=lambda quick: ("top", "kepler", "five")
    )
    words = ["compare", "--only", "Kep, fiv", "--out", str(tmp_path)]
    assert run(lambda: suite, words) == 0
    assert asked == ["kepler", "five", ("kepler", "five")]
    assert not (tmp_path / "sky_and_model.csv").exists()
    assert run(lambda: suite, ["compare", "--only", "topp", "--out", str(tmp_path)]) == 2
    assert "there is no problem 'topp' to compare on; did you mean 'top'" in " ".join(
        capsys.readouterr().err.split()
    )


def test_a_comparison_that_raises_is_named_and_leaves_the_other(make_suite, tmp_path, capsys):
    def broken(quick, report):
        raise ValueError("the clock stopped")

    suite = make_suite(work_precision=broken)
    assert run(lambda: suite, ["compare", "--out", str(tmp_path)]) == 1
    assert "work-precision: not run (ValueError: the clock stopped)." in capsys.readouterr().err
    assert (tmp_path / "cost.csv").exists()
    assert not (tmp_path / "work_precision.csv").exists()


@pytest.mark.slow(beside="test_compare_writes_both_tables_and_their_origin")
def test_no_command_means_build(make_suite, tmp_path):
    assert run(make_suite, ["--out", str(tmp_path)]) == 0
    for name in ("claims.csv", "work_precision.csv", "cost.csv", "provenance.json", "index.html"):
        assert (tmp_path / name).stat().st_size > 0
    for table in ("claims", "convergence", "ratios", "choices", "cost", "sky_and_model"):
        for kind in ("csv", "md", "tex"):
            assert (tmp_path / "tables" / f"{table}.{kind}").stat().st_size > 0
    for kind in ("svg", "png"):
        assert (tmp_path / "figures" / f"fig-2-03.{kind}").stat().st_size > 0
    assert (tmp_path / "frames" / "V1.csv").exists()


@pytest.mark.parametrize(
    ("words", "sentence"),
    [
        (["vrify"], "No such command 'vrify'. Did you mean 'verify'?"),
        (["zzz"], "No such command 'zzz'."),
        (["verify", "--qick"], "No such option: --qick (Possible options: --quick)."),
        (["--qick"], "No such option: --qick (Possible options: --quick)."),
        (["verify", "--xyz"], "No such option: --xyz."),
        (["verify", "--claims", "V33"], "There is no claim or place 'V33'; did you mean 'V3'?"),
        (["build", "--claims", "W1,V3"], "There is no claim or place 'W1'; did you mean '"),
        (["--quick", "verify"], "Options follow the command, as in: python -m reports verify --q"),
        (["verify", "--claims", ","], "Invalid value for '--claims': Expected words, separated by"),
        (["verify", "--timeout", "x"], "Invalid value for '--timeout': Input should be a valid nu"),
        (["verify", "--timeout", "0"], "Invalid value for '--timeout': Input should be greater"),
        (
            ["verify", "--require", "reboun"],
            "There is no engine 'reboun' among rebound; did you mean",
        ),
        (["judge"], "Missing argument 'FILE'."),
    ],
)
def test_a_mistyped_word_gives_status_2_and_a_sentence(
    make_suite, make_claim, tmp_path, monkeypatch, capsys, words, sentence
):
    monkeypatch.chdir(tmp_path)
    suite = make_suite(make_claim("V1"), make_claim("V3"), engines=lambda: {"rebound": ""})
    assert run(lambda: suite, words) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    (line,) = printed.err.splitlines()
    assert line.startswith(sentence)
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "words",
    [
        ["verify", "--out"],
        ["verify", "x"],
        ["export"],
        ["verify", "--quick=yes"],
        ["--out", "x", "y"],
    ],
)
def test_other_misuse_gives_status_2_and_one_sentence(make_suite, words, capsys):
    assert run(make_suite, words) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert line[0].isupper() or line.startswith(words[0])
    assert line.endswith(".")


def test_an_interrupt_has_a_status_and_a_sentence(make_suite, make_claim, tmp_path, capsys):
    suite = make_suite(make_claim("V1", raises=KeyboardInterrupt()))
    assert run(lambda: suite, ["verify", "--out", str(tmp_path)]) == 130
    assert "Interrupted; the files that were written are whole." in capsys.readouterr().err


def test_an_out_that_is_a_file_is_refused(make_suite, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    assert run(make_suite, ["verify", "--out", str(tmp_path / "file")]) == 2
    assert (tmp_path / "file").read_text() == "mine"


def test_an_out_that_is_a_link_to_nothing_is_refused(make_suite, tmp_path, capsys):
    (tmp_path / "link").symlink_to("nothing")
    assert run(make_suite, ["verify", "--out", str(tmp_path / "link")]) == 2
    assert capsys.readouterr().err == (
        f"--out expects a folder to write in; received {tmp_path / 'link'}: File exists.\n"
    )
    assert not (tmp_path / "nothing").exists()


def test_the_version_is_shown_with_those_that_results_depend_on(make_suite, capsys):
    assert run(make_suite, ["--version"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"galvi {galvi_version()}"
    assert second.split() == [
        "Python", f"{platform.python_version()},", "numpy", f"{np.__version__},", "numba",
        numba.__version__,
    ]  # fmt: skip


def test_the_version_is_shown_before_anything_large_is_imported():
    code = (
        "import sys\nfrom reports.cli.commands import run\nstatus = run(None, ['--version'])\n"
        "print(status, [name for name in ('pandas', 'matplotlib', 'mujoco', 'rebound', 'sympy', "
        "'reports.contents') if name in sys.modules])"
    )
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.stdout.splitlines()[-1] == "0 []", done.stderr


def test_a_claim_that_is_not_there_names_the_nearest_and_not_all(make_suite, make_claim, capsys):
    suite = make_suite(*(make_claim(f"V{n}") for n in range(1, 100)))
    assert run(lambda: suite, ["verify", "--claims", "V333"]) == 2
    assert capsys.readouterr().err == "There is no claim or place 'V333'; did you mean 'V33'?\n"
    assert run(lambda: suite, ["verify", "--claims", "contenders"]) == 2
    assert "add it with --contender package.module:Class, or as conten" in capsys.readouterr().err


@pytest.mark.parametrize("place", ["M 6.2, fig. 3 right", "M fig. 3 right", "M fig. 3 right,V1"])
def test_a_place_stands_for_the_claims_of_what_is_printed_there(
    make_suite, make_claim, tmp_path, place
):
    suite = make_suite(*map(make_claim, ("V1", "V23", "V24")))
    assert run(lambda: suite, ["verify", "--claims", place, "--out", str(tmp_path)]) == 0
    measured = set(pd.read_csv(tmp_path / "claims.csv")["id"])
    assert measured == {"V24", "V1"} if "V1" in place else measured == {"V24"}


@pytest.mark.parametrize(
    ("place", "told"),
    [
        ("H fig 3.5", "There is no claim or place 'H fig 3.5'; did you mean 'H fig. 3.5'?"),
        ("H (2.4)", "No claim checks what is printed at 'H (2.4)' (false as printed: The left "),
    ],
)
def test_a_place_without_a_claim_says_why(make_suite, make_claim, capsys, place, told):
    assert run(lambda: make_suite(make_claim("V1")), ["verify", "--claims", place]) == 2
    assert told in capsys.readouterr().err


@pytest.mark.slow(beside="test_the_command_is_run_under_the_name_by_which_it_was_called")
def test_the_module_is_the_command_and_help_names_what_was_called():
    command = [sys.executable, "-m", "galvi", "--help"]
    help = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert help.returncode == 0 and help.stdout.startswith("Usage: python -m galvi ")
    assert called("/somewhere/bin/galvi") == ["galvi"]
    for word in ("verify", "compare", "build", "Without a command"):
        assert word in help.stdout


def test_the_command_is_run_under_the_name_by_which_it_was_called(monkeypatch):
    asked = []
    monkeypatch.setattr(sys, "argv", ["/somewhere/bin/galvi-2", "verify"])
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr("runpy.run_module", lambda *given, **options: asked.append(given))
    assert main() == 0
    assert asked == [("reports", {"CALLED": ["galvi-2"]}, "__main__")]


def test_warm_compiles_for_every_problem_and_says_how_far_it_is(make_suite, monkeypatch, capsys):
    done = []
    monkeypatch.setattr("reports.build.warm.run_all", done.append)
    monkeypatch.setattr(
        "reports.build.warm.parallel", lambda processes, **options: Parallel(1, **options)
    )
    assert run(make_suite, ["warm"]) == 0
    said = capsys.readouterr().out.splitlines()
    assert len(said) == len(galvi.problems.__all__) + 3
    assert said[0].startswith(f"1 of {len(said) - 1}: ")
    assert all(any(f": {name}, " in line for line in said) for name in galvi.problems.__all__)
    assert len(done) > len(said) and "took" in said[-1]  # planets in the plane, too


@pytest.mark.parametrize("widest", [False, True])
def test_warm_runs_all_kinds_of_vectors_in_each_chart(monkeypatch, widest):
    """The law of a group has code for one vector of stages and for several, of each length."""
    asked = set()

    def integrate(problem, method, step, steps, solver):
        lanes = vectors.lanes_for(method.stages)
        asked.add((method.group_chart, solver, lanes, method.stages > lanes))
        return SimpleNamespace(t=[0.0], status="Completed.")

    monkeypatch.setattr(galvi, "integrate", integrate)
    monkeypatch.setattr(galvi, "energy", lambda *given: None)
    monkeypatch.setattr(vectors, "AVX512", widest)
    run_all(galvi.problems.free_rigid_body())
    lengths = {8} if widest else {4, 8}
    assert asked == set(product(CHARTS, ("auto", "newton"), lengths, (False, True)))


def test_what_is_written_in_another_project_is_ignored_by_its_git(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output_folder(Path("galvi-out/judge"))
    assert (tmp_path / "galvi-out" / ".gitignore").read_text() == "*\n"
    output_folder(tmp_path / "elsewhere")
    assert not list((tmp_path / "elsewhere").iterdir())

"""The command line: files and output, exit statuses, and ends of commands that cannot be carried
out."""

from __future__ import annotations

import errno
import json
import os
import platform
import re
import signal
import subprocess
import sys
from itertools import product
from pathlib import Path
from threading import Timer
from types import SimpleNamespace

import numba
import numpy as np
import pandas as pd
import pytest
import typer
from joblib import Parallel

import galvi
from galvi.charts import CHARTS
from galvi.command import called, main
from galvi.interop.release import galvi_version
from galvi.lanes import vectors
from reports.build.warm import run_all
from reports.cli.commands import run
from reports.cli.options import output_folder
from tests.suite.reports.small_reports import suite_of

ROOT = Path(__file__).parents[3]
ENGINES = {"mujoco", "sympy", "dask", "distributed", "jplephem", "xarray", "heyoka"}
SHOWN = {"pandas", "matplotlib", "jinja2", "rebound", "scipy.optimize"}


def test_compare_writes_both_tables_and_their_origin(ask):
    assert ask("compare --quick --out out").status == 0
    origins = json.loads(Path("out/provenance.json").read_text())
    lengths = {"work_precision.csv": 6, "cost.csv": 2, "sky_and_model.csv": 2}
    assert {name: len(pd.read_csv(Path("out") / name)) for name in lengths} == lengths
    assert set(origins) == set(lengths) and origins["cost.csv"]["setting"] == "quick"
    assert origins["cost.csv"]["command"].startswith("galvi compare --quick")


def test_only_the_chosen_problems_are_compared(ask):
    problems = []

    def work_precision(quick, report, problem):
        problems.append(problem)
        return suite_of().work_precision(quick, report)

    def cost(quick, report, only):
        problems.append(tuple(only))
        return suite_of().cost(quick, report)

    suite = suite_of(
        work_precision=work_precision, cost=cost, problems=lambda quick: ("top", "kepler", "five")
    )
    assert ask("compare --only 'Kep, fiv'", suite).status == 0
    assert problems == ["kepler", "five", ("kepler", "five")]
    assert not Path("out/sky_and_model.csv").exists()


def test_a_comparison_that_raises_is_named_and_leaves_the_other(ask):
    def broken(quick, report):
        raise ValueError("the clock stopped")

    completed = ask("compare", suite_of(work_precision=broken))
    assert completed.status == 1
    assert "work-precision: not run (ValueError: the clock stopped)." in completed.err
    assert Path("out/cost.csv").exists() and not Path("out/work_precision.csv").exists()


def test_the_version_is_shown_with_those_that_results_depend_on(capsys):
    assert run(None, ["--version"]) == 0
    first, second = capsys.readouterr().out.splitlines()
    assert first == f"galvi {galvi_version()}"
    python, numpy = platform.python_version(), np.__version__
    assert second == f"Python {python}, numpy {numpy}, numba {numba.__version__}"


@pytest.mark.slow_cases(but=["verify --clams V1-2-without1"])
@pytest.mark.parametrize(
    ("arguments", "status", "without"),
    [
        ("--help", 0, ENGINES | SHOWN),
        ("verify --clams V1", 2, ENGINES | SHOWN),
        ("--version", 0, ENGINES | SHOWN),
        ("track --against nosuch", 2, ENGINES | {"rebound"}),
        ("export nosuch", 2, ENGINES | {"rebound"}),
        ("verify --claims X9", 2, ENGINES | {"rebound"}),
        ("judge /nosuch.bin", 2, ENGINES),
    ],
)
def test_what_is_refused_is_refused_before_engines_are_loaded(arguments, status, without):
    code = f"""
import sys
from galvi import command
sys.argv = ["galvi", *{arguments.split()}]
try:
    status = command.main()
except SystemExit as ended:
    status = ended.code
print("status", status, *sys.modules)
"""
    completed = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    last = completed.stdout.splitlines()[-1].split()
    assert last[:2] == ["status", str(status)], completed.stderr
    assert not without & set(last[2:]) and "Traceback" not in completed.stderr


@pytest.mark.slow(beside="test_the_command_is_run_under_the_name_by_which_it_was_called")
def test_the_module_is_the_command_and_help_names_what_was_called():
    command = [sys.executable, "-m", "galvi", "--help"]
    completed = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    assert completed.returncode == 0 and completed.stdout.startswith("Usage: python -m galvi ")
    for word in ("verify", "compare", "build", "Without a command"):
        assert word in completed.stdout


def test_the_command_is_run_under_the_name_by_which_it_was_called(monkeypatch):
    calls = []
    monkeypatch.setattr(sys, "argv", ["/somewhere/bin/galvi-2", "verify"])
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr("runpy.run_module", lambda *arguments, **options: calls.append(arguments))
    assert main() == 0
    assert calls == [("reports", {"CALLED": ["galvi-2"]}, "__main__")]
    assert called("/somewhere/bin/galvi") == ["galvi"]


def test_warm_compiles_for_every_problem_and_says_how_far_it_is(monkeypatch, capsys):
    warmed = []
    monkeypatch.setattr("reports.build.warm.run_all", warmed.append)
    monkeypatch.setattr(
        "reports.build.warm.parallel", lambda processes, **options: Parallel(1, **options)
    )
    assert run(None, ["warm"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert lines[0].startswith(f"1 of {len(lines) - 1}: ")
    assert all(any(f": {name}, " in line for line in lines) for name in galvi.problems.__all__)
    assert len(warmed) > len(lines) and "took" in lines[-1]  # planets in the plane, too


@pytest.mark.parametrize("widest", [False, True])
def test_warm_runs_all_kinds_of_vectors_in_each_chart(monkeypatch, widest):
    """The force law of a group has code for one and for several vectors of stages."""
    runs = set()

    def integrate(problem, method, step, steps, solver):
        lanes = vectors.lanes_for(method.stages)
        runs.add((method.group_chart, solver, lanes, method.stages > lanes))
        return SimpleNamespace(t=[0.0], status="Completed.")

    monkeypatch.setattr(galvi, "integrate", integrate)
    monkeypatch.setattr(galvi, "energy", lambda *_: None)
    monkeypatch.setattr(vectors, "AVX512", widest)
    run_all(galvi.problems.free_rigid_body())
    lengths = {8} if widest else {4, 8}
    assert runs == set(product(CHARTS, ("auto", "newton"), lengths, (False, True)))


def test_what_is_written_in_another_project_is_ignored_by_its_git(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    output_folder(Path("galvi-out/judge"))
    assert (tmp_path / "galvi-out" / ".gitignore").read_text() == "*\n"
    output_folder(tmp_path / "elsewhere")
    assert not list((tmp_path / "elsewhere").iterdir())


# An exception that no code caught is no verdict: status 2 and one sentence, whatever it is.


class Wordless(Exception):
    def __str__(self):
        raise RuntimeError("no words")


CANNOT = "The command could not be carried out: "
RAISED = (
    (Wordless(), 2, f"{CANNOT}.*Wordless"),
    (ImportError("numpy.dtype size changed"), 2, f"{CANNOT}ImportError"),
    (RuntimeError("two\nlines"), 2, f"{CANNOT}RuntimeError"),
    (KeyError("samples"), 2, f"{CANNOT}KeyError"),
    (MemoryError(), 2, f"{CANNOT}MemoryError"),
    (BrokenPipeError(errno.EPIPE, "of a worker"), 2, f"{CANNOT}BrokenPipeError"),
    (SystemExit(0), 2, f"{CANNOT}SystemExit"),
    (ValueError("red \x1b[31m"), 2, r"ValueError: red \\x1b\[31m\."),
    (
        ModuleNotFoundError("No module named 'pebble'", name="pebble"),
        3,
        r"pebble is not installed. Install them: pip install 'galvi\[suite\]'\.",
    ),
    (typer.Abort(), 130, "Interrupted"),
)


def raising(error):
    def load(*_, **options):
        raise error

    return load


@pytest.mark.parametrize(
    ("error", "status", "pattern"), RAISED, ids=[type(error).__name__ for error, _, _ in RAISED]
)
def test_what_nobody_caught_is_no_verdict(error, status, pattern, tmp_path, capsys):
    assert run(raising(error), ["verify", "--out", str(tmp_path)]) == status
    (line,) = capsys.readouterr().err.splitlines()
    assert re.search(pattern, line)


def test_a_full_disk_is_named(ask, monkeypatch):
    full = OSError(errno.ENOSPC, "No space left on device", "claims.csv")
    monkeypatch.setattr("reports.build.verify.write", raising(full))
    completed = ask("verify")
    assert completed.status == 2 and "No space left on device: 'claims.csv'. " in completed.err


def test_what_cannot_be_imported_is_no_verdict(monkeypatch, capsys):
    monkeypatch.setattr(sys, "path", list(sys.path))
    monkeypatch.setattr("runpy.run_module", raising(ImportError("undefined symbol: x")))
    assert main() == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "cannot be imported: undefined symbol: x." in line


def test_the_command_without_the_suite_says_what_to_install():
    code = (
        "import sys; sys.modules['typer'] = None\n"
        "from galvi.command import main\n"
        "sys.argv = ['galvi', 'verify']\n"
        "sys.exit(main())\n"
    )
    completed = subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True
    )
    assert completed.returncode == 3 and "pip install 'galvi[suite]'" in completed.stderr


@pytest.mark.usefixtures("interruptible")
def test_an_interrupt_during_a_run_of_galvi_ends_the_command(ask):
    orbit = galvi.problems.kepler(0.6)
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    galvi.integrate(orbit, method, 0.1, 1)  # compiles the kernel

    def cost(quick, report):
        Timer(0.3, os.kill, [os.getpid(), signal.SIGINT]).start()
        run = galvi.integrate(orbit, method, 0.1, 10**8, save_every=10**6)
        return pd.DataFrame({"status": [run.status]})

    handler = signal.getsignal(signal.SIGINT)
    assert ask("compare", suite_of(cost=cost)).status == 130
    assert signal.getsignal(signal.SIGINT) is handler
    assert not Path("out/cost.csv").exists()


def test_where_it_was_raised_is_shown_where_asked_for(tmp_path, monkeypatch, capsys):
    monkeypatch.setenv("GALVI_TRACEBACK", "1")
    assert run(raising(KeyError("samples")), ["verify", "--out", str(tmp_path)]) == 2
    *lines, last = capsys.readouterr().err.splitlines()
    assert lines[0].startswith("Traceback") and any("in load" in line for line in lines)
    assert last.startswith("The command could not be carried out: KeyError: 'samples'.")


def ended(action, environment=None, **streams):
    """The completed process of a command that runs the line `action`."""
    code = (
        "import sys\nfrom reports.cli.endings import ended\n"
        f"def command():\n    {action}\n    return 0\nsys.exit(ended(command))"
    )
    streams = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE} | streams
    variables = os.environ | {"PYTHONUNBUFFERED": ""} | (environment or {})
    return subprocess.run(
        [sys.executable, "-c", code], cwd=ROOT, text=True, env=variables, **streams
    )


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="no device that is always full")
def test_standard_output_that_is_full_is_a_full_disk():
    with open("/dev/full", "w") as full:
        completed = ended("print('a verdict')", stdout=full)
    assert completed.returncode == 2
    (line,) = completed.stderr.splitlines()
    assert "OSError: [Errno 28] No space left on device. " in line


PRINTS = "print('a line\\n' * 10_000, file=sys.{})"
RICH = "from rich.console import Console; Console().print('a')"


@pytest.mark.parametrize(
    ("action", "stream", "unbuffered"),
    [
        (PRINTS, "stdout", ""),
        (PRINTS, "stdout", "1"),
        (PRINTS, "stderr", ""),
        (RICH, "stdout", ""),
    ],
)
def test_output_that_nobody_reads_ends_a_command_quietly(action, stream, unbuffered):
    reader, writer = os.pipe()
    os.close(reader)
    with open(writer, "w") as gone:
        completed = ended(action.format(stream), {"PYTHONUNBUFFERED": unbuffered}, **{stream: gone})
    assert completed.returncode == 141 and not (completed.stdout or completed.stderr)


def test_characters_that_the_output_lacks_are_replaced():
    completed = ended("print('error at 1\\u2026 \\udcff')", {"PYTHONIOENCODING": "ascii"})
    assert (completed.returncode, completed.stdout, completed.stderr) == (0, "error at 1? ?\n", "")

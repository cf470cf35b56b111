"""Compilation of kernels: the notice to the user, runs with plain numba, and imports of numba."""

from __future__ import annotations

import importlib
import inspect
import logging
import os
import re
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from galvi.kernels.compile.watching import LEAST_REPORTED_SECONDS, LOG, SECONDS, CompilationNotice
from galvi.kernels.lie import product

ROOT = Path(__file__).parents[2]
FIRST, SECOND, *_ = SECONDS


def report_compilations(notice, *nested):
    """Sends the events of numba to ``notice`` as for functions each of which calls the next."""
    for name in nested:
        module, _, function = name.rpartition(".")
        dispatcher = getattr(importlib.import_module(module), function)
        notice.on_start(SimpleNamespace(data={"dispatcher": dispatcher}))
    for _ in nested:
        notice.on_end(None)


@pytest.mark.parametrize("name", SECONDS)
def test_a_kernel_that_is_compiled_is_announced_once_with_how_long_it_takes(name, caplog):
    notice = CompilationNotice()
    report_compilations(notice, name), report_compilations(notice, name)
    (record,) = caplog.records
    assert record.name == "galvi" and record.levelno == logging.WARNING
    assert f"about {SECONDS[name]} s of processor time, once" in record.getMessage()


def test_what_is_compiled_within_another_or_in_no_time_is_not_announced(caplog):
    notice = CompilationNotice()
    report_compilations(notice, "galvi.kernels.nystrom.step.copy_into")
    report_compilations(notice, FIRST, SECOND)
    notice.on_start(SimpleNamespace(data={"seconds": 0.9 * LEAST_REPORTED_SECONDS}))
    notice.on_start(SimpleNamespace(data={"seconds": 17.0}))
    assert len(caplog.records) == 2
    assert "the law of this system: about 17 s of processor time, once" in caplog.messages[-1]
    report_compilations(notice, SECOND)
    assert len(caplog.records) == 3


def test_the_notice_goes_to_stderr_and_can_be_silenced(caplog, capsys, monkeypatch):
    monkeypatch.setattr(logging.root, "handlers", [])
    report_compilations(CompilationNotice(), FIRST)
    stderr = capsys.readouterr().err
    assert stderr.startswith("galvi is compiling a kernel") and stderr.count("\n") == 1
    with caplog.at_level("ERROR", logger=LOG.name):
        report_compilations(CompilationNotice(), FIRST)
    assert capsys.readouterr().err == ""


def test_numba_finds_a_function_where_generated_code_says_that_its_source_is() -> None:
    """With the source in a docstring, Python 3.13 raised TokenError in the first run on a group."""
    lines, _ = inspect.getsourcelines(product.in_space.py_func)
    assert lines[0] == "def over_factors(name, *arguments):\n"


RUNS = """
import hashlib, sys
import numpy as np
import galvi
from galvi import problems
from galvi.kernels.compile.parts import PLAIN

def L(q, v):
    return 0.5 * (1.0 + 0.1 * np.cos(q[0])) * (v @ v) + np.cos(q[0]) * np.cos(q[1])

BURRAU = galvi.Problem(
    galvi.NBody([3.0, 4.0, 5.0]), np.array([[1.0, 3.0], [-2.0, -1.0], [1.0, -1.0]]),
    np.zeros((3, 2)),
)
bent = galvi.Problem(galvi.Lagrangian(L, galvi.Rn(2)), np.array([0.3, 0.2]), np.array([0.1, 0.0]))
space, rule = galvi.Polynomials(4), galvi.gauss(4)
plain, clock = galvi.Galerkin(space, rule), galvi.Galerkin(space, rule, clock=galvi.DynamicalTime())
chart = galvi.Galerkin(space, rule, galvi.Cayley())
RUNS = [
    (problems.kepler(0.6), plain, "auto"), (problems.kepler(0.6), plain, "newton"),
    (BURRAU, clock, "auto"),
    (bent, plain, "auto"), (bent, plain, "newton"),
    (problems.free_rigid_body(), chart, "auto"), (problems.free_rigid_body(), chart, "newton"),
]
for problem, method, solver in RUNS[:: int(sys.argv[1])]:
    run = galvi.integrate(problem, method, 0.05, 20, solver=solver)
    states = b"".join(np.ascontiguousarray(x).tobytes() for x in (run.t, run.q, run.p))
    print(run.engine, run.status, dict(run.counts), hashlib.sha256(states).hexdigest())
print(f"plain: {PLAIN}", file=sys.stderr)
"""


def with_plain_numba(switch: str, *arguments: str) -> subprocess.CompletedProcess[str]:
    environment = {**os.environ, "GALVI_PLAIN_NUMBA": switch, "PYTHONPATH": str(ROOT)}
    command = [sys.executable, "-c", *arguments]
    return subprocess.run(command, env=environment, capture_output=True, text=True)


@pytest.mark.parametrize("save_every", [10, pytest.param(1, marks=pytest.mark.slow)])
def test_a_run_is_the_same_with_numba_as_it_is(save_every):
    compiled_run, plain = (with_plain_numba(switch, RUNS, str(save_every)) for switch in "01")
    assert compiled_run.returncode == plain.returncode == 0 and "plain: True" in plain.stderr
    assert plain.stdout == compiled_run.stdout and compiled_run.stdout.count("\n") == -(
        -7 // save_every
    )


def test_another_value_of_the_switch_is_refused_by_name():
    completed = with_plain_numba("yes", "import galvi")
    assert completed.returncode == 1
    assert "GALVI_PLAIN_NUMBA must be 0 or 1; received 'yes'." in completed.stderr


def test_what_numba_has_inside_is_used_in_one_folder():
    inside = re.compile(r"^\s*(from|import) numba\.core", re.MULTILINE)
    folders = (ROOT / name for name in ("galvi", "references", "benchmarks", "reports"))
    paths = (path for folder in folders for path in folder.rglob("*.py"))
    used = {path.parent for path in paths if inside.search(path.read_text(encoding="utf-8"))}
    assert used == {ROOT / "galvi/kernels/compile"}

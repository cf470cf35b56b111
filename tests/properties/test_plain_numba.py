"""GALVI_PLAIN_NUMBA=1: numba compiles and caches kernels by itself, with the same results."""

from __future__ import annotations

import ast
import os
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
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


def printed(every: int, plain: bool) -> str:
    """What the runs, or one of so many of them, print."""
    found = subprocess.run(
        [sys.executable, "-c", RUNS, str(every)],
        env={**os.environ, "GALVI_PLAIN_NUMBA": str(int(plain)), "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert f"plain: {plain}" in found.stderr
    return found.stdout


def test_a_run_is_the_same_with_numba_as_it_is():
    found = printed(10, plain=True)
    assert found.count("\n") == 1
    assert found == printed(10, plain=False)


@pytest.mark.slow(beside="test_a_run_is_the_same_with_numba_as_it_is")
def test_runs_by_all_kernels_are_the_same_with_numba_as_it_is():
    found = printed(1, plain=True)
    assert found.count("\n") == 7
    assert found == printed(1, plain=False)


def test_another_value_of_the_switch_is_refused_by_name():
    found = subprocess.run(
        [sys.executable, "-c", "import galvi"],
        env={**os.environ, "GALVI_PLAIN_NUMBA": "yes", "PYTHONPATH": str(ROOT)},
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.returncode == 1
    assert "GALVI_PLAIN_NUMBA must be 0 or 1; received 'yes'." in found.stderr


def test_what_numba_has_inside_is_used_in_one_folder():
    outside = []
    for folder in ("galvi", "references", "benchmarks", "reports"):
        for path in (ROOT / folder).rglob("*.py"):
            if path.parent != ROOT / "galvi/kernels/compile":
                tree = ast.parse(path.read_text(encoding="utf-8"))
                outside += [(path, name) for name in imported(tree) if "numba.core" in name]
    assert not outside


def imported(tree: ast.AST) -> Iterator[str]:
    """The modules that are imported."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            yield node.module or ""
        elif isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)

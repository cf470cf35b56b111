"""GALVI_FAST=0: the general kernel runs alone."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import numpy as np

import galvi

ROOT = Path(__file__).parents[3]
ALONE = """
import galvi
from galvi.run.engines import ENGINES
from galvi.systems.traces import NO_TRACES, traces

method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
run = galvi.integrate(galvi.problems.kepler(0.6), method, 0.05, 20)
assert traces(galvi.Canonical(1.0, lambda q: q[0] ** 2)) is NO_TRACES
print(*[engine.name for engine in ENGINES], run.engine, *run.q[-1])
frame = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), chart=galvi.KeplerFrame())
galvi.integrate(galvi.problems.solar_system(), frame, 10.0, 5)
"""


def alone(code: str, fast: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT,
        env={**os.environ, "GALVI_FAST": fast, "PYTHONPATH": str(ROOT)},
    )  # fmt: skip


def test_the_general_kernel_runs_alone_agrees_and_refuses_moving_frames_in_words() -> None:
    done = alone(ALONE, "0")
    *engines, x, y = done.stdout.split()
    assert engines == ["general", "general"], done.stderr
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    run = galvi.integrate(galvi.problems.kepler(0.6), method, 0.05, 20)
    np.testing.assert_allclose([float(x), float(y)], run.q[-1], rtol=0.0, atol=1e-13)
    refusal = "ValueError: moving frames need the lanes, which GALVI_FAST=0 leaves out."
    assert done.stderr.strip().endswith(refusal)


def test_a_mistyped_setting_is_refused() -> None:
    assert "GALVI_FAST must be 0 or 1; received '2'." in alone("import galvi", "2").stderr

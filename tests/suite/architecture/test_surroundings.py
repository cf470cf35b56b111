"""galvi in other surroundings: with GALVI_FAST=0, and where its folder cannot be written."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

import galvi

ROOT = Path(__file__).parents[3]
SETTINGS = ("GALVI_FAST", "NUMBA_CACHE_DIR")
DROP_ROOT_RIGHTS = (
    "setpriv",
    "--bounding-set=-dac_override,-dac_read_search",
    "--inh-caps=-dac_override,-dac_read_search",
)
WITHOUT_LANES = """
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
RUN = """
import galvi
method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
print(galvi.integrate(galvi.problems.kepler(), method, 0.1, 10).status)
"""


def python(folder: Path, *arguments: str, before: tuple[str, ...] = (), **settings: str):
    """Run Python with these arguments and the galvi of a folder; returns the completed process."""
    inherited = {key: value for key, value in os.environ.items() if key not in SETTINGS}
    return subprocess.run(
        [*before, sys.executable, *arguments],
        env=inherited | {"PYTHONPATH": str(folder)} | settings,
        cwd=folder,
        capture_output=True,
        text=True,
    )


def test_the_general_kernel_runs_alone_agrees_and_refuses_moving_frames_in_words() -> None:
    completed = python(ROOT, "-c", WITHOUT_LANES, GALVI_FAST="0")
    *engines, x, y = completed.stdout.split()
    assert engines == ["general", "general"], completed.stderr
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    run = galvi.integrate(galvi.problems.kepler(0.6), method, 0.05, 20)
    np.testing.assert_allclose([float(x), float(y)], run.q[-1], rtol=0.0, atol=1e-13)
    refusal = "ValueError: moving frames need the lanes, which GALVI_FAST=0 leaves out."
    assert completed.stderr.strip().endswith(refusal)


def test_a_mistyped_setting_is_refused() -> None:
    completed = python(ROOT, "-c", "import galvi", GALVI_FAST="2")
    assert "GALVI_FAST must be 0 or 1; received '2'." in completed.stderr


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory):
    """The folder of a copy of galvi and the suite that cannot be written."""
    top = tmp_path_factory.mktemp("read_only")
    for name in ("galvi", "references", "benchmarks", "reports"):
        shutil.copytree(ROOT / name, top / name, ignore=shutil.ignore_patterns("__pycache__"))
    folders = [top, *(path for path in top.rglob("*") if path.is_dir())]
    for folder in folders:
        folder.chmod(0o555)
    yield top
    for folder in folders:
        folder.chmod(0o755)


def restricted(package: Path, *arguments: str, **settings: str):
    """Run Python without a home folder and without root's right to write everywhere."""
    as_root = os.geteuid() == 0
    if as_root and shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere, and there is no setpriv to prevent it")
    before = DROP_ROOT_RIGHTS if as_root else ()
    return python(package, *arguments, before=before, HOME="/proc/none", **settings)


@pytest.mark.slow(
    beside="tests/properties/test_kernel_cache.py::test_without_a_folder_to_write_every_process_compiles"
)
def test_a_run_is_compiled_in_memory_and_said_to_be(package: Path, tmp_path: Path) -> None:
    first = restricted(package, "-c", RUN)
    assert first.stdout == "Completed.\n", first.stderr
    assert "in each process, since no folder for it can be written; set NUMBA_C" in first.stderr
    cached = [restricted(package, "-c", RUN, NUMBA_CACHE_DIR=str(tmp_path)) for _ in range(2)]
    assert "once; later runs load it" in cached[0].stderr and cached[1].stderr == ""


@pytest.mark.slow(
    beside="tests/properties/test_kernel_cache.py::test_without_a_folder_to_write_every_process_compiles"
)
def test_commands_work_where_nothing_can_be_written(package: Path, tmp_path: Path) -> None:
    shown_help = restricted(package, "-m", "galvi", "--help")
    assert shown_help.returncode == 0 and "verify" in shown_help.stdout, shown_help.stderr
    command = ("verify", "--quick", "--claims", "V20", "--out", str(tmp_path / "out"))
    completed = restricted(package, "-m", "galvi", *command)
    assert completed.returncode == 0, completed.stdout + completed.stderr

"""A package that cannot be written, without a home: kernels are compiled in memory, and said so."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[3]
WITHOUT_ROOT = ("setpriv", "--bounding-set=-dac_override,-dac_read_search",
                "--inh-caps=-dac_override,-dac_read_search")  # fmt: skip
RUN = """
import galvi
method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
print(galvi.integrate(galvi.problems.kepler(), method, 0.1, 10).status)
"""


@pytest.fixture(scope="module")
def package(tmp_path_factory: pytest.TempPathFactory):
    """A copy of galvi and the suite that cannot be written."""
    top = tmp_path_factory.mktemp("read_only")
    for name in ("galvi", "references", "benchmarks", "reports"):
        shutil.copytree(ROOT / name, top / name, ignore=shutil.ignore_patterns("__pycache__"))
    folders = [top, *(path for path in top.rglob("*") if path.is_dir())]
    for folder in folders:
        folder.chmod(0o555)
    yield top
    for folder in folders:
        folder.chmod(0o755)


def run(package: Path, *words: str, **more: str) -> subprocess.CompletedProcess[str]:
    """Python with these words, which may not write where the permissions say so."""
    as_root = os.geteuid() == 0
    if as_root and shutil.which("setpriv") is None:
        pytest.skip("root may write everywhere, and there is no setpriv to prevent it")
    environment = {key: value for key, value in os.environ.items() if key != "NUMBA_CACHE_DIR"}
    environment |= {"HOME": "/proc/none", "PYTHONPATH": str(package), **more}
    return subprocess.run(
        [*(WITHOUT_ROOT if as_root else ()), sys.executable, *words],
        env=environment, cwd=package, capture_output=True, text=True,
    )  # fmt: skip


@pytest.mark.slow(
    beside="tests/properties/test_kernel_cache.py::test_without_a_folder_to_write_every_process_compiles"
)
def test_a_run_is_compiled_in_memory_and_said_to_be(package: Path, tmp_path: Path) -> None:
    first = run(package, "-c", RUN)
    assert first.stdout == "Completed.\n", first.stderr
    assert "in each process, since no folder for it can be written; set NUMBA_C" in first.stderr
    kept = [run(package, "-c", RUN, NUMBA_CACHE_DIR=str(tmp_path)).stderr for _ in range(2)]
    assert "once; later runs load it" in kept[0] and kept[1] == ""


@pytest.mark.slow(
    beside="tests/properties/test_kernel_cache.py::test_without_a_folder_to_write_every_process_compiles"
)
def test_commands_work(package: Path, tmp_path: Path) -> None:
    helped = run(package, "-m", "galvi", "--help")
    assert helped.returncode == 0 and "verify" in helped.stdout, helped.stderr
    out = str(tmp_path / "out")
    done = run(package, "-m", "galvi", "verify", "--quick", "--claims", "V20", "--out", out)
    assert done.returncode == 0, done.stdout + done.stderr

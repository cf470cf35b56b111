"""A bench that was stopped: its rows are kept, and taken up by the next of the same sources."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.store.result_cache import ResultCache, digest_of_sources

ROOT = Path(__file__).parents[2]
STOPPED = """
import os
done = []
def pytest_runtest_logreport(report):
    if report.when == "teardown":
        done.append(report)
        if len(done) == 2:
            os._exit(9)
"""


@pytest.mark.slow
def test_a_bench_that_was_stopped_is_resumed(tmp_path: Path) -> None:
    """Two of its rows are known when it is ended; the next measures the others, and saves all."""
    (tmp_path / "stopper.py").write_text(STOPPED)

    def bench(*more: str) -> subprocess.CompletedProcess[str]:
        words = ["-m", "pytest", "benchmarks/timings", "-q", "-k", "closed", "-p", "no:randomly"]
        words += ["--benchmark-enable", "--benchmark-only", "-p", "no:cacheprovider"]
        words += [f"--benchmark-storage=file://{tmp_path / 'store'}", *more]
        path = {"PYTHONPATH": str(tmp_path)}
        return subprocess.run(
            [sys.executable, *words],
            cwd=ROOT,
            env=os.environ | path,
            capture_output=True,
            text=True,
        )

    assert bench("-p", "stopper").returncode == 9
    kept = ResultCache(tmp_path / "store", digest_of_sources()).results()
    assert len(kept) == 2
    times = [row["stats"]["median"] for row in kept.values()]
    done = bench()
    assert done.returncode == 0 and "2 skipped" in done.stdout
    (whole,) = (tmp_path / "store").rglob("*.json")
    rows = json.loads(whole.read_text())["benchmarks"]
    assert len(rows) == len({row["name"] for row in rows}) > 2
    assert set(times) < {row["stats"]["median"] for row in rows}
    for row in rows:
        assert row["extra_info"]["yardstick"]["seconds"] > 0.0
        assert {"error", "counts", "status", "settings", "versions"} < set(row["extra_info"])

"""A bench that was stopped: its rows are kept, and taken up by the next of the same sources."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from pathlib import Path

import pytest

from benchmarks.timings import unfinished
from benchmarks.timings.unfinished import FOLDER, Unfinished

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


def test_a_row_is_known_to_the_same_sources_until_it_is_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    rows = Unfinished(tmp_path)
    rows.keep("a", {"x": 0.1 + 0.2})
    rows.keep("b", {"x": 1})
    assert rows.row("a") == {"x": 0.1 + 0.2} and rows.row("c") is None
    with monkeypatch.context() as other:
        other.setattr(unfinished, "state_of_sources", lambda: "other")
        assert rows.row("a") is None
    rows.remove("a")
    assert rows.row("a") is None and rows.row("b") == {"x": 1}
    rows.remove("b")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    "text", ["", "{", "[]", '{"fullname": "a"}', '{"fullname": "b", "row": 1}']
)
def test_a_row_that_cannot_be_read_is_measured_again(tmp_path: Path, text: str) -> None:
    rows = Unfinished(tmp_path)
    rows.keep("a", {})
    rows.path("a").write_text(text)
    assert rows.row("a") is None


@pytest.mark.slow
def test_a_bench_goes_on_where_it_was_stopped(tmp_path: Path) -> None:
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
    kept = list((tmp_path / "store" / FOLDER).rglob("*.json"))
    assert len(kept) == 2
    times = [json.loads(path.read_text())["row"]["stats"]["median"] for path in kept]
    done = bench()
    assert done.returncode == 0 and "2 skipped" in done.stdout
    (whole,) = (tmp_path / "store").rglob("*.json")
    rows = json.loads(whole.read_text())["benchmarks"]
    assert len(rows) == len({row["name"] for row in rows}) > 2
    assert set(times) < {row["stats"]["median"] for row in rows}
    for row in rows:
        assert row["extra_info"]["yardstick"]["seconds"] > 0.0
        assert {"error", "counts", "status", "settings", "versions"} < set(row["extra_info"])

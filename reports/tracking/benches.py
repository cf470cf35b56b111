"""Benches in the format of pytest-benchmark: of `make bench`, and of each comparison of another
project's integrators, with the times of the head's first round of samples.

Each has the time of the yardstick, see `benchmarks.statistics.calibration`.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pandas as pd
from pytest_benchmark.stats import Metadata
from pytest_benchmark.storage.file import FileStorage
from pytest_benchmark.utils import get_commit_info, get_current_time, get_machine_id

from benchmarks.statistics import calibration
from benchmarks.timings.annotate import annotate
from reports.tracking.checkouts import Checkout
from reports.tracking.gates import Finding
from reports.tracking.outcome import Outcome

PLACE_COLUMNS = (
    "machine",
    "python",
    "numba",
    "numpy",
    "yardstick",
)  # times compare only if all are equal
COLUMNS = (
    "file",
    "date",
    "commit",
    "benchmark",
    "kind",
    "problem",
    "quantity",
    "value",
    *PLACE_COLUMNS,
    "status",
    "error_tolerance",
)
TIME, SECONDS, YARDSTICK, ERROR = "time over yardstick", "seconds", "yardstick seconds", "error"
FIRST_CALL = "first call [s]"  # of a benchmark; it compiles kernels or loads compiled ones
START_UP = (FIRST_CALL, "import [s]", "cold start [s]", "memory [MiB]")


def store_bench(outcome: Outcome, head: Checkout, folder: Path) -> None:
    """Store a bench of the head of a comparison, if the yardstick and a benchmark were timed."""
    timed = [finding for finding in outcome.findings if finding.pair.timed]
    if not timed or not math.isfinite(outcome.yardstick):
        return
    from pytest_benchmark import plugin  # it imports pytest

    content = plugin.pytest_benchmark_generate_json(
        None,
        [_bench(finding, outcome.yardstick) for finding in timed],
        include_data=True,
        machine_info=plugin.pytest_benchmark_generate_machine_info(),
        commit_info=get_commit_info() | {"id": head.commit, "dirty": head.changed},
    )
    silent = SimpleNamespace(info=lambda text: None)
    storage = FileStorage(folder, silent, get_machine_id())
    storage.save(content, f"{head.commit}_{get_current_time()}")


def _bench(finding: Finding, yardstick: float) -> Metadata:
    case, reached = finding.pair.case, finding.pair.reached["head"]
    fixture = SimpleNamespace(
        name=finding.name,
        fullname=finding.name,
        group=None,
        param=None,
        params=None,
        extra_info={},
        cprofile_stats=None,
        has_error=False,
    )
    annotate(
        fixture,
        problem=case.problem,
        error=finding.errors[1],
        counts=reached["counts"],
        status=reached["status"],
        settings=case.setting,
        kind=case.kind,
        first_call=reached["first_call"],
        error_tolerance=case.error_tolerance,
        yardstick={"name": calibration.NAME, "seconds": yardstick},
    )
    bench = Metadata(fixture, iterations=1, options={})
    for seconds in finding.pair.rounds[0]["head"]:
        bench.stats.update(seconds)
    return bench


def read_history(folder: Path, tell: Callable[[str], None] = print) -> pd.DataFrame:
    """A table with a row for each stored bench, benchmark and quantity, ordered by date.

    The quantity is TIME, SECONDS (the median), YARDSTICK, ERROR, a name in START_UP, or the name of
    a count.

    Parameters
    ----------
    tell
        called with a sentence for each unreadable file, which is omitted
    """
    rows: list[dict[str, Any]] = []
    storage = FileStorage(folder, SimpleNamespace(warning=tell)) if folder.is_dir() else None
    for path, content in storage.load("*/*") if storage else ():
        try:
            rows += list(_rows(path.name, content))
        except (LookupError, TypeError, AttributeError) as error:
            tell(f"Failed to load {path}: {error!r}")
    table = pd.DataFrame(rows, columns=list(COLUMNS))
    return table.sort_values(["date", "file"], kind="stable", ignore_index=True)


def _rows(file: str, content: dict[str, Any]) -> Iterator[dict[str, Any]]:
    machine, commit = content["machine_info"], content["commit_info"]
    processor = machine.get("cpu", {}).get("brand_raw") or machine.get("machine", "unknown")
    run = {
        "file": file,
        "date": content["datetime"],
        "commit": f"{commit['id'][:12]}{'+' if commit.get('dirty') else ''}",
        "machine": f"{processor}, {machine.get('system', 'unknown')}",
        "python": machine["python_version"],
    }
    for bench in content["benchmarks"]:
        extra, median = bench["extra_info"], bench["stats"]["median"]
        versions, yardstick = extra.get("versions", {}), extra.get("yardstick", {})
        bench_fields = run | {
            "benchmark": _without_test(bench["name"]),
            "kind": extra.get("kind", "other"),
            "problem": extra.get("problem", ""),
            "numba": versions.get("numba", "unknown"),
            "numpy": versions.get("numpy", "unknown"),
            "yardstick": yardstick.get("name", "none"),
            "status": extra.get("status", ""),
            "error_tolerance": extra.get("error_tolerance", 0.01),
        }
        seconds = yardstick.get("seconds")
        yardstick_values = {YARDSTICK: seconds, TIME: median / seconds} if seconds else {}
        values = {SECONDS: median, **yardstick_values, **extra.get("counts", {})}
        values |= {FIRST_CALL: extra.get("first_call"), **extra.get("start_up", {})}
        values[ERROR] = extra.get("error")
        for quantity, value in values.items():
            if value is not None:
                yield bench_fields | {"quantity": quantity, "value": float(value)}


def _without_test(name: str) -> str:
    """The parameters in a test's name; for a name without parameters, its words."""
    test, bracket, parameters = name.partition("[")
    return parameters.removesuffix("]") if bracket else test.removeprefix("test_").replace("_", " ")

"""Store a benchmark run row by row while it runs, then as one pytest-benchmark file.

An interrupted run is resumed: rows already measured with the same sources are kept. Runs that end
at the same time write files of different names.
"""

from __future__ import annotations

import datetime
import json
import re
import uuid
from collections.abc import Iterator
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from pytest_benchmark.utils import safe_dumps

from benchmarks.store.atomic import write
from benchmarks.store.result_cache import ResultCache, digest_of_sources

ROWS: pytest.StashKey[dict[str, dict[str, Any]]] = pytest.StashKey()
EARLIER: pytest.StashKey[dict[str, dict[str, Any]]] = (
    pytest.StashKey()
)  # rows of an interrupted run
KEPT = "it was measured before the last run was stopped"


def pytest_configure(config: pytest.Config) -> None:
    config.stash[ROWS] = {}


def pytest_runtest_setup(item: pytest.Item) -> None:
    """Load the rows measured by an interrupted run of the same sources; skip their benchmarks."""
    stash = item.config.stash
    if EARLIER not in stash:
        stash[EARLIER] = _cache(item.config).results() if _on(item.config) else {}
    row = stash[EARLIER].get(item.nodeid)
    if row is not None:
        item.config.stash[ROWS][item.nodeid] = row
        pytest.skip(KEPT)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item, call: Any) -> Iterator[None]:
    """Store the row of a benchmark that passed."""
    report = yield
    fixture = getattr(item, "funcargs", {}).get("benchmark")
    if call.when == "call" and report.passed and fixture is not None and fixture.stats:
        row = json.loads(safe_dumps(fixture.stats.as_dict(include_data=True)))
        item.config.stash[ROWS][item.nodeid] = row
        _cache(item.config).keep(item.nodeid, row)
    return report


def pytest_sessionfinish(session: pytest.Session, exitstatus: int) -> None:
    """Write the file of a completed run, and delete its stored rows."""
    config = session.config
    rows = config.stash[ROWS]
    if not _on(config) or not rows or exitstatus not in (0, 1):
        return
    benches = config._benchmarksession  # type: ignore[attr-defined]
    commit = config.hook.pytest_benchmark_generate_commit_info(config=config)
    whole = config.hook.pytest_benchmark_generate_json(
        config=config,
        benchmarks=[],
        include_data=True,
        machine_info=benches.get_machine_info(),
        commit_info=commit,
    )
    whole["benchmarks"] = list(rows.values())
    path = write(_new_path(_storage(config), benches.machine_id, commit), safe_dumps(whole))
    _cache(config).forget(rows)
    print(f"\n{len(rows)} benchmarks are kept in {path}.")


def _on(config: pytest.Config) -> bool:
    return not config._benchmarksession.disabled  # type: ignore[attr-defined]


def _storage(config: pytest.Config) -> Path:
    return Path(config._benchmarksession.storage.path)  # type: ignore[attr-defined]


def _cache(config: pytest.Config) -> ResultCache:
    return ResultCache(_storage(config), _state())


@cache
def _state() -> str:
    """The digest of the sources when this process began."""
    return digest_of_sources()


def _new_path(storage: Path, machine: str, commit: dict[str, Any]) -> Path:
    """A file name as by pytest-benchmark, with a unique suffix."""
    names = [path.name for path in (storage / machine).glob("[0-9]*_*.json")]
    known = [int(found.group()) for name in names if (found := re.match(r"\d+", name))]
    number = max(known, default=0) + 1
    moment = datetime.datetime.now(datetime.UTC).strftime("%Y%m%d_%H%M%S")
    digits = str(commit.get("id", "unversioned"))[:12]
    changed = "_with-changes" if commit.get("dirty") else ""
    end = uuid.uuid4().hex[:8]
    return storage / machine / f"{number:04}_{digits}_{moment}{changed}_{end}.json"

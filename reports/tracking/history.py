"""The history of benches: pytest-benchmark's files of all commits, as one tidy frame.

A file that cannot be read is told of and moved to damaged/, never lost; one that was written just
now may still be on its way, and is left for the next time.
"""

from __future__ import annotations

import json
import math
import os
import statistics
import time
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.store.result_cache import FOLDER as UNFINISHED

DAMAGED = "damaged"
YOUNG = 60.0  # seconds since its last change in which a file may be half copied
PLACE = ("machine", "python", "numba", "numpy", "yardstick")  # what makes a series of its own
COLUMNS = (
    "file", "date", "commit", "benchmark", "kind", "problem", "quantity", "value", *PLACE, "status",
    "error_tolerance",
)  # fmt: skip
TIME, SECONDS, YARDSTICK, ERROR = "time over yardstick", "seconds", "yardstick seconds", "error"

Told = Callable[[str], None]


def read_history(folder: Path, tell: Told = print) -> pd.DataFrame:
    """A row for each file, benchmark and quantity, in the order of their dates.

    quantity  TIME, SECONDS (median), YARDSTICK, ERROR, or the name of a count
    tell      is given a sentence for each file that is set aside or left out
    """
    rows: list[dict[str, Any]] = []
    for path in sorted(folder.rglob("*.json")):
        if {DAMAGED, UNFINISHED} & set(path.relative_to(folder).parts[:-1]):
            continue
        if path.name.startswith("."):
            continue
        rows += _rows(path, folder, tell)
    frame = pd.DataFrame(rows, columns=list(COLUMNS))
    return frame.sort_values(["date", "file"], kind="stable", ignore_index=True)


def _rows(path: Path, folder: Path, tell: Told) -> list[dict[str, Any]]:
    try:
        whole = json.loads(path.read_text(encoding="utf-8"))
    except FileNotFoundError:  # another process set it aside
        return []
    except OSError as error:
        tell(f"{path.name} is left out: it cannot be read ({error.strerror}).")
        return []
    except ValueError:
        _set_aside(path, folder, tell)
        return []
    try:
        return list(_measured(whole, path.name))
    except (KeyError, TypeError, ValueError, AttributeError) as error:
        version = whole.get("version", "unknown") if isinstance(whole, dict) else "unknown"
        tell(
            f"{path.name} is left out: it is JSON, but not of a bench as this version reads it "
            f"(written by pytest-benchmark {version}; {type(error).__name__}: {error})."
        )
        return []


def _measured(whole: Mapping[str, Any], name: str) -> Iterator[dict[str, Any]]:
    machine = whole["machine_info"]
    cpu = machine.get("cpu", {}).get("brand_raw") or machine.get("machine") or "unknown"
    commit = whole["commit_info"]
    told = str(commit.get("id", "unknown"))[:12] + ("+" if commit.get("dirty") else "")
    for bench in whole["benchmarks"]:
        extra, stats = bench.get("extra_info", {}), bench["stats"]
        yardstick, versions = extra.get("yardstick") or {}, extra.get("versions") or {}
        shared = {
            "file": name,
            "date": str(whole["datetime"]),
            "commit": told,
            "benchmark": _short(str(bench["name"])),
            "kind": extra.get("kind", "other"),
            "problem": extra.get("problem", ""),
            "machine": f"{cpu}, {machine.get('system', 'unknown')}",
            "python": str(machine["python_version"]),
            "numba": versions.get("numba", "unknown"),
            "numpy": versions.get("numpy", "unknown"),
            "yardstick": yardstick.get("name", "none"),
            "status": extra.get("status", ""),
            "error_tolerance": float(extra.get("error_tolerance", 0.01)),
        }
        seconds = float(stats.get("median") or statistics.median(stats["data"]))
        if not (math.isfinite(seconds) and seconds > 0.0):
            raise ValueError(f"a time of {seconds!r} seconds")
        values: dict[str, Any] = {SECONDS: seconds}
        if yardstick:
            values |= {YARDSTICK: yardstick["seconds"], TIME: seconds / yardstick["seconds"]}
        values |= dict(extra.get("counts") or {})
        if extra.get("error") is not None:
            values[ERROR] = extra["error"]
        for quantity, value in values.items():
            yield shared | {"quantity": quantity, "value": float(value)}


def _short(name: str) -> str:
    """A test's parameters without the test, when it has any."""
    test, bracket, rest = name.partition("[")
    return rest.removesuffix("]") if bracket else test


def _set_aside(path: Path, folder: Path, tell: Told) -> None:
    try:
        age = time.time() - path.stat().st_mtime
        if age < YOUNG:
            tell(f"{path.name} is left out this time: it is not whole, and may be on its way.")
            return
        to = folder / DAMAGED / path.relative_to(folder)
        to.parent.mkdir(parents=True, exist_ok=True)
        for k in range(1, 1000):
            if not to.exists():
                break
            to = to.with_name(f"{path.name}.{k}")
        os.replace(path, to)
    except FileNotFoundError:
        return
    except OSError as error:
        tell(f"{path.name} is damaged and left out; it cannot be set aside ({error.strerror}).")
        return
    tell(f"{path.name} is damaged: it is not JSON, and now in {to.relative_to(folder)}.")

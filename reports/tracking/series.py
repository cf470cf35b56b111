"""Series over commits, from what earlier commands kept."""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd

from benchmarks.statistics.change_points import change_points, steps

PLACE = ("machine", "python", "numba", "numpy", "yardstick")  # a series never mixes these
COLUMNS = (
    "file", "date", "commit", "benchmark", "kind", "problem", "quantity", "value", *PLACE, "status",
    "error_tolerance",
)  # fmt: skip
TIME, SECONDS, YARDSTICK, ERROR = "time over yardstick", "seconds", "yardstick seconds", "error"
FIRST = "first call [s]"  # of a benchmark, compiling or loading what is compiled
IMPORT, COMPILE, MEMORY = "import [s]", "cold start [s]", "memory [MiB]"
START_UP = (FIRST, IMPORT, COMPILE, MEMORY)


def read_history(folder: Path, tell: Callable[[str], None] = print) -> pd.DataFrame:
    """A row for each file (MACHINE/NAME.json), benchmark and quantity, ordered by date.

    quantity  TIME, SECONDS (median), YARDSTICK, ERROR, one of START_UP, or the name of a count
    tell      called with a sentence for each unreadable file, which is omitted
    """
    rows: list[dict[str, Any]] = []
    for path in sorted(folder.glob("*/*.json")):
        try:
            rows += list(_rows(path))
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            tell(
                f"{path.name} is left out: it is not a bench as this version reads it "
                f"({type(error).__name__}: {error})."
            )
    frame = pd.DataFrame(rows, columns=list(COLUMNS))
    return frame.sort_values(["date", "file"], kind="stable", ignore_index=True)


def _rows(path: Path) -> Iterator[dict[str, Any]]:
    whole = json.loads(path.read_text(encoding="utf-8"))
    machine, commit = whole["machine_info"], whole["commit_info"]
    cpu = machine.get("cpu", {}).get("brand_raw") or machine.get("machine") or "unknown"
    changed = "+" if commit.get("dirty") else ""
    for bench in whole["benchmarks"]:
        extra = bench.get("extra_info", {})
        yardstick, versions = extra.get("yardstick") or {}, extra.get("versions") or {}
        shared = {
            "file": path.name,
            "date": str(whole["datetime"]),
            "commit": str(commit.get("id", "unknown"))[:12] + changed,
            "benchmark": _without_test(str(bench["name"])),
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
        seconds = float(bench["stats"]["median"])
        if not (math.isfinite(seconds) and seconds > 0.0):
            raise ValueError(f"a time of {seconds!r} seconds")
        values: dict[str, Any] = {SECONDS: seconds}
        if yardstick:
            values |= {YARDSTICK: yardstick["seconds"], TIME: seconds / yardstick["seconds"]}
        values |= dict(extra.get("counts") or {})
        values |= {FIRST: extra["first_call"]} if extra.get("first_call") else {}
        values |= dict(extra.get("start_up") or {})
        if extra.get("error") is not None:
            values[ERROR] = extra["error"]
        for quantity, value in values.items():
            yield shared | {"quantity": quantity, "value": float(value)}


def _without_test(name: str) -> str:
    """The parameters in a test's name, or its words when it has none."""
    test, bracket, rest = name.partition("[")
    return rest.removesuffix("]") if bracket else test.removeprefix("test_").replace("_", " ")


@dataclass(frozen=True, eq=False)
class Series:
    """One quantity of one benchmark on one machine.

    place    the machine and the versions
    files, commits, values  in the order of the benchmark runs
    changes  indices at which a new level begins
    """

    place: str
    benchmark: str
    quantity: str
    files: tuple[str, ...]
    commits: tuple[str, ...]
    values: np.ndarray
    changes: tuple[int, ...]

    def among(self, files: Sequence[str]) -> tuple[np.ndarray, list[int]]:
        """Values and changes at the positions of these files; NaN where the quantity is missing."""
        places = {name: k for k, name in enumerate(self.files)}
        found = np.array([places.get(name, -1) for name in files])
        values = np.where(found >= 0, self.values[found], np.nan)
        return values, np.flatnonzero(np.isin(found, self.changes)).tolist()

    def sentences(self) -> list[tuple[str, str]]:
        """(commit, sentence) of each change.

        The change is near that commit: of two changes close together only one is found.
        """
        said = []
        bounds = [0, *self.changes, len(self.values)]
        for first, change, end in zip(bounds, bounds[1:], bounds[2:], strict=False):
            before = float(np.nanmedian(self.values[first:change]))
            after = float(np.nanmedian(self.values[change:end]))
            share = f"{before:g} became {after:.3g}"
            if before > 0:
                share = f"{100 * (after / before - 1):+.1f} %"
            commit = self.commits[change]
            said.append((commit, f"{self.benchmark}: {self.quantity} {share} near {commit}"))
        return said


def all_series(frame: pd.DataFrame) -> Iterator[Series]:
    """The series of a history; no change points for seconds, which depend on what else runs."""
    for (*place, benchmark, quantity), rows in frame.groupby(
        [*PLACE, "benchmark", "quantity"], sort=False
    ):
        machine, python, numba, numpy, yardstick = place
        values = rows["value"].to_numpy(float)
        tolerance = float(rows["error_tolerance"].iloc[-1]) if quantity == ERROR else 0.0
        if quantity in (SECONDS, YARDSTICK, *START_UP):
            changes: list[int] = []
        elif quantity == TIME:
            changes = change_points(values.tolist())
        else:
            changes = steps(values.tolist(), tolerance)
        yield Series(
            place=f"{machine}; Python {python}, numba {numba}, numpy {numpy}; "
            f"yardstick: {yardstick}",
            benchmark=str(benchmark),
            quantity=str(quantity),
            files=tuple(rows["file"]),
            commits=tuple(rows["commit"]),
            values=values,
            changes=tuple(changes),
        )

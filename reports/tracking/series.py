"""The history as time series, one per benchmark, quantity and machine, with change points."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchmarks.statistics.change_points import change_points, steps
from reports.tracking.history import ERROR, PLACE, SECONDS, START_UP, TIME, YARDSTICK


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

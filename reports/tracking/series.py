"""The history as series: one for each benchmark and quantity on one machine, with its changes."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

import numpy as np
import pandas as pd

from benchmarks.statistics.change_points import change_points, steps
from reports.tracking.history import ERROR, PLACE, SECONDS, TIME, YARDSTICK

NOT_COUNTS = (TIME, SECONDS, YARDSTICK, ERROR)


@dataclass(frozen=True, eq=False)
class Series:
    """files, commits and values in the order of the benches; changes: positions of new levels."""

    place: str
    benchmark: str
    quantity: str
    files: tuple[str, ...]
    commits: tuple[str, ...]
    values: np.ndarray
    changes: tuple[int, ...]

    def among(self, files: Sequence[str]) -> tuple[np.ndarray, list[int]]:
        """values and changes at the places of these files; NaN where the quantity is not known."""
        places, values = {name: k for k, name in enumerate(files)}, np.full(len(files), np.nan)
        own = [places.get(name) for name in self.files]
        for place, value in zip(own, self.values, strict=True):
            if place is not None:
                values[place] = value
        return values, [place for k in self.changes if (place := own[k]) is not None]

    def told(self) -> list[str]:
        """A sentence for each change."""
        sentences = []
        bounds = [0, *self.changes, len(self.values)]
        for first, change, end in zip(bounds, bounds[1:], bounds[2:], strict=False):
            before = float(np.nanmedian(self.values[first:change]))
            after = float(np.nanmedian(self.values[change:end]))
            share = (
                f"{100 * (after / before - 1):+.1f} %" if before > 0
                else f"{before:g} became {after:.3g}"
            )  # fmt: skip
            sentences.append(f"{self.benchmark}: {self.quantity} {share} at {self.commits[change]}")
        return sentences


def place_of(row: pd.Series) -> str:
    """The machine and the versions, which a series never mixes."""
    told = [f"Python {row['python']}", f"numba {row['numba']}", f"numpy {row['numpy']}"]
    return f"{row['machine']}; {', '.join(told)}; yardstick: {row['yardstick']}"


def all_series(frame: pd.DataFrame) -> Iterator[Series]:
    """Of each machine apart; seconds and the yardstick itself are not looked at for changes."""
    grouped = frame.groupby([*PLACE, "benchmark", "quantity"], sort=False)
    for (*_, benchmark, quantity), rows in grouped:
        values = rows["value"].to_numpy(float)
        if quantity in (SECONDS, YARDSTICK):
            changes: list[int] = []
        elif quantity == TIME:
            changes = change_points(values.tolist())
        elif quantity == ERROR:
            changes = steps(values.tolist(), float(rows["error_tolerance"].iloc[-1]))
        else:
            changes = steps(values.tolist(), 0.0)
        yield Series(
            place_of(rows.iloc[0]), str(benchmark), str(quantity), tuple(rows["file"]),
            tuple(rows["commit"]), values, tuple(changes),
        )  # fmt: skip

"""`track`: the history of benches as a tidy file, and as pictures and tables for each machine."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.statistics import change_points
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.figures.picture import Picture, picture, slug, write_files
from reports.figures.track_record import track_record
from reports.results.section import Figure
from reports.results.summary import count_of
from reports.tables.number_format import plain
from reports.tracking.benches import (
    ERROR,
    PLACE_COLUMNS,
    SECONDS,
    START_UP,
    TIME,
    YARDSTICK,
    read_history,
)

STORE = "benchmarks"  # subfolder of the report
PICTURED_KINDS = ("step", "trajectory", "round-off")  # kinds of benchmarks that have a picture
PANELS = (TIME, "iterations", ERROR)
RELATIVE = "time, relative"
MIN_BENCHES = 2 * change_points.FEWEST_POINTS  # smallest number of benches that can show a change
BENCH_COLUMNS = ["date", "file", "commit"]
TEXT = (
    "Times are medians of processor time, divided by those of a fixed workload, the yardstick, "
    "timed just before and after, so that a busy machine does not look slower. Only benchmark runs "
    "of one machine and the same versions are compared; counts and errors are from the same runs. "
    "A change is said to be near a commit, since of two changes close together only one is found. "
    "The first call, the import and the cold start of a fresh process are in seconds. "
)


@dataclass(frozen=True, eq=False)
class Place:
    """The benches of one machine with one set of versions.

    Attributes
    ----------
    benches
        number of benches
    rows
        the last run of each benchmark, with its time relative to the median of earlier runs
    commits
        a row for each bench: medians, over the benchmarks, of their times relative to each one's
        own median, and of the quantities START_UP
    extremes
        a sentence on the slowest and the fastest commit; "" for fewer than two benches with times
    changes
        sentences on changes of level
    """

    name: str
    benches: int
    rows: pd.DataFrame
    commits: pd.DataFrame
    extremes: str
    changes: tuple[str, ...]
    pictures: tuple[Picture, ...]


@dataclass(frozen=True)
class History:
    """The stored benches of each machine; `text` explains how they are compared."""

    text: str
    places: tuple[Place, ...]
    sentences: tuple[str, ...]


def history(out: Path) -> History | None:
    """Read the benches below `out`, and write history.csv and the pictures.

    Returns None if there are neither benches nor unreadable files.
    """
    sentences: list[str] = []
    table = read_history(out / STORE, sentences.append)
    write(out / "history.csv", as_csv(table))
    groups = table.groupby(list(PLACE_COLUMNS), sort=False)
    places = tuple(
        _record_of_machine(key, rows, k) for k, (key, rows) in enumerate(groups, start=1)
    )
    if len(places) > 1:
        sentences.append(
            f"Benchmark runs of {len(places)} machines or versions are shown separately, because "
            "their times cannot be compared."
        )
    for drawn in (drawn for machine in places for drawn in machine.pictures):
        write_files(drawn, out / "figures")
    text = TEXT + change_points.CHANGE_RULE
    return History(text, places, tuple(sentences)) if places or sentences else None


def _record_of_machine(key: tuple[str, ...], rows: pd.DataFrame, number: int) -> Place:
    machine, python, numba, numpy, yardstick = key
    last, changes, pictures = [], [], []
    for benchmark, runs in rows.groupby("benchmark", sort=False):
        series = runs.pivot_table("value", BENCH_COLUMNS, "quantity", aggfunc="last", sort=False)
        tolerance = float(runs["error_tolerance"].iloc[-1])
        levels = {name: _changes(series[name], tolerance) for name in series}
        last.append(_last_run(benchmark, series, sum(map(len, levels.values()))))
        changes += [
            f"{benchmark}: {name} {sentence}"
            for name, indices in levels.items()
            for sentence in _sentences(series[name], indices)
        ]
        panels = [
            (name, series[name].to_numpy(), levels[name], name == ERROR)
            for name in PANELS
            if name in series
        ]
        if panels and runs["kind"].iloc[-1] in PICTURED_KINDS:
            figure = Figure(
                name=slug(benchmark).replace("work-precision", "track")
                + (f"-{number}" if number > 1 else ""),
                title=benchmark,
                draw=track_record,
                options={"panels": panels},
                caption="One point for each benchmark run; a dashed line where the level changes.",
                size=(6.0, 1.1 + 1.25 * len(panels)),
            )
            pictures.append(picture(figure, series.index.to_frame()))
    commits = _commits(rows)
    return Place(
        f"{machine}; Python {python}, numba {numba}, numpy {numpy}; yardstick: {yardstick}",
        len(commits),
        pd.DataFrame(last),
        commits,
        _extremes(commits),
        tuple(changes),
        tuple(pictures),
    )


def _changes(values: pd.Series, tolerance: float) -> list[int]:
    """Indices at which the level of a quantity changes; [] for times in seconds, which depend on
    the machine's load."""
    if values.name in (SECONDS, YARDSTICK, *START_UP):
        return []
    if values.name == TIME:
        return change_points.change_points(values)
    return change_points.steps(values, tolerance if values.name == ERROR else 0.0)


def _sentences(values: pd.Series, changes: list[int]) -> Iterator[str]:
    bounds = [0, *changes, len(values)]
    for first, change, end in zip(bounds, bounds[1:], bounds[2:], strict=False):
        before, after = values.iloc[first:change].median(), values.iloc[change:end].median()
        growth = (
            f"{100 * (after / before - 1):+.1f} %"
            if before > 0
            else (f"{before:g} became {after:.3g}")
        )
        yield f"{growth} near {values.index[change][BENCH_COLUMNS.index('commit')]}"


def _last_run(benchmark: str, series: pd.DataFrame, changes: int) -> dict[str, object]:
    """The row of a benchmark for `Place.rows`."""
    last = series.ffill().iloc[-1]
    times = series.get(TIME, pd.Series(dtype=float)).dropna()
    return {
        "benchmark": benchmark,
        "runs": len(series),
        TIME: last.get(TIME, np.nan),
        "over the median of earlier runs": (
            times.iloc[-1] / times.iloc[:-1].median() if len(times) > 1 else np.nan
        ),
        "iterations": last.get("iterations", np.nan),
        "error": last.get(ERROR, np.nan),
        "changes": changes if changes or len(times) >= MIN_BENCHES else "too few runs",
    }


def _commits(rows: pd.DataFrame) -> pd.DataFrame:
    """The rows of `Place.commits`, in the order of the dates."""
    times = rows[rows["quantity"] == TIME]
    medians = times.groupby("benchmark")["value"].transform("median")
    relative = times.assign(quantity=RELATIVE, value=times["value"] / medians)
    both = pd.concat([rows, relative])
    table = both.pivot_table("value", BENCH_COLUMNS, "quantity", aggfunc="median").reset_index()
    columns = [name for name in (RELATIVE, *START_UP) if name in table]
    return table.assign(date=table["date"].str[:16].str.replace("T", " "))[
        ["commit", "date", *columns]
    ].rename_axis(columns=None)


def _extremes(commits: pd.DataFrame) -> str:
    if RELATIVE not in commits or commits[RELATIVE].count() < 2:
        return ""
    times = commits.set_index("commit")[RELATIVE]
    warning = " So few runs cannot tell a change from noise." if len(commits) < MIN_BENCHES else ""
    return (
        f"Slowest commit: {times.idxmax()}, at {plain(times.max())} times the median of all; "
        f"fastest: {times.idxmin()}, at {plain(times.min())}.{warning}"
    )


def track(out: Path, tell: Callable[[str], None] = print) -> None:
    """Write the files of the history, and call `tell` with each of its sentences."""
    record = history(out) or History(TEXT, (), ())
    changes = [f"{change}." for machine in record.places for change in machine.changes]
    for sentence in (*record.sentences, *changes):
        tell(sentence)
    if not record.places:
        tell(
            f"There is no benchmark run in {out / STORE} yet. Each `galvi track --against REV "
            "--contender package.module:Class` adds one, and in galvi's checkout `make bench`."
        )
    tell(f"{count_of(sum(machine.benches for machine in record.places), 'benchmark run')}.")

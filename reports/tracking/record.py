"""`track`: the history as a tidy file, pictures and a page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.statistics import change_points
from benchmarks.store.atomic import write
from reports.figures.drawing import slug
from reports.figures.picture import Picture, picture
from reports.figures.plots.track_record import track_record
from reports.figures.style.no_data import NoData
from reports.page.grid import Grid, grid
from reports.results.figure import Figure
from reports.tables.number_format import plain
from reports.tables.writing import as_csv
from reports.tracking.history import ERROR, TIME, read_history
from reports.tracking.page import render
from reports.tracking.series import Series, all_series

STORE = "benchmarks"  # in the folder of the report
PICTURED = ("step", "trajectory", "round-off")  # kinds of benchmarks that get a picture
SHOWN = ("iterations", "force_evaluations")
EMPTY = (
    "There is no bench yet in {folder}: `make bench` makes one, and each further one adds a point."
)


@dataclass(frozen=True)
class Place:
    """One machine with its versions: how many benches it has, its table, pictures and changes."""

    name: str
    benches: int
    rows: Grid
    pictures: tuple[Picture, ...]
    changes: tuple[str, ...]


def track(out: Path, provenance: dict[str, str], tell: Callable[[str], None] = print) -> int:
    """Read the history below `out`, write history.csv, track.html and pictures; 0."""
    said: list[str] = []

    def report(sentence: str) -> None:
        said.append(sentence)
        tell(sentence)

    frame = read_history(out / STORE, report)
    write(out / "history.csv", as_csv(frame))
    if frame.empty:
        report(EMPTY.format(folder=out / STORE))
    places = _places(frame, list(all_series(frame)))
    if len(places) > 1:
        report(
            f"Benches of {len(places)} machines or versions are shown apart: their times do not "
            "compare."
        )
    for place in places:
        for one in place.pictures:
            write(out / "figures" / f"{one.name}.svg", one.svg)
            write(out / "figures" / f"{one.name}.png", one.png)
        for change in place.changes:
            tell(f"{change}.")
    page = render(places, said, provenance, change_points.TEXT)
    write(out / "track.html", page)
    tell(f"{frame['file'].nunique()} benches; the page is {out / 'track.html'}.")
    return 0


def _places(frame: pd.DataFrame, series: list[Series]) -> list[Place]:
    found = []
    kinds = dict(zip(frame["benchmark"], frame["kind"], strict=True))
    for name in dict.fromkeys(one.place for one in series):
        own = [one for one in series if one.place == name]
        by_benchmark: dict[str, dict[str, Series]] = {}
        for one in own:
            by_benchmark.setdefault(one.benchmark, {})[one.quantity] = one
        pictures = [
            drawn
            for benchmark, quantities in by_benchmark.items()
            if kinds[benchmark] in PICTURED
            and (drawn := _picture(benchmark, quantities, len(found))) is not None
        ]
        table = pd.DataFrame([_line(b, q) for b, q in by_benchmark.items()])
        numbers = dict.fromkeys(table.columns[1:], "number")
        benches = max(len(one.values) for one in own)
        changes = tuple(told for one in own for told in one.told())
        found.append(Place(name, benches, grid(table, numbers), tuple(pictures), changes))
    return found


def _line(benchmark: str, quantities: dict[str, Series]) -> dict[str, str]:
    """The last bench of a benchmark, and how its time stands to the median of those before."""
    time, error = quantities.get(TIME), quantities.get(ERROR)
    known = time.values[np.isfinite(time.values)] if time else np.array([])
    ratio = known[-1] / np.median(known[:-1]) if known.size > 1 else np.nan
    iterations = quantities.get("iterations")
    return {
        "benchmark": benchmark,
        "benches": str(max(len(one.values) for one in quantities.values())),
        "time / yardstick": plain(float(known[-1])) if known.size else "",
        "over earlier ones": plain(float(ratio)),
        "iterations": f"{iterations.values[-1]:.0f}" if iterations else "",
        "error": plain(float(error.values[-1])) if error else "",
        "changes": str(sum(len(one.changes) for one in quantities.values())),
    }


def _picture(benchmark: str, quantities: dict[str, Series], place: int) -> Picture | None:
    chosen = [quantities[name] for name in (TIME, *SHOWN[:1], ERROR) if name in quantities]
    if not chosen:
        return None
    longest = max(chosen, key=lambda one: len(one.values))
    panels = [(one.quantity, *one.among(longest.files), one.quantity == ERROR) for one in chosen]
    ending = f"-{place + 1}" if place else ""
    figure = Figure(
        name=slug(benchmark).replace("work-precision", "track") + ending,
        title=benchmark,
        draw=track_record,
        options={"panels": panels},
        caption="One point for each bench; a dashed line where the level changes.",
        size=(6.0, 1.1 + 1.25 * len(panels)),
    )
    try:
        return picture(figure, pd.DataFrame({"commit": longest.commits}))
    except NoData:
        return None

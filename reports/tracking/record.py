"""`track`: write the benchmark history as a tidy file, pictures and a page."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.statistics import change_points
from benchmarks.store.atomic import write
from reports.figures.drawing import slug
from reports.figures.picture import Picture, picture
from reports.figures.study_plots.track_record import track_record
from reports.figures.style.no_data import NoData
from reports.page.grid import Grid, grid
from reports.page.render import page_environment, style
from reports.results.figure import Figure
from reports.tables.number_format import plain
from reports.tables.writing import as_csv
from reports.tracking.history import ERROR, TIME, read_history
from reports.tracking.series import Series, all_series

STORE = "benchmarks"  # subfolder of the report
PICTURED = ("step", "trajectory", "round-off")  # kinds of benchmarks with a picture
PANELS = (TIME, "iterations", ERROR)
TEXT = (
    "Times are medians of processor time, divided by those of a fixed workload timed just before "
    "and after, so that a busy machine does not look slower. Only benchmark runs of one machine "
    "and the same versions are compared; counts and errors are from the same runs. "
)


@dataclass(frozen=True)
class Place:
    """One machine and its versions: number of benchmark runs, table, pictures and changes."""

    name: str
    benches: int
    rows: Grid
    pictures: tuple[Picture, ...]
    changes: tuple[str, ...]


def track(out: Path, provenance: Mapping[str, str], tell: Callable[[str], None] = print) -> int:
    """Read the history below `out`, write history.csv, track.html and pictures; returns 0."""
    said: list[str] = []
    frame = read_history(out / STORE, said.append)
    write(out / "history.csv", as_csv(frame))
    if frame.empty:
        said.append(
            f"There is no bench yet in {out / STORE}: `make bench` makes one, and each further one "
            "adds a point."
        )
    places = list(_places(frame))
    if len(places) > 1:
        said.append(
            f"Benches of {len(places)} machines or versions are shown apart: their times do not "
            "compare."
        )
    for place in places:
        for one in place.pictures:
            write(out / "figures" / f"{one.name}.svg", one.svg)
            write(out / "figures" / f"{one.name}.png", one.png)
    page = (
        page_environment(Path(__file__).parent)
        .get_template("track.html.j2")
        .render(
            css=style(),
            text=TEXT + change_points.TEXT,
            places=places,
            said=said,
            provenance=list(provenance.items()),
        )
    )
    write(out / "track.html", page)
    for sentence in (*said, *(f"{change}." for place in places for change in place.changes)):
        tell(sentence)
    count = frame["file"].nunique()
    tell(f"{count} bench{'' if count == 1 else 'es'}; the page is {out / 'track.html'}.")
    return 0


def _places(frame: pd.DataFrame) -> Iterator[Place]:
    series = list(all_series(frame))
    kinds = dict(zip(frame["benchmark"], frame["kind"], strict=True))
    for number, name in enumerate(dict.fromkeys(one.place for one in series), start=1):
        own = [one for one in series if one.place == name]
        by_benchmark: dict[str, dict[str, Series]] = {}
        for one in own:
            by_benchmark.setdefault(one.benchmark, {})[one.quantity] = one
        table = pd.DataFrame([_row(*item) for item in by_benchmark.items()])
        pictures = [
            _picture(benchmark, quantities, number)
            for benchmark, quantities in by_benchmark.items()
            if kinds[benchmark] in PICTURED
        ]
        yield Place(
            name=name,
            benches=max(len(one.values) for one in own),
            rows=grid(table, dict.fromkeys(table.columns[1:], "number")),
            pictures=tuple(one for one in pictures if one is not None),
            changes=tuple(sentence for one in own for sentence in one.sentences()),
        )


def _row(benchmark: str, quantities: Mapping[str, Series]) -> dict[str, str]:
    """The last run of a benchmark, with its time relative to the median of earlier ones."""
    time, error = quantities.get(TIME), quantities.get(ERROR)
    times = time.values[np.isfinite(time.values)] if time else np.array([])
    ratio = times[-1] / np.median(times[:-1]) if times.size > 1 else np.nan
    iterations = quantities.get("iterations")
    return {
        "benchmark": benchmark,
        "benches": str(max(len(one.values) for one in quantities.values())),
        "time / yardstick": plain(float(times[-1])) if times.size else "",
        "over earlier ones": plain(float(ratio)),
        "iterations": f"{iterations.values[-1]:.0f}" if iterations else "",
        "error": plain(float(error.values[-1])) if error else "",
        "changes": str(sum(len(one.changes) for one in quantities.values())),
    }


def _picture(benchmark: str, quantities: Mapping[str, Series], place: int) -> Picture | None:
    """The picture of a benchmark; None where there is nothing to draw."""
    shown = [quantities[name] for name in PANELS if name in quantities]
    if not shown:
        return None
    longest = max(shown, key=lambda one: len(one.values))
    panels = [(one.quantity, *one.among(longest.files), one.quantity == ERROR) for one in shown]
    figure = Figure(
        name=slug(benchmark).replace("work-precision", "track") + (f"-{place}" * (place > 1)),
        title=benchmark,
        draw=track_record,
        options={"panels": panels},
        caption="One point for each benchmark run; a dashed line where the level changes.",
        size=(6.0, 1.1 + 1.25 * len(panels)),
    )
    try:
        return picture(figure, pd.DataFrame({"commit": longest.commits}))
    except NoData:
        return None

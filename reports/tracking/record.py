"""`track`: write the benchmark history as a tidy file, pictures and a page."""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pandas as pd

from benchmarks.statistics import change_points
from benchmarks.statistics.smallest_change import POWER, smallest_change
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.figures.picture import Picture, picture, slug, write_files
from reports.figures.style.layout import NoData
from reports.figures.track_record import track_record
from reports.results.options import OUT, OWN_FOLDER
from reports.results.section import Figure
from reports.tables.number_format import known, plain, readable
from reports.tracking.outcome import known_changes, reason_of
from reports.tracking.series import (
    COMPILE,
    ERROR,
    FIRST,
    IMPORT,
    MEMORY,
    TIME,
    Series,
    all_series,
    read_history,
)

STORE = "benchmarks"  # subfolder of the report
PICTURED = ("step", "trajectory", "round-off")  # kinds of benchmarks with a picture
PANELS = (TIME, "iterations", ERROR)
NUMBER = "number"
TEXT = (
    "Times are medians of processor time, divided by those of a fixed workload, the yardstick, "
    "timed just before and after, so that a busy machine does not look slower. Only benchmark runs "
    "of one machine and the same versions are compared; counts and errors are from the same runs. "
    "A change is said to be near a commit, since of two changes close together only one is found. "
    "The first call, the import and the cold start of a fresh process are in seconds. "
)


@dataclass(frozen=True)
class Place:
    """One machine and its versions.

    benches       number of benchmark runs
    rows          the last run of each benchmark
    commits       each bench: relative time, first call, import, cold start, memory
    extremes      a sentence on the slowest and the fastest commit
    changes       sentences on changes of level; `acknowledged` are those with a known reason
    """

    anchor: str
    name: str
    benches: int
    rows: pd.DataFrame
    commits: pd.DataFrame | None
    extremes: str
    pictures: tuple[Picture, ...]
    changes: tuple[str, ...]
    acknowledged: tuple[str, ...]


@dataclass(frozen=True)
class History:
    """The kept benches, for the page; visible: the smallest change each benchmark can see."""

    text: str
    places: tuple[Place, ...]
    said: tuple[str, ...]
    visible: pd.DataFrame | None


def history(out: Path) -> History | None:
    """The history of the benches below `out`; None without any. Writes history.csv, pictures."""
    said: list[str] = []
    frame = read_history(out / STORE, said.append)
    write(out / "history.csv", as_csv(frame))
    visible = _visible(out / "against.json")
    if frame.empty and visible is None:
        return None
    if frame.empty:
        said.append(_no_bench(out))
    places = tuple(_places(frame))
    if len(places) > 1:
        said.append(
            f"Benches of {len(places)} machines or versions are shown apart: their times do not "
            "compare."
        )
    for place in places:
        for one in place.pictures:
            write_files(one, out / "figures")
    return History(TEXT + change_points.TEXT, places, tuple(said), visible)


def track(out: Path, provenance: Mapping[str, str], tell: Callable[[str], None] = print) -> int:
    """Write the history's files and its page, history.html; returns 0."""
    said: list[str] = []
    found = history(out)
    if found is None:
        found = History(TEXT, (), (_no_bench(out),), None)
    said += [*found.said, *(f"{change}." for place in found.places for change in place.changes)]
    for sentence in said:
        tell(sentence)
    count = pd.read_csv(out / "history.csv")["file"].nunique()
    tell(f"{count} bench{'' if count == 1 else 'es'}.")
    return 0


def _no_bench(out: Path) -> str:
    another = "`galvi track --against REV --contender package.module:Class`"
    how = another if OWN_FOLDER in (OUT.name, *out.parts) else "`make bench`"
    return (
        f"There is no bench yet in {out / STORE}: {how} makes one, and each further one adds a "
        "point."
    )


def _places(frame: pd.DataFrame) -> Iterator[Place]:
    series, known_ones = list(all_series(frame)), known_changes()
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
        benches = _benches(own, dict(zip(frame["file"], frame["date"], strict=True)))
        changes, explained = [], []
        for one in own:
            for commit, sentence in one.sentences():
                why = reason_of(known_ones, one.benchmark, one.quantity, commit)
                (explained if why else changes).append(f"{sentence}{f': {why}' if why else ''}")
        yield Place(
            anchor="place-" + re.sub(r"[^a-z0-9]+", "-", name.lower()).strip("-"),
            name=name,
            benches=max(len(one.values) for one in own),
            rows=table,
            commits=_readable(benches),
            extremes=_extremes(benches),
            pictures=tuple(one for one in pictures if one is not None),
            changes=tuple(changes),
            acknowledged=tuple(explained),
        )


RELATIVE = "time, relative"


def _benches(series: list[Series], dates: Mapping[str, str]) -> pd.DataFrame:
    """A line for each bench, ordered by `dates` (file -> date): the median over the benchmarks of
    their time over their own median, of their first calls, and what a fresh process costs."""
    lines: dict[str, dict[str, object]] = {}
    for one in series:
        middle = np.nanmedian(one.values) if np.any(np.isfinite(one.values)) else np.nan
        for file, commit, value in zip(one.files, one.commits, one.values, strict=True):
            line = lines.setdefault(file, {"commit": commit, "file": file})
            if one.quantity == TIME and middle > 0.0:
                line.setdefault(RELATIVE, []).append(value / middle)  # type: ignore[attr-defined]
            elif one.quantity in (FIRST, IMPORT, COMPILE, MEMORY):
                line.setdefault(one.quantity, []).append(value)  # type: ignore[attr-defined]
    table = pd.DataFrame(list(lines.values()))
    columns = [name for name in (RELATIVE, FIRST, IMPORT, COMPILE, MEMORY) if name in table]
    for name in columns:
        table[name] = [
            np.nanmedian(cell) if isinstance(cell, list) else np.nan for cell in table[name]
        ]
    table["date"] = [dates[file][:16].replace("T", " ") for file in table["file"]]
    table = table.sort_values(["date", "file"], ignore_index=True)
    return table[["commit", "date", *columns]]


def _readable(benches: pd.DataFrame) -> pd.DataFrame:
    text = benches.astype(object)
    for name in tuple(benches)[2:]:
        text[name] = [readable(float(value)) for value in benches[name]]
    return text


def _extremes(benches: pd.DataFrame) -> str:
    if RELATIVE not in benches or benches[RELATIVE].notna().sum() < 2:
        return ""
    slow, fast = (benches.loc[getattr(benches[RELATIVE], find)()] for find in ("idxmax", "idxmin"))
    return (
        f"Slowest commit kept: {slow['commit']}, at {plain(float(slow[RELATIVE]))} times the "
        f"median of all; fastest: {fast['commit']}, at {plain(float(fast[RELATIVE]))}."
        + (
            " So few runs do not tell a change from noise."
            if len(benches) < 2 * change_points.LEAST
            else ""
        )
    )


def _visible(path: Path) -> pd.DataFrame | None:
    """From the samples of the last `track --against`; None where there are none."""
    try:
        pairs = json.loads(path.read_text(encoding="utf-8"))["benchmarks"]
    except (OSError, ValueError, KeyError, TypeError):
        return None
    lines, timed = [], [one for one in pairs if one["pair"]["rounds"] and not one["pair"]["why"]]
    for one in timed:
        samples, case = one["pair"]["rounds"][0], one["pair"]["case"]
        sides = samples["base"], samples["head"]
        by_gate, by_rank = (
            smallest_change(*sides, size, len(timed)) for size in (case["slower"], 0.0)
        )
        lines.append(
            {
                "benchmark": one["name"],
                "samples of each side": str(len(samples["head"])),
                f"seen {100 * POWER:.0f} % of the time": _percent(by_gate),
                "by rank alone": _percent(by_rank),
            }
        )
    table = pd.DataFrame(lines)
    return table if lines else None


def _percent(number: float) -> str:
    return f"{100 * number:.0f} %" if known(number) else "more than 100 %"


def _row(benchmark: str, quantities: Mapping[str, Series]) -> dict[str, str]:
    """The last run of a benchmark, with its time relative to the median of earlier ones."""
    time, error = quantities.get(TIME), quantities.get(ERROR)
    times = time.values[np.isfinite(time.values)] if time else np.array([])
    ratio = times[-1] / np.median(times[:-1]) if times.size > 1 else np.nan
    iterations = quantities.get("iterations")
    found = sum(len(one.changes) for one in quantities.values())
    return {
        "benchmark": benchmark,
        "runs": str(max(len(one.values) for one in quantities.values())),
        TIME: readable(float(times[-1])) if times.size else "",
        "over the median of earlier runs": readable(float(ratio)),
        "iterations": f"{iterations.values[-1]:.0f}" if iterations else "",
        "error": readable(float(error.values[-1])) if error else "",
        "changes": str(found) if found or times.size >= 2 * change_points.LEAST else "too few runs",
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

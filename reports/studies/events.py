"""The sections on events: close passages, and transits."""

from __future__ import annotations

from functools import partial

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.studies import flybys, transits
from reports.figures.style.identities import identity
from reports.figures.style.layout import NoData, legend
from reports.results.section import Figure, Section
from reports.tables.study_table import readable_table

MARKS = ("o", "s", "^", "v", "D")  # for ways to look


def misjudged(axes: Axes, frame: pd.DataFrame) -> None:
    """The largest relative error of a distance against the time of a run, with what was missed."""
    rows = frame[frame["largest_relative"] > 0.0] if len(frame) else frame
    if rows.empty:
        raise NoData("nothing was measured.")
    handles, labels = list[Line2D](), list[str]()
    for (contender, looks), some in rows.groupby(["contender", "looks"], sort=False):
        missed = frame[(frame["contender"] == contender) & (frame["looks"] == looks)]["missed"]
        color = identity(str(contender)).style["color"]
        place = sum(one.get_color() == color for one in handles)
        (mark,) = axes.loglog(
            some["seconds"].max(), some["largest_relative"].max(), linestyle="none",
            marker=MARKS[place % len(MARKS)], color=color, markersize=7.0,
        )  # fmt: skip
        handles.append(mark)
        labels.append(f"{contender}, {looks}: {int(np.nansum(missed))} missed")
    axes.set(xlabel="time of a run [s]", ylabel="largest relative error of a distance")
    legend(axes, handles, labels)


FLYBYS_COLUMNS = {
    "contender": "contender",
    "looks": "looks at",
    "target": "target",
    "flybys": "flybys",
    "missed": "missed",
    "median_km": "median error [km]",
    "largest_km": "largest error [km]",
    "largest_relative": "largest relative error",
    "seconds": "time of a run [s]",
    "status": "status",
}

FLYBYS = Section(
    name="flybys",
    title="Flybys that are seen, missed and misjudged",
    text=flybys.EXPLANATION,
    measure=flybys.flybys_table,
    figures=(
        Figure(
            name="flybys",
            title="How wrong the least distance of a flyby is",
            draw=misjudged,
            caption="The worst flyby that was not missed, against the median time of a run.",
        ),
    ),
    table=partial(readable_table, headings=FLYBYS_COLUMNS),
    timed=True,
)

TRANSITS_COLUMNS = {
    "contender": "contender",
    "settings": "setting",
    "transits": "transits",
    "lost": "lost",
    "largest_s": "largest error [s]",
    "seconds": "time [s]",
    "status": "status",
}

TRANSITS = Section(
    name="transits",
    title="Transit times",
    text=transits.EXPLANATION,
    measure=transits.transits_table,
    table=partial(readable_table, headings=TRANSITS_COLUMNS),
    timed=True,
)

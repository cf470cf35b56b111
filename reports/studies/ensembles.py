"""The section on ensembles: lanes, threads and workers, and the ensembles of other codes."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.studies.ensembles import EXPLANATION, ensembles
from reports.figures.style.identities import GUIDE
from reports.figures.style.layout import NoData
from reports.results.section import Figure, Section
from reports.tables.number_format import TIMES, known, readable, seconds


def speed_ups(axes: Axes, frame: pd.DataFrame) -> None:
    """Members per second relative to the first row of the part on scaling."""
    rows = frame[frame["part"] == "scaling"] if len(frame) else frame
    if rows.empty:
        raise NoData("nothing was measured.")
    places = range(len(rows))[::-1]
    axes.barh(list(places), rows["relative"], height=0.6)
    axes.axvline(1.0, color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0)
    axes.set_yticks(list(places), list(rows["contender"]))
    axes.set(xlabel="members per second, relative to one by one")


SCALING = "scaling"
GAINS = {SCALING: "{} faster than one by one", "peers": "{} galvi's"}


def ensembles_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each way to run an ensemble, and the CSS classes of the columns."""
    first = frame["part"] == SCALING
    lines = [_line(row) for row in pd.concat([frame[first], frame[~first]]).to_dict("records")]
    table = pd.DataFrame(lines)
    return table, {name: "number" for name in table.columns if name not in ("members", "by")}


def _line(row: dict[Any, Any]) -> dict[str, str]:
    ratio = f"{readable(row['relative'], 2)}{TIMES}"
    gain = "reference" if row["relative"] == 1.0 else GAINS[row["part"]].format(ratio)
    each, scaling = seconds(1e-6 * row["microseconds"]), row["part"] == SCALING
    return {
        "members": row["problem"],
        "by": row["contender"],
        "settings": row["settings"],
        "error": readable(row["error"]),
        "time": seconds(row["seconds"]),
        "time per member": "" if scaling else each,
        "per step of a member": each if scaling else "",
        "time or gain": gain if known(row["relative"]) else "",
    }


ENSEMBLES = Section(
    name="ensembles",
    title="Ensembles",
    text=EXPLANATION,
    measure=ensembles,
    figures=(
        Figure(
            name="ensembles",
            title="What lanes, threads and workers gain",
            draw=speed_ups,
            caption="Members per second, relative to a run of each by itself in one thread, which "
            "has eight stages to an instruction.",
            size=(6.4, 2.8),
        ),
    ),
    table=ensembles_table,
    timed=True,
)

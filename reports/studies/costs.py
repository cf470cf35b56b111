"""The sections on the cost of runs: of the first one, with many bodies, and in ensembles."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.applications.brownout import cost
from benchmarks.studies import ensembles, start_up
from benchmarks.studies.scaling import MASSIVE_SUFFIX, scaling
from benchmarks.work_precision.fronts import NOT_REACHED
from reports.figures.plots.lines import LONG_DASH
from reports.figures.style.decades import set_decade_ticks
from reports.figures.style.decades import set_readable_ticks as ticks
from reports.figures.style.identities import GUIDE, identity, legend_order
from reports.figures.style.layout import NoData
from reports.results.section import Figure, LongForm, Section
from reports.tables.comparison_tables import is_galvi
from reports.tables.number_format import TIMES, is_finite, readable, seconds
from reports.tables.study_table import readable_table

START_UP_COLUMNS = {
    "problem": "problem",
    "import": "import galvi [s]",
    "cold": "first run, cold [s, processor time]",
    "warm": "first run, warm [s]",
    "import_in_numpys": "import galvi / import numpy",
    "warm_in_numpys": "warm / import numpy",
    "few_steps": "memory, few steps [MiB]",
    "many_steps": "memory, many steps [MiB]",
}

START_UP = Section(
    name="start_up",
    title="The first call in a fresh process, and the memory of long runs",
    text=start_up.EXPLANATION,
    measure=start_up.start_up_table,
    table=partial(readable_table, headings=START_UP_COLUMNS),
    long_form=LongForm(start_up.parts, start_up.stored),
    compared=True,
    timed=True,
)


CLOUD_COLUMNS = {
    "drag": "drag",
    "micrometres": "size [µm]",
    "degree": "degree",
    "grains": "grains",
    "threads": "threads",
    "steps": "steps of all grains",
    "passes": "passes per step",
    "microseconds": "time per step [µs]",
    "single": "step of a single run / this",
    "optical_depth": "optical depth",
    "uncertainty": "standard error",
    "status": "status",
    "commit": "commit",
    "date": "date",
}

BROWNOUT_CLOUD = Section(
    name="brownout_cloud",
    title="The brownout cloud",
    text=cost.EXPLANATION,
    measure=cost.cost_of_clouds,
    table=partial(readable_table, headings=CLOUD_COLUMNS),
    long_form=LongForm(cost.parts, cost.stored),
    timed=True,
)


def seconds_per_orbit(axes: Axes, table: pd.DataFrame) -> None:
    """Draw the time per orbit of each contender's representative run over the number of bodies."""
    rows = _over_bodies(axes, table, "seconds_per_orbit", unit=1e-3)
    low, high = (1e3 * rows[name] for name in ("seconds_low", "seconds_high"))
    colors = [identity(name).color for name in rows["contender"]]
    axes.vlines(rows["bodies"], low, high, colors=colors, linewidth=0.9)
    axes.set(yscale="log", ylabel="time for an orbit of the innermost planet [ms]")
    set_decade_ticks(axes.yaxis)


def share_of_limit(axes: Axes, table: pd.DataFrame) -> None:
    """Draw pairs per second relative to the limit of the divide and square-root units."""
    limit = _over_bodies(axes, table, "share")["limit_pairs_per_second"].max()
    text = f"divisions and square roots alone: {limit / 1e9:.2f} billion pairs per second"
    axes.axhline(1.0, color=GUIDE, linestyle=LONG_DASH, linewidth=1.0, label=text)
    axes.set(ylabel="share of the limit [1]", ylim=(0.0, 1.08))


def _over_bodies(axes: Axes, table: pd.DataFrame, column: str, unit: float = 1.0) -> pd.DataFrame:
    """Draw a column of each contender's representative runs over the number of bodies.

    Marks are hollow if few bodies are heavy. Returns the drawn rows; raises NoData if there are
    none.

    Parameters
    ----------
    unit
        of the vertical axis, in units of the column
    """
    rows = table[(table["matched"] == True) & (table[column] > 0)] if len(table) else table  # noqa: E712
    if rows.empty:
        raise NoData("no run reaches the error of the comparison.")
    rows = rows.sort_values("bodies")
    for name in legend_order(rows["contender"]):
        runs, look = rows[rows["contender"] == name], identity(name)
        face_color = "white" if name.endswith(MASSIVE_SUFFIX) else look.color
        axes.plot(runs["bodies"], runs[column] / unit, label=name, mfc=face_color, **look.style)
    axes.set(xscale="log", xlabel="number of bodies")
    ticks(axes.xaxis)
    return rows


def as_multiple(ratio: float) -> str:
    """A ratio as text, e.g. 9.8 ×; "" if unknown."""
    return f"{readable(ratio, 2)}{TIMES}" if is_finite(ratio) else ""


SCALING_COLUMNS = {
    "bodies": "bodies",
    "contender": "contender",
    "settings": "setting",
    "seconds_per_orbit": "time for an orbit",
    "relative": "relative to galvi",
    "pairs_per_second": "pairs per second",
    "share": "share of the limit",
}
SCALING_FORMATS = {
    "seconds_per_orbit": seconds,
    "relative": as_multiple,
    "pairs_per_second": readable,
    "share": partial(readable, digits=2),
}


def scaling_table(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each number of bodies and contender, and the CSS classes of the columns.

    A line has the representative setting, its time for an orbit of the innermost planet, and that
    time relative to the first galvi method's with as many heavy bodies. If no run reaches the
    error, the reason stands in place of the time: the first status if all runs failed.
    """
    galvi_name, lines = next(filter(is_galvi, table["contender"]), ""), []
    key = ["bodies", "contender"]
    times = table[table["matched"]].set_index(key)["seconds_per_orbit"]
    by_contender = table.sort_values("bodies", kind="stable").groupby(key, sort=False)
    for (bodies, name), rows in by_contender:
        if (bodies, name) in times:
            line = rows[rows["matched"]].iloc[0].to_dict()
            galvi_seconds = times.get(
                (bodies, galvi_name + MASSIVE_SUFFIX * name.endswith(MASSIVE_SUFFIX)), math.nan
            )
            lines.append(line | {"relative": line["seconds_per_orbit"] / galvi_seconds})
        else:
            failed = rows["error"].isna() & (rows["status"] != "")
            why = rows["status"].iloc[0] if failed.all() else NOT_REACHED
            lines.append({"bodies": bodies, "contender": name, "seconds_per_orbit": why})
    headings = SCALING_COLUMNS | {"relative": f"relative to {galvi_name}"}
    return readable_table(pd.DataFrame(lines), headings, SCALING_FORMATS)


NUMBER_OF_BODIES = Section(
    name="scaling",
    title="Number of bodies",
    text="A Sun and light planets on orbits each a tenth wider than the previous one. Each "
    "contender runs at several settings; compared are the fastest runs with every body within "
    "1e-8 au of the reference after 30 orbits of the innermost planet, or 12 in a quick report. "
    "P is its period. The reference is REBOUND IAS15 at its default, against which its own "
    "looser settings are measured too. The limit is the rate of a kernel that only divides and "
    "takes square roots, with the same vector instructions in the same run; a pair needs one of "
    "each. Where 10 are heavy all others are massless: they feel and do not pull, and times are "
    "relative to galvi's with 10 heavy.",
    measure=scaling,
    figures=(
        Figure(
            name="scaling",
            title="Cost against the number of bodies",
            draw=seconds_per_orbit,
            caption="Medians, with the fastest and the slowest round, at matched error. "
            "Blue: galvi; dashed: other codes; hollow: 10 heavy bodies.",
        ),
        Figure(
            name="scaling-share",
            title="Share of the machine's limit",
            draw=share_of_limit,
            caption="Pairs of bodies evaluated per second, for contenders that count them, "
            "relative to the number whose divisions and square roots this machine can do.",
            size=(6.4, 3.2),
        ),
    ),
    table=scaling_table,
    open=True,
    timed=True,
)


SCALING = "scaling"
GAIN_TEXTS = {SCALING: "{} faster than one by one", "peers": "{} galvi's"}
ENSEMBLES_COLUMNS = {
    "problem": "members",
    "contender": "by",
    "settings": "settings",
    "error": "error",
    "seconds": "time",
    "per_member": "time per member",
    "per_step": "per step of a member",
    "gain": "time or gain",
}
ENSEMBLES_FORMATS = {"error": readable} | dict.fromkeys(
    ("seconds", "per_member", "per_step"), seconds
)


def speed_ups(axes: Axes, table: pd.DataFrame) -> None:
    """Draw members per second, relative to the first row of the part on scaling."""
    rows = table[table["part"] == SCALING] if len(table) else table
    if rows.empty:
        raise NoData("nothing was measured.")
    axes.barh(rows["contender"], rows["relative"], height=0.6)
    axes.axvline(1.0, color=GUIDE, linestyle=LONG_DASH, linewidth=1.0)
    axes.invert_yaxis()
    axes.set_xlabel("members per second, relative to one by one")


def ensembles_table(rows: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each method of running an ensemble, and the CSS classes of the columns."""
    rows = rows.sort_values(
        "part", key=lambda part: part != SCALING, kind="stable", ignore_index=True
    )
    per_unit, is_scaling = 1e-6 * rows["microseconds"], rows["part"] == SCALING
    table = rows.assign(
        per_member=per_unit.mask(is_scaling),
        per_step=per_unit.where(is_scaling),
        gain=[_gain(row) for row in rows.to_dict("records")],
    )
    return readable_table(table, ENSEMBLES_COLUMNS, ENSEMBLES_FORMATS)


def _gain(row: Mapping[Any, Any]) -> str:
    ratio = as_multiple(row["relative"])
    return (
        "reference" if row["relative"] == 1.0 else ratio and GAIN_TEXTS[row["part"]].format(ratio)
    )


ENSEMBLES = Section(
    name="ensembles",
    title="Ensembles",
    text=ensembles.EXPLANATION,
    measure=ensembles.ensembles,
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

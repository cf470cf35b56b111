"""The section on cost against the number of bodies, at matched error."""

from __future__ import annotations

from typing import Any

import pandas as pd
from matplotlib.axes import Axes

from benchmarks.studies.scaling import FEW_HEAVY, scaling
from benchmarks.work_precision.fronts import NOT_REACHED
from reports.figures.style.decades import decades
from reports.figures.style.decades import readable as ticks
from reports.figures.style.identities import GUIDE, identity, in_order
from reports.figures.style.layout import NoData
from reports.results.section import Figure, Section
from reports.tables.comparison_tables import is_ours
from reports.tables.number_format import TIMES, known, readable, seconds


def seconds_per_orbit(axes: Axes, frame: pd.DataFrame) -> None:
    """Time per orbit of each contender's representative run against the number of bodies."""
    rows = _chosen(frame, "seconds_per_orbit")
    for name in in_order(frame["contender"]):
        look = identity(name)
        runs = rows[rows["contender"] == name]
        if runs.empty:
            continue
        axes.vlines(
            runs["bodies"], 1e3 * runs["seconds_low"], 1e3 * runs["seconds_high"],
            color=look.color, linewidth=0.9,
        )  # fmt: skip
        axes.plot(runs["bodies"], 1e3 * runs["seconds_per_orbit"], label=name, **_style(name))
    axes.set(
        xscale="log", yscale="log", xlabel="number of bodies",
        ylabel="time for an orbit of the innermost planet [ms]",
    )  # fmt: skip
    ticks(axes.xaxis)
    decades(axes.yaxis)


def share_of_limit(axes: Axes, frame: pd.DataFrame) -> None:
    """Pairs per second relative to the limit set by the divide and square-root units."""
    rows = _chosen(frame, "share")
    for name in in_order(rows["contender"]):
        runs = rows[rows["contender"] == name]
        axes.plot(runs["bodies"], runs["share"], label=name, **_style(name))
    limit = rows["limit_pairs_per_second"].max()
    axes.axhline(
        1.0, color=GUIDE, linestyle=(0, (5, 3)), linewidth=1.0,
        label=f"divisions and square roots alone: {limit / 1e9:.2f} billion pairs per second",
    )  # fmt: skip
    axes.set(
        xscale="log", xlabel="number of bodies", ylabel="share of the limit [1]", ylim=(0.0, 1.08)
    )
    ticks(axes.xaxis)


def _style(name: str) -> dict[str, Any]:
    """The look of a contender; hollow where few bodies are heavy."""
    return identity(name).style | ({"mfc": "white"} if name.endswith(FEW_HEAVY) else {})


def _chosen(frame: pd.DataFrame, column: str) -> pd.DataFrame:
    rows = frame[(frame["matched"] == True) & (frame[column] > 0)] if len(frame) else frame  # noqa: E712
    if rows.empty:
        raise NoData("no run reaches the error of the comparison.")
    return rows.sort_values("bodies")


def scaling_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each number of bodies and contender, and the CSS classes of the columns.

    Its representative setting, its time for an orbit of the innermost planet, and that time
    relative to the first galvi method's with as many heavy bodies.
    """
    contenders = list(frame["contender"].drop_duplicates())
    ours = next((name for name in contenders if is_ours(name)), None)
    lines = []
    for bodies, rows in frame.groupby("bodies", sort=True):
        chosen = {row["contender"]: row for _, row in rows[rows["matched"]].iterrows()}
        for name in rows["contender"].drop_duplicates():
            line = {"bodies": str(bodies), "contender": name}
            if name in chosen:
                row = chosen[name]
                own = chosen.get(f"{ours}{FEW_HEAVY * name.endswith(FEW_HEAVY)}", {})
                least = own.get("seconds_per_orbit", float("nan"))
                line |= {
                    "setting": row["settings"],
                    "time for an orbit": seconds(row["seconds_per_orbit"]),
                    f"relative to {ours}": _times(row["seconds_per_orbit"] / least),
                    "pairs per second": readable(row["pairs_per_second"]),
                    "share of the limit": readable(row["share"], 2),
                }
            else:
                line["time for an orbit"] = _why(rows[rows["contender"] == name])
            lines.append(line)
    table = pd.DataFrame(lines).fillna("")
    return table, {name: "number" for name in table if name not in ("contender", "setting")}


def _times(ratio: float) -> str:
    return f"{readable(ratio, 2)}{TIMES}" if known(ratio) else ""


def _why(rows: pd.DataFrame) -> str:
    """Why a contender has no matched run: the status when all its runs failed."""
    failed = rows["error"].isna() & (rows["status"] != "")
    return str(rows["status"].iloc[0]) if failed.all() else NOT_REACHED


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

"""The section on cost against the number of bodies, at matched error."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies.scaling import scaling
from reports.figures.study_plots.scaling import seconds_per_orbit, share_of_limit
from reports.results.figure import Figure
from reports.results.section import Section
from reports.tables.matched_error import is_ours
from reports.tables.number_format import TIMES, known, readable, seconds

NOBODY = "not reached"


def scaling_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each number of bodies, and the CSS classes of the columns.

    For each contender: its representative setting, its time for an orbit of the innermost planet,
    and that time relative to the first galvi method's.
    """
    contenders = list(frame["contender"].drop_duplicates())
    ours = next((name for name in contenders if is_ours(name)), None)
    lines = []
    for bodies, rows in frame.groupby("bodies", sort=True):
        chosen = {row["contender"]: row for _, row in rows[rows["matched"]].iterrows()}
        least = chosen[ours]["seconds_per_orbit"] if ours in chosen else float("nan")
        line = {"bodies": str(bodies)}
        for name in contenders:
            line[name] = _cell(chosen.get(name), least, name == ours) or _why(
                rows[rows["contender"] == name]
            )
        if ours in chosen:
            line["pairs a second"] = readable(chosen[ours]["pairs_per_second"])
            line["share of the limit"] = readable(chosen[ours]["share"], 2)
        lines.append(line)
    table = pd.DataFrame(lines).fillna("")
    return table, dict.fromkeys(table.columns, "number")


def _cell(row: pd.Series | None, least: float, is_measure: bool) -> str:
    if row is None:
        return ""
    time = f"{seconds(row['seconds_per_orbit'])} ({row['settings']})"
    ratio = row["seconds_per_orbit"] / least
    return time if is_measure or not known(ratio) else f"{readable(ratio, 2)}{TIMES}, {time}"


def _why(rows: pd.DataFrame) -> str:
    """Why a contender has no matched run: the status when all its runs failed, "" when it did not
    take part."""
    if rows.empty:
        return ""
    failed = rows["error"].isna() & (rows["status"] != "")
    return str(rows["status"].iloc[0]) if failed.all() else NOBODY


NUMBER_OF_BODIES = Section(
    name="scaling",
    title="Number of bodies",
    text="A Sun and light planets on orbits each a tenth wider than the previous one. Each "
    "contender runs at several settings; compared are the fastest runs with every body within "
    "1e-8 au of the reference after 30 orbits of the innermost planet (12 in the quick setting). "
    "P is that planet's period. The reference is REBOUND IAS15 at its default, against which its "
    "own looser settings are measured too. The limit is the rate of a kernel that only divides and "
    "takes square roots, with the same vector instructions in the same run; a pair needs one of "
    "each. In the columns of 10 heavy bodies all others are massless: they feel and do not pull.",
    measure=scaling,
    figures=(
        Figure(
            name="scaling",
            title="Cost against the number of bodies",
            draw=seconds_per_orbit,
            caption="Medians, with the fastest and the slowest round, at matched error. "
            "Blue: galvi; dashed: other codes.",
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

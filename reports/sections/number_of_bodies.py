"""The section on cost against the number of bodies, at matched error."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies.scaling import FEW_HEAVY, scaling
from benchmarks.work_precision.fronts import NOT_REACHED
from reports.figures.study_plots.scaling import seconds_per_orbit, share_of_limit
from reports.results.figure import Figure
from reports.results.section import Section
from reports.tables.comparison_tables import is_ours
from reports.tables.number_format import TIMES, known, readable, seconds


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

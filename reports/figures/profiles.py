"""All problems together: the shares of problems that codes solve, against ratio or time."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes

from benchmarks.work_precision.profiles import profile
from reports.figures.style.identities import OURS, colour_of_degree, identity, legend_order
from reports.figures.style.layout import NoData, split
from reports.results.section import Figure
from reports.tables.comparison_tables import heading
from reports.tables.profiles import MIN_PROBLEMS, costs_at

MAX_CODES = 6  # codes in a figure: those with most problems
POINTS = 160  # of a line


def profiles(axes: Axes, runs: pd.DataFrame, *, value: str, xlabel: str) -> None:
    """A panel for each error: shares of problems with their bands, one look per code.

    Parameters
    ----------
    value
        "ratio", from 1, or "cost", in seconds
    """
    tables = {error: table for error, table in costs_at(runs).items() if len(table)}
    costs = pd.concat(tables)
    by_error = costs.groupby([costs.index.get_level_values(0), "code"], sort=False)
    run = by_error["problem"].nunique().unstack()
    solves = costs.loc[np.isfinite(costs["cost"]), "code"]
    names = drawn(run.min(skipna=False).filter(solves.unique()))
    if not names:
        raise NoData(f"no code solves any of {MIN_PROBLEMS} problems.")
    shares = split(axes, len(tables), ylabel="share of a code's problems [1]")
    finite = costs.loc[np.isfinite(costs[value]), value]
    bounds = np.geomspace(finite.min(), 1.2 * finite.max(), POINTS)
    for panel, (error, table) in zip(shares, tables.items(), strict=True):
        panel.set(xscale="log", xlabel=xlabel, ylim=(-0.02, 1.04), title=f"error {heading(error)}")
        for name in names:
            problems = ", ".join(dict.fromkeys(f"{number:.0f}" for number in run[name]))
            color = colour_of_degree(8) if name == OURS else identity(name).color
            low, middle, high = np.array(
                profile(table[table["code"] == name][value], bounds.tolist())
            ).T
            panel.fill_between(bounds, low, high, step="post", color=color, alpha=0.1, lw=0.0)
            panel.plot(
                bounds,
                middle,
                drawstyle="steps-post",
                color=color,
                linestyle=identity(name).dash,
                linewidth=2.2 if name == OURS else 1.3,
                label=f"{name} (of {problems})",
            )


def drawn(counts: pd.Series) -> list[str]:
    """The codes with MIN_PROBLEMS problems or more, at most MAX_CODES, in the order of legends.

    Parameters
    ----------
    counts
        code -> number of problems on which it was run
    """
    chosen = (
        counts[counts >= MIN_PROBLEMS].sort_values(ascending=False, kind="stable").index[:MAX_CODES]
    )
    return legend_order(map(str, chosen))


BANDS = (
    "Bands hold 95 % of the shares when problems are drawn again (bootstrap). In brackets the "
    "number of problems on which a code was run; a problem that it does not solve to the error "
    "counts once, as never, and codes that solve none are in the table alone. Curves of other "
    "problems do not rank two codes: the last column of the table does, on the problems of both. "
    "galvi does neither contacts nor limits, and no such problem is here."
)
PROFILES = (
    Figure(
        name="performance-profiles",
        title="Performance profiles: the share of problems on which a code is within a factor of "
        "the fastest",
        draw=profiles,
        options={"value": "ratio", "xlabel": "time over that of the fastest code [1]"},
        caption=f"At the left edge: how often it is the fastest. {BANDS}",
        size=(9.0, 3.9),
    ),
    Figure(
        name="data-profiles",
        title="Data profiles: the share of problems that a code solves within a time",
        draw=profiles,
        options={"value": "cost", "xlabel": "time to solution [s]"},
        caption="Times do not depend on who else takes part. Bands and brackets as above.",
        size=(9.0, 3.9),
    ),
)

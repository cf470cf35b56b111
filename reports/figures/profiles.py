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
POINTS = 160  # abscissae of a curve


def profiles(axes: Axes, runs: pd.DataFrame, *, value: str, xlabel: str) -> None:
    """A panel for each error: the share of problems that each code solves, with its band.

    Parameters
    ----------
    runs
        the rows of a comparison
    value
        column of `costs_at`: "ratio", from 1, or "cost", in seconds

    Raises
    ------
    NoData
        Where no code was run on MIN_PROBLEMS problems and solves one of them.
    """
    tables = {error: table for error, table in costs_at(runs).items() if len(table)}
    costs = pd.concat(tables) if tables else pd.DataFrame(columns=["code", "problem", "cost"])
    by_error = costs.groupby([costs.index.get_level_values(0), "code"], sort=False)
    problem_counts = by_error["problem"].nunique().unstack()
    solving_codes = costs.loc[np.isfinite(costs["cost"]), "code"].unique()
    names = codes_to_draw(problem_counts.min(skipna=False).filter(solving_codes)) if tables else []
    if not names:
        raise NoData(f"no code that was run on {MIN_PROBLEMS} or more problems solves one.")
    panels = split(axes, len(tables), ylabel="share of a code's problems [1]")
    finite = costs.loc[np.isfinite(costs[value]), value]
    x = np.geomspace(finite.min(), 1.2 * finite.max(), POINTS)
    for panel, (error, table) in zip(panels, tables.items(), strict=True):
        panel.set(xscale="log", xlabel=xlabel, ylim=(-0.02, 1.04), title=f"error {heading(error)}")
        for name in names:
            counts = ", ".join(dict.fromkeys(f"{count:.0f}" for count in problem_counts[name]))
            color = colour_of_degree(8) if name == OURS else identity(name).color
            low, middle, high = np.array(profile(table[table["code"] == name][value], x.tolist())).T
            panel.fill_between(x, low, high, step="post", color=color, alpha=0.1, lw=0.0)
            panel.plot(
                x,
                middle,
                drawstyle="steps-post",
                color=color,
                linestyle=identity(name).dash,
                linewidth=2.2 if name == OURS else 1.3,
                label=f"{name} (of {counts})",
            )


def codes_to_draw(counts: pd.Series) -> list[str]:
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
    "Bands are 95 % intervals over the choice of problems (bootstrap; where a share is 0 or 1, up "
    "to the share that would still give it with a probability of 2.5 %). In brackets the number of "
    f"problems on which a code was run. Drawn are the {MAX_CODES} codes with the most problems, at "
    f"least {MIN_PROBLEMS} at each error, that solve one; the table has the others. A problem that "
    "a code does not solve to the error counts as unsolved at any time. Curves over different "
    "problems do not rank two codes; the last column of the table compares each code with galvi on "
    "the problems of both. galvi models neither contacts nor joint limits, and no problem has them."
)
PROFILES = (
    Figure(
        name="performance-profiles",
        title="Performance profiles: the share of problems on which a code is within a factor of "
        "the fastest",
        draw=profiles,
        options={"value": "ratio", "xlabel": "time over that of the fastest code [1]"},
        caption=f"At the left edge: how often a code is the fastest. {BANDS}",
        size=(9.0, 3.9),
    ),
    Figure(
        name="data-profiles",
        title="Data profiles: the share of problems that a code solves within a time",
        draw=profiles,
        options={"value": "cost", "xlabel": "time to solution [s]"},
        caption=f"Times do not depend on which other codes are compared. {BANDS}",
        size=(9.0, 3.9),
    ),
)

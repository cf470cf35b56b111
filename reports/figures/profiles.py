"""All problems together: the shares of problems that codes solve, against ratio or time."""

from __future__ import annotations

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.lines import Line2D

from benchmarks.work_precision.profiles import profile
from reports.figures.style.decades import decades
from reports.figures.style.identities import OURS, blue, identity, in_order
from reports.figures.style.layout import NoData, legend, panels, share_y_label
from reports.results.section import Figure
from reports.tables.comparison_tables import heading
from reports.tables.profiles import FEWEST, costs_at

MOST = 6  # codes in a figure: those with most problems
POINTS = 160  # of a line


def profiles(axes: Axes, frame: pd.DataFrame, *, value: str, xlabel: str) -> None:
    """A panel for each error: shares of problems with their bands, one look per code.

    value  "ratio", from 1, or "cost", in seconds
    """
    found = {error: table for error, table in costs_at(frame).items() if len(table)}
    if not found:
        raise NoData("nothing was run to these errors.")
    whole = pd.concat(found.values())
    each = [table.groupby("code")["problem"].nunique() for table in found.values()]
    counts = pd.concat(each, axis=1).min(axis=1, skipna=False).dropna().astype(int)
    solve = whole.loc[np.isfinite(whole["cost"]), "code"].unique()
    names = drawn(counts[counts.index.isin(solve)])
    if not names:
        raise NoData(f"no code solves any of {FEWEST} problems.")
    places = panels(axes, len(found))
    share_y_label(places, "share of a code's problems [1]")
    known = whole.loc[np.isfinite(whole[value]), value]
    bounds = np.geomspace(known.min(), 1.2 * known.max(), POINTS)
    for one, (error, table) in zip(places, found.items(), strict=True):
        one.set(xscale="log", xlabel=xlabel, ylim=(-0.02, 1.04), title=f"error {heading(error)}")
        for name in names:
            color, style = _look(name)
            shares = np.array(profile(table[table["code"] == name][value], bounds.tolist()))
            low, middle, high = shares.T
            one.fill_between(bounds, low, high, step="post", color=color, alpha=0.1, lw=0.0)
            one.plot(bounds, middle, drawstyle="steps-post", **style)
        decades(one.xaxis)
    lines = [Line2D([], [], **_look(name)[1]) for name in names]
    legend(one, lines, [f"{name} (of {_numbers(name, each)})" for name in names])


def _numbers(name: str, each: list[pd.Series]) -> str:
    """Of problems, in the panels' order; one where they are the same."""
    return ", ".join(dict.fromkeys(str(one[name]) for one in each))


def drawn(counts: pd.Series) -> list[str]:
    """The codes with FEWEST problems or more, at most MOST, in the order of legends.

    counts  code -> number of problems on which it was run
    """
    chosen = counts[counts >= FEWEST].sort_values(ascending=False, kind="stable").index[:MOST]
    return in_order(map(str, chosen))


def _look(name: str) -> tuple[str, dict[str, object]]:
    """Colour, and keywords of a line without markers."""
    look, ours = identity(name), name == OURS
    color = blue(8) if ours else look.color
    return color, {"color": color, "linestyle": look.dash, "linewidth": 2.2 if ours else 1.3}


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

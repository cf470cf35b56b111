"""The section on trees of rigid bodies: orders and times of a step beside MuJoCo's."""

from __future__ import annotations

import math

import pandas as pd

from benchmarks.statistics.convergence_fits import Fit, algebraic
from benchmarks.studies.trees import EXPLANATION, tree_study
from reports.results.section import Section
from reports.tables.number_format import readable, seconds, with_uncertainty

ASKED = 1e-6  # error of the last column
ROUND_OFF = 1e-13


def orders(frame: pd.DataFrame) -> dict[tuple[str, str], Fit]:
    """The fitted order of each integrator on each tree, above ten times the truth's own error."""
    return {
        (str(problem), str(contender)): algebraic(
            list(rows["step"]),
            list(rows["error"]),
            floor=10.0 * float(rows["unsure"].iloc[0]) + ROUND_OFF,
        )
        for (problem, contender), rows in frame.groupby(["problem", "contender"], sort=False)
    }


def trees_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each tree and integrator, and the CSS classes of the columns."""
    if frame["problem"].isna().all():
        return frame[["status"]], {}
    lines = []
    for (problem, contender), fit in orders(frame).items():
        rows = frame[(frame["problem"] == problem) & (frame["contender"] == contender)]
        coarse, fine = rows.iloc[0], rows.iloc[-1]
        each = float(fine["seconds_per_step"])
        step = (ASKED / fit.coefficient) ** (1.0 / fit.rate) if fit.points else math.nan
        lines.append({
            "tree": problem,
            "integrator": contender,
            "order": f"{coarse['order']:g}",
            "measured": with_uncertainty(fit.rate, fit.uncertainty),
            "step, coarse": readable(coarse["step"]),
            "error": readable(coarse["error"]),
            "step, fine": readable(fine["step"]),
            "error then": readable(fine["error"]),
            "time per step": seconds(each),
            f"time to {ASKED:g}": seconds(each * fine["step"] * fine["steps"] / step),
        })  # fmt: skip
    table = pd.DataFrame(lines)
    return table, {name: "number" for name in table if name not in ("tree", "integrator")}


TREES = Section(
    name="trees",
    title="Trees of rigid bodies",
    text=EXPLANATION,
    measure=tree_study,
    table=trees_table,
    timed=True,
)

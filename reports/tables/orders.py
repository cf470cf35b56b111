"""Orders of a user's methods, as sentences, CSV, Markdown and LaTeX."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.applications.convergence.table import remarks
from benchmarks.statistics.orders import ROUND_OFF
from benchmarks.work_precision.problem import Truth
from galvi import Problem
from reports.tables.latex import caption_of
from reports.tables.number_format import concise, is_finite, plain
from reports.tables.writing import write_table

DEFECTS = {"symmetry": "symmetry defect", "symplecticity": "symplectic defect"}
READABLE_COLUMNS = ("method", "h", "error", "order", "fit", "energy", "momentum", "seconds")


@dataclass(frozen=True, eq=False)
class OrderTable:
    """The rows of `benchmarks.applications.convergence.table`, with their problem and truth.

    Attributes
    ----------
    faults
        sentences on the faults of integrators
    origin
        versions, machine and date
    """

    rows: pd.DataFrame
    problem: Problem
    duration: float
    truth: Truth
    faults: Sequence[str]
    origin: Mapping[str, str]

    def fits(self) -> pd.DataFrame:
        """A line for each method with equal steps: its order, the window of the fit, the largest
        defects within it, and the largest error that is round-off."""
        lines = []
        for method, rows in self.rows[self.rows["h"].notna()].groupby("method", sort=False):
            used = rows[rows["fit"]]
            steps = f"{plain(used['h'].max())} to {plain(used['h'].min())}" if len(used) else ""
            lines.append(
                {
                    "method": method,
                    "theory": rows["theory"].iloc[0],
                    "fitted": rows["fitted"].iloc[0],
                    "fitted_se": rows["fitted_se"].iloc[0],
                    "steps": steps,
                    "points": len(used),
                    "symmetry": used["symmetry"].max(),
                    "symplecticity": used["symplecticity"].max(),
                    "round-off": rows.loc[rows["note"] == ROUND_OFF, "error"].max(),
                }
            )
        return pd.DataFrame(lines)


def sentences(table: OrderTable) -> Iterator[str]:
    """Sentences for a terminal on the truth, the order of each method, remarks and faults."""
    name = table.problem.name or "the problem"
    yield (
        f"{name}, T = {table.duration:g}. Truth: {table.truth.description} "
        f"({plain(table.truth.error, 2)})."
    )
    for _, line in table.fits().iterrows():
        if is_finite(line["fitted"]):
            order = concise(line["fitted"], line["fitted_se"])
            theory = f" (of theory {line['theory']:g})" if is_finite(line["theory"]) else ""
            yield (
                f"{line['method']}: order {order}{theory}, steps {line['steps']}, "
                f"{line['points']} points"
            )
        else:
            yield f"{line['method']}: too few errors show an order; `note` says why"
    yield from remarks(table.rows)
    yield from table.faults


def caption(table: OrderTable, subject: str) -> str:
    """A caption with a subject, the problem, the truth, and the origin of the measurement."""
    name = table.problem.name or "a problem"
    origin = caption_of("", table.origin).removeprefix(". ")
    return (
        f"{subject} on {name}, T = {table.duration:g}; errors of the state at the end. Truth: "
        f"{table.truth.description}. {origin}"
    ).strip()


def write_orders(table: OrderTable, folder: Path) -> list[Path]:
    """Write convergence.csv with all rows, and orders.csv with a line for each method.

    Both are also written as Markdown and LaTeX, without columns that are empty. Returns the paths.
    """
    fits = table.fits()
    rows = table.rows.assign(fit=["yes" if used else "" for used in table.rows["fit"]])
    methods = rows[list(READABLE_COLUMNS)].dropna(axis="columns", how="all")
    orders = fits.drop(columns="points").rename(columns=DEFECTS).dropna(axis="columns", how="all")
    files = write_table(
        folder, "convergence", table.rows, methods, caption=caption(table, "Methods")
    )
    return files + write_table(
        folder, "orders", fits, orders, caption=caption(table, "Orders of methods")
    )

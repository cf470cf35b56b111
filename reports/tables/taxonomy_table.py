"""Which method every space and rule makes, as text for the page."""

from __future__ import annotations

import re

import pandas as pd

from benchmarks.studies.taxonomy import METHOD
from reports.tables.number_format import known, readable

EVERY_RULE, ONE_RULE = "Polynomials", "Gauss"
APART = 0.3  # of a measured order from the predicted one, from which both are told


def space_label(space: str) -> str:
    """`PolynomialFourier(1, harmonics=2, ω=2π)`: shorter than what makes it."""
    short = re.sub(r"=6\.28318530717958\d*", "=2π", space).replace("frequency", "ω")
    return short.replace("degree=", "").replace(".0", "")


def short_name(name: str) -> str:
    """Without the number of stages, which the place in the table tells."""
    return name.partition(",")[0]


def taxonomy_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each space and family of rules, a column for each number of points; and how to set
    the columns. Polynomials have a line for every family, other spaces one with Gauss's rules.

    A cell has the measured order and the classical name, or why there is no method. The last
    columns are the range of C_N and the largest defects over the line's methods.
    """
    lines, numbers = [], sorted(set(frame["points"])) if len(frame) else []
    frame = frame[(frame["kind"] == EVERY_RULE) | (frame["family"] == ONE_RULE)]
    for (space, family), rows in frame.groupby(["space", "family"], sort=False):
        cells = {row["points"]: _cell(row) for _, row in rows.iterrows()}
        made = rows[rows["verdict"] == METHOD]
        lines.append(
            {
                "space": space_label(str(space)),
                "rule": family,
                **{_heading(points): cells.get(points, "-") for points in numbers},
                "C_N": _range(made["C_N"]),
                "symplectic to": readable(made["symplecticity"].max(), 2),
                "there and back": readable(made["symmetry"].max(), 2),
            }
        )
    return pd.DataFrame(lines), dict.fromkeys(("C_N", "symplectic to", "there and back"), "number")


def _heading(points: int) -> str:
    return f"{points} point{'s' if points > 1 else ''}"


def _cell(row: pd.Series) -> str:
    if row["verdict"] != METHOD:
        return str(row["verdict"])
    order, predicted = row["measured"], row["predicted"]
    if not known(order):
        text = f"not measured, predicted {predicted}"
    elif abs(order - predicted) > APART:
        text = f"{order:.1f}, predicted {predicted}"
    else:
        text = f"{order:.1f}"
    return " ".join(filter(None, (text, short_name(row["name"]))))


def _range(values: pd.Series) -> str:
    """The least and the largest, once when they are the same."""
    ends = [readable(value) for value in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(end for end in ends if end))

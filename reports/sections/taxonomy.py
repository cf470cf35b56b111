"""The section on the methods given by every pair of space and rule."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies import taxonomy
from benchmarks.studies.taxonomy import METHOD
from reports.figures.study_plots.taxonomy_matrix import short_name, space_label, taxonomy_matrix
from reports.results.figure import Figure
from reports.results.section import Section
from reports.tables.number_format import known, readable

EVERY_RULE, ONE_RULE = "Polynomials", "Gauss"
APART = 0.3  # difference of measured and predicted order from which both are shown


def taxonomy_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each space and family of rules, a column for each number of points; and the CSS
    classes of the columns. Polynomials have a line per family, other spaces one with Gauss's rules.

    A cell holds the measured order and the classical name, or why there is no method. The last
    columns are the range of C_N and the largest defects over the methods of the line.
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
    """The least and the largest value as text; one number when they are equal."""
    ends = [readable(value) for value in (values.min(), values.max())]
    return " to ".join(dict.fromkeys(end for end in ends if end))


TAXONOMY = Section(
    name="taxonomy",
    title="Spaces and rules",
    text="Every space combined with every rule. A pair is ill-posed when a free particle has no "
    "unique motion, because the rule does not see some function of the space, and inconsistent "
    "when its unique motion is not a straight line. The picture shows every pair; the table shows "
    "polynomials with every family of rules, and the other spaces with Gauss's; all pairs with all "
    "numbers are in taxonomy.csv. Along a line: with too few points there is no method, then the "
    "rule limits the order, and from some number of points on the order is twice the largest "
    "degree of the polynomials in the space. Slopes that jump between pieces need rules without a "
    "node there; waves, of frequency ω in radians per step, need many points and do not change "
    "the order. Orders are measured on the Kepler problem, e = 0.3, against its closed form; C_N "
    'is the constant of M (11); "symplectic to" is the largest defect of DF^T J DF = J, and '
    '"there and back" the error after eight steps of 0.25 forwards and as many backwards, which '
    "is round-off for a symmetric method.",
    measure=taxonomy.taxonomy,
    figures=(
        Figure(
            name="taxonomy",
            title="Measured order of the method given by a space and a rule",
            draw=taxonomy_matrix,
            caption="Below the order, the classical name where there is one: IM implicit midpoint, "
            "SV Stormer-Verlet, SE symplectic Euler, G Gauss collocation, L Lobatto IIIA-IIIB, R "
            "Radau IIA-II; 3IM, 3G: three steps of it in one.",
            size=(11.0, 5.8),
            least=6.9,
        ),
    ),
    table=taxonomy_table,
)

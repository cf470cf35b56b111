"""The section on the methods that follow from each pair of space and rule."""

from __future__ import annotations

import math
import re
from typing import Any

import numpy as np
import pandas as pd
from matplotlib.axes import Axes
from matplotlib.cm import ScalarMappable
from matplotlib.colors import Normalize
from matplotlib.patches import Rectangle

from benchmarks.studies import taxonomy
from benchmarks.studies.taxonomy import ILL_POSED, INCONSISTENT, METHOD
from reports.figures.style.layout import NoData, split
from reports.results.section import Figure, Section
from reports.tables.number_format import is_finite, readable

ABBREVIATIONS = {
    "implicit midpoint": "IM",
    "Stormer-Verlet": "SV",
    "Gauss collocation": "G",
    "Lobatto IIIA-IIIB": "L",
    "Radau IIA-II": "R",
    "symplectic Euler": "SE",
}
CELL_INCHES = 0.3  # inches, width and height of a cell
LABEL_INCHES = 2.4  # inches beside the cells
VERTICAL_MARGIN = 0.9  # inches above and below the cells together
STYLE_OF_VERDICT = {
    ILL_POSED: {"hatch": "xxxx", "facecolor": "#f3f3f3"},
    INCONSISTENT: {"hatch": "////", "facecolor": "#ffffff"},
}
SHADES = ScalarMappable(Normalize(-1.5, 11.0), "Blues")  # of orders; without its darkest and palest
DARK_FROM_ORDER = 5.5  # order from which a shade needs white letters


def taxonomy_matrix(axes: Axes, table: pd.DataFrame) -> None:
    """Draw a panel for each family of rules: a row for each space, a column for each number of
    points.

    Colour and number of a cell show the measured order, letters below it the classical name. Raises
    NoData without a measured order.
    """
    if table.empty or table["measured"].isna().all():
        raise NoData("no method has a measured order.")
    spaces = list(table["space"].unique())
    families = list(table.groupby("family", sort=False))
    widest = table.groupby("family")["points"].nunique().max()
    canvas = axes.get_figure(root=True)
    columns = max(1, int((canvas.get_figwidth() - LABEL_INCHES) / (CELL_INCHES * widest)))
    rows = math.ceil(len(families) / columns)
    matrices = split(axes, len(families), columns=math.ceil(len(families) / rows))
    canvas.set_figheight(rows * (CELL_INCHES * len(spaces) + VERTICAL_MARGIN))
    for matrix, (family, pairs) in zip(matrices, families, strict=True):
        point_counts = sorted(pairs["points"].unique())
        for pair in pairs.itertuples():
            _draw_cell(matrix, point_counts.index(pair.points), spaces.index(pair.space), pair)
        labelled = spaces if matrix.get_subplotspec().is_first_col() else []
        matrix.set(
            title=family,
            xlabel="points of the rule",
            xlim=(0, widest),
            ylim=(len(spaces), 0),
            xticks=np.arange(len(point_counts)) + 0.5,
            xticklabels=point_counts,
            yticks=np.arange(len(labelled)) + 0.5,
            yticklabels=list(map(space_label, labelled)),
        )
        matrix.tick_params(length=0.0)
        matrix.grid(False)
        matrix.spines[:].set_visible(False)


def _draw_cell(axes: Axes, x: int, y: int, pair: Any) -> None:
    """Draw the cell of a pair in column x and row y."""
    if pair.verdict != METHOD:
        look = {"edgecolor": "#c4c4c4", "linewidth": 0.0, **STYLE_OF_VERDICT[pair.verdict]}
        axes.add_patch(Rectangle((x, y), 1.0, 1.0, label=pair.verdict, **look))
        return
    is_measured = np.isfinite(pair.measured)
    color = SHADES.to_rgba(pair.measured) if is_measured else "white"
    axes.add_patch(Rectangle((x, y), 1.0, 1.0, facecolor=color, edgecolor="white"))
    text = f"{pair.measured:.0f}" if is_measured else "?"
    ink = "white" if pair.measured > DARK_FROM_ORDER else "#222222"
    style = {"color": ink, "ha": "center", "va": "center"}
    axes.text(x + 0.5, y + (0.32 if pair.name else 0.5), text, fontsize=8.5, **style)
    axes.text(x + 0.5, y + 0.74, abbreviation(pair.name), fontsize=7.0, **style)


def abbreviation(name: str) -> str:
    """The abbreviation of a classical name: `IM`, `3IM` for three steps of it, or its initials."""
    count, method = re.fullmatch(r"(?:(\d+) steps of )?(.*)", short_name(name)).groups("")
    return count + ABBREVIATIONS.get(method, "".join(word[0] for word in method.split()))


def space_label(space: str) -> str:
    """An abbreviated `repr`, e.g. `PolynomialFourier(1, harmonics=2, ω=2π)`."""
    short = re.sub(r"=6\.28318530717958\d*", "=2π", space).replace("frequency", "ω")
    return short.replace("degree=", "").replace(".0", "")


def short_name(name: str) -> str:
    """The name without the number of stages, which the column shows."""
    return name.partition(",")[0]


ALL_RULES_KIND, COMMON_FAMILY = "Polynomials", "Gauss"
ORDER_GAP = 0.3  # difference of measured and predicted order from which both are shown


def taxonomy_table(table: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each space and family of rules, a column for each number of points; and the CSS
    classes of the columns.

    Polynomials have a line for each family, other spaces one for Gauss's rules. A cell holds the
    measured order and the classical name, or the reason why there is no method. The last columns
    are the range of C_N and the largest defects over the methods of the line.
    """
    table = table[(table["kind"] == ALL_RULES_KIND) | (table["family"] == COMMON_FAMILY)]
    lines, point_counts = [], sorted(table["points"].unique())
    for (space, family), rows in table.groupby(["space", "family"], sort=False):
        cells = {row["points"]: _cell_text(row) for _, row in rows.iterrows()}
        methods = rows[rows["verdict"] == METHOD]
        lines.append(
            {
                "space": space_label(str(space)),
                "rule": family,
                **{_heading(points): cells.get(points, "-") for points in point_counts},
                "C_N": _range(methods["C_N"]),
                "symplectic to": readable(methods["symplecticity"].max(), 2),
                "there and back": readable(methods["symmetry"].max(), 2),
            }
        )
    return pd.DataFrame(lines), dict.fromkeys(("C_N", "symplectic to", "there and back"), "number")


def _heading(points: int) -> str:
    return f"{points} point{'s' if points > 1 else ''}"


def _cell_text(row: pd.Series) -> str:
    if row["verdict"] != METHOD:
        return str(row["verdict"])
    order, predicted = row["measured"], row["predicted"]
    text = f"{order:.1f}" if is_finite(order) else "not measured"
    if not abs(order - predicted) <= ORDER_GAP:
        text += f", predicted {predicted}"
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
            min_width=6.9,
        ),
    ),
    table=taxonomy_table,
)

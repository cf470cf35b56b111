"""The section on the methods given by every pair of space and rule."""

from __future__ import annotations

import re

import numpy as np
import pandas as pd
from matplotlib import colormaps
from matplotlib.axes import Axes
from matplotlib.colors import Colormap
from matplotlib.patches import Patch, Rectangle

from benchmarks.studies import taxonomy
from benchmarks.studies.taxonomy import ILL_POSED, INCONSISTENT, METHOD
from reports.figures.style.identities import GUIDE
from reports.figures.style.layout import NoData, legend, split
from reports.results.section import Figure, Section
from reports.tables.number_format import known, readable

CODES = {
    "implicit midpoint": "IM",
    "Stormer-Verlet": "SV",
    "Gauss collocation": "G",
    "Lobatto IIIA-IIIB": "L",
    "Radau IIA-II": "R",
    "symplectic Euler": "SE",
}
GAP = 0.6  # between families, in cells
CELL, LABELS, ABOVE_AND_BELOW = 0.3, 2.4, 0.9  # inches: of a cell, and around them
HATCHES = {ILL_POSED: ("xxxx", "#f3f3f3"), INCONSISTENT: ("////", "#ffffff")}
HIGHEST = 10.0  # order that has the darkest colour


def taxonomy_matrix(axes: Axes, frame: pd.DataFrame) -> None:
    """A row for each space, a column for each rule, in groups by family; several such tables below
    one another where the columns do not fit.

    Colour and number are the measured order; letters below it the classical name.
    """
    if frame.empty or not np.any(np.isfinite(frame["measured"].to_numpy(float))):
        raise NoData("no method has a measured order.")
    spaces = list(dict.fromkeys(frame["space"]))
    blocks = _blocks(frame, axes.figure.get_figwidth())
    axes.figure.set_figheight(len(blocks) * (CELL * len(spaces) + ABOVE_AND_BELOW))
    parts = [frame[frame["family"].isin(families)] for families in blocks]
    widest = max(max(_columns(part)[0].values()) for part in parts)
    for one, part in zip(split(axes, len(parts), columns=1), parts, strict=True):
        _block(one, part, spaces)
        one.set_xlim(-0.1, widest + 1.1)
    handles = [
        Patch(facecolor=color, hatch=hatch, edgecolor=GUIDE, linewidth=0.4, label=verdict)
        for verdict, (hatch, color) in HATCHES.items()
    ]
    legend(one, handles, list(HATCHES))


def _blocks(frame: pd.DataFrame, width: float) -> list[list[str]]:
    """Families that fit beside one another, in columns of the width of a cell."""
    blocks: list[list[str]] = []
    room = 0.0
    for family, rows in frame.groupby("family", sort=False):
        need = CELL * (rows["points"].nunique() + GAP)
        if need > room:
            blocks.append([])
            room = max(width - LABELS, need)
        blocks[-1].append(str(family))
        room -= need
    return blocks


def _block(axes: Axes, frame: pd.DataFrame, spaces: list[str]) -> None:
    places, middles = _columns(frame)
    colors = colormaps["Blues"]
    for _, row in frame.iterrows():
        x, y = places[row["family"], row["points"]], float(spaces.index(row["space"]))
        _square(axes, x, y, row, colors)
    axes.set_ylim(len(spaces) + 0.1, -1.1)
    axes.set_yticks([k + 0.5 for k in range(len(spaces))], [space_label(name) for name in spaces])
    points = {x + 0.5: str(number) for (_, number), x in places.items()}
    axes.set_xticks(list(points), list(points.values()))
    axes.set_xlabel("points of the rule, on each piece of the space")
    axes.tick_params(length=0.0)
    axes.grid(False)
    for side in ("left", "bottom"):
        axes.spines[side].set_visible(False)
    for family, middle in middles.items():
        axes.text(middle, -0.35, family, ha="center", va="bottom", fontweight="bold")


def code(name: str) -> str:
    """A name in two or three letters: `IM`, `3IM` for three steps of it, initials when unknown."""
    short = short_name(name)
    several = re.fullmatch(r"(\d+) steps of (.+)", short)
    if several:
        return several[1] + code(several[2])
    return CODES.get(short, "".join(word[0] for word in short.split()))


def _columns(frame: pd.DataFrame) -> tuple[dict[tuple[str, int], float], dict[str, float]]:
    """The left edge of each (family, points), and the middle of each family."""
    places: dict[tuple[str, int], float] = {}
    middles: dict[str, float] = {}
    x = 0.0
    for family in dict.fromkeys(frame["family"]):
        numbers = sorted(set(frame.loc[frame["family"] == family, "points"]))
        for number in numbers:
            places[family, number] = x
            x += 1.0
        middles[family] = x - 0.5 * len(numbers)
        x += GAP
    return places, middles


def _square(axes: Axes, x: float, y: float, row: pd.Series, colors: Colormap) -> None:
    if row["verdict"] != METHOD:
        hatch, color = HATCHES[row["verdict"]]
        axes.add_patch(
            Rectangle((x, y), 1.0, 1.0, facecolor=color, hatch=hatch, edgecolor="#c4c4c4",
                      linewidth=0.0)
        )  # fmt: skip
        return
    order = float(row["measured"])
    finite = np.isfinite(order)
    color = colors(0.12 + 0.8 * min(order / HIGHEST, 1.0)) if finite else "white"
    axes.add_patch(Rectangle((x, y), 1.0, 1.0, facecolor=color, edgecolor="white", linewidth=1.0))
    ink = "white" if finite and order > 0.55 * HIGHEST else "#222222"
    name = code(row["name"]) if row["name"] else ""
    text = f"{order:.0f}" if finite else "?"
    axes.text(x + 0.5, y + (0.32 if name else 0.5), text, color=ink, fontsize=8.5, ha="center",
              va="center")  # fmt: skip
    axes.text(x + 0.5, y + 0.74, name, color=ink, fontsize=7.0, ha="center", va="center")


def space_label(space: str) -> str:
    """An abbreviated `repr`, e.g. `PolynomialFourier(1, harmonics=2, ω=2π)`."""
    short = re.sub(r"=6\.28318530717958\d*", "=2π", space).replace("frequency", "ω")
    return short.replace("degree=", "").replace(".0", "")


def short_name(name: str) -> str:
    """The name without the number of stages, which the column shows."""
    return name.partition(",")[0]


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

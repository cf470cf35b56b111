"""The colour, marker and dash of every contender, the same in all figures.

A row of TABLE is a family: all names that begin with its text. Legends have the order of the rows.
galvi's own methods, with a clock, too, have blues that darken with the degree, the markers of
MARKER_OF_DEGREE, and the dashes of their charts. A name that no row matches has a colour of
SPARE_COLOURS.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np
from matplotlib.colors import LinearSegmentedColormap, to_hex

from galvi.charts import CHARTS

# Okabe and Ito (2008), without the yellow, which is too light for a white page.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
GUIDE = "#777777"  # claimed rates and other lines that were not measured
SUN = "#E69F00"
BAND = "#eef3f7"

SOLID, DASHED, DASH_DOT, DOTTED = "-", (0, (4, 2)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.4))
OURS, FRAME, CLOCK = "galvi", "galvi Kepler frame", "galvi clock"
DEGREE_PREFIX = "N ="  # beginning of the names of claims' studies of galvi's method of that degree
MAX_NAMES = 8  # largest number of names with an entry each in a legend, see `legend_groups`
DASH_OF_VARIANT = {  # text after the last comma of a name -> its dash
    "GLOBAL": DOTTED,
    "looser": DASH_DOT,
    "default": DOTTED,
    "native": DOTTED,
}

# family -> (colour, marker, dash); colours after Okabe and Ito (2008), and Tol (2021)
TABLE: dict[str, tuple[str, str, Any]] = {
    FRAME: ("#1414E6", "*", SOLID),
    CLOCK: ("#3A8FE0", "o", SOLID),
    "REBOUND IAS15": ("#009E73", "s", DASHED),
    "REBOUND WHFast512": ("#E69F00", "D", DASHED),
    "REBOUND WHFast": ("#8C5A2B", "v", DASHED),
    "REBOUND SABA": ("#CC79A7", "P", DASHED),
    "REBOUND BS": ("#7F3F98", "X", DASHED),
    "REBOUND TRACE": ("#A68A00", "<", DASHED),
    "REBOUND MERCURIUS": ("#D4699E", ">", DASHED),
    "MuJoCo RK4": ("#C2124B", "o", DASHED),
    "MuJoCo Euler": ("#F08A9B", "X", DOTTED),
    "MuJoCo implicitfast": ("#F6B3BE", "<", DOTTED),
    "MuJoCo implicit": ("#E05A78", ">", DOTTED),
    "MuJoCo discrete": ("#8E3B52", "d", DOTTED),
    "heyoka": ("#D55E00", "^", DASHED),
    "DOP853 on quaternions, compiled": ("#8A8A00", "p", DASHED),
    "RK4 on quaternions, compiled": ("#5DBB3F", "h", DASHED),
    "SciPy DOP853": ("#444444", "D", DASH_DOT),
    "SciPy RK45": ("#9A4FB5", "<", DASH_DOT),
    "RK45": ("#9A4FB5", "<", DASH_DOT),
    "Stormer-Verlet": ("#00879E", "v", DOTTED),
    "symplectic Euler": ("#5B8C85", "X", DOTTED),
    "semi-implicit Euler": ("#5B8C85", "X", DOTTED),
    "explicit Euler": ("#B2480E", "P", DOTTED),
    "implicit Euler": ("#7F7F7F", "s", DOTTED),
}
BLUES = LinearSegmentedColormap.from_list("galvi", ("#8CC7EF", "#3A8FE0", "#1B4FA8", "#000A28"))
MARKER_OF_DEGREE = {2: "v", 4: "^", 5: "<", 6: "s", 7: ">", 8: "o", 10: "D", 12: "P", 16: "X"}
SPARE_COLOURS = ("#5A2A82", "#B8860B", "#2E6E2E", "#A0527A", "#20606E", "#7A1F1F")
CHART_DASHES = (  # of galvi's charts, in their order
    ("solid", SOLID),
    ("dash-dotted", (0, (6, 1.5, 1, 1.5))),
    ("dotted", (0, (1, 1.5))),
    ("dash-dot-dotted", (0, (6, 1.5, 1, 1.5, 1, 1.5))),
)
DASH_OF_CHART = {chart.name: dash for chart, (_, dash) in zip(CHARTS, CHART_DASHES, strict=False)}
CHART_LEGEND = "lines by chart: " + ", ".join(
    f"{dash} {chart.name}" for chart, (dash, _) in zip(CHARTS, CHART_DASHES, strict=False)
)


class Identity(NamedTuple):
    """The colour, marker and dash of a name.

    Attributes
    ----------
    family
        the row of TABLE, or OURS, by which a legend groups names
    """

    family: str
    color: str
    marker: str
    dash: Any

    @property
    def style(self) -> dict[str, Any]:
        """Keywords of `Axes.plot`."""
        return {"color": self.color, "marker": self.marker, "linestyle": self.dash}


def identity(name: str) -> Identity:
    """The identity of a contender's name, which does not depend on the other names of a figure."""
    family = next((row for row in TABLE if name.startswith(row)), name.partition(",")[0])
    ending = name.rpartition(", ")[2]
    if family == FRAME:
        points = re.search(r"Gauss (\d+)", name)
        marker = "*" if points is None or int(points[1]) < 12 else "P"
        return Identity(FRAME, TABLE[FRAME][0], marker, DOTTED if "passes" in name else SOLID)
    if name.startswith((OURS, DEGREE_PREFIX)):
        number = re.search(r"(?:degree|Gauss|N =) (\d+)", name)
        degree = int(number[1]) if number else 8
        dash = DASH_DOT if ending == "general kernel" else DASH_OF_CHART.get(ending, SOLID)
        family = CLOCK if name.startswith(CLOCK) else OURS
        return Identity(family, colour_of_degree(degree), MARKER_OF_DEGREE.get(degree, "o"), dash)
    spare = SPARE_COLOURS[
        sum(family.encode()) % len(SPARE_COLOURS)
    ]  # no hash: that differs between processes
    color, marker, dash = TABLE.get(family, (spare, "h", DASHED))
    return Identity(family, color, marker, DASH_OF_VARIANT.get(ending, dash))


def line_color(name: str, index: int) -> str:
    """The colour of a line: that of its contender, if it is galvi or in TABLE; else COLOURS by
    index."""
    look = identity(name)
    return look.color if look.family in (OURS, *TABLE) else COLOURS[index % len(COLOURS)]


def colour_of_degree(degree: int) -> str:
    """The colour of a degree, by its logarithm; below 2 as for 2, above 16 as for 16."""
    return to_hex(BLUES((np.log2(max(degree, 2)) - 1.0) / 3.0))


def legend_order(names: Iterable[str]) -> list[str]:
    """Each name once: galvi's methods by degree, then the rows of TABLE, then other names."""
    families = (OURS, *TABLE)

    def key(name: str) -> tuple[int, str, list[int], str]:
        family = identity(name).family
        row = families.index(family) if family in families else len(families)
        return row, family.casefold(), [int(n) for n in re.findall(r"\d+", name)], name

    return sorted(dict.fromkeys(names), key=key)


def legend_groups(names: Iterable[str]) -> list[tuple[str, list[str]]]:
    """(label, names) of the entries of a legend: one for each name or, if there are more than
    MAX_NAMES, one for each family."""
    ordered = legend_order(names)
    families: dict[str, list[str]] = {}
    for name in ordered:
        family = identity(name).family if len(ordered) > MAX_NAMES else name
        families.setdefault(family, []).append(name)
    return [(_label(family, members), members) for family, members in families.items()]


def _label(family: str, members: list[str]) -> str:
    if len(members) == 1:
        return members[0]
    degrees = sorted({int(n) for name in members for n in re.findall(r"degree (\d+)", name)})
    if family == OURS and len(degrees) > 1:
        return f"galvi, degrees {', '.join(map(str, degrees))}"
    return family

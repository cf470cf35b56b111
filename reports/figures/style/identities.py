"""The look of every contender: one colour, marker and dash, in every figure.

A row of TABLE is a family: all names that begin with its text, in this order of legends. galvi's
own methods take blues that darken with the degree and a marker for each degree, in a clock too;
their lines are those of their chart. A name that no row knows takes a colour of SPARE.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
from matplotlib.colors import to_hex, to_rgb

from reports.figures.style.chart_lines import chart_line

# Okabe and Ito (2008), without the yellow, which is too light for a white page.
COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#222222")
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">")
GUIDE = "#777777"  # claimed rates and other things that were not measured
SUN = "#E69F00"
BAND = "#eef3f7"


def darker(color: str) -> tuple[float, float, float]:
    """The same hue, darker: text needs more contrast with the page than lines do."""
    red, green, blue = (0.72 * part for part in to_rgb(color))
    return red, green, blue


SOLID, DASHED, DASH_DOT, DOTTED = "-", (0, (4, 2)), (0, (5, 1.5, 1, 1.5)), (0, (1, 1.4))
OURS, FRAME, CLOCK = "galvi", "galvi Kepler frame", "galvi clock"
MOST = 8  # entries of a legend
VARIANTS = {
    "GLOBAL": DOTTED,
    "looser": DASH_DOT,
    "default": DOTTED,
    "native": DOTTED,
}  # what ends a name: its line


@dataclass(frozen=True)
class Identity:
    """The look of one name.

    family   the text of its row, by which a legend groups names
    """

    family: str
    color: str
    marker: str
    dash: Any

    @property
    def style(self) -> dict[str, Any]:
        """Keywords of `Axes.plot`."""
        return {"color": self.color, "marker": self.marker, "linestyle": self.dash}


# family: (colour, marker, dash); colours after Okabe and Ito (2008), and Tol (2021)
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
TOGETHER = (  # families that share an entry of a legend
    ("MuJoCo Euler", "MuJoCo implicit", "MuJoCo implicitfast", "MuJoCo discrete"),
    ("Stormer-Verlet", "symplectic Euler"),
)
BLUES = ("#8CC7EF", "#3A8FE0", "#1B4FA8", "#000A28")  # from degree 2 to degree 16 and above
OF_DEGREE = {2: "v", 4: "^", 5: "<", 6: "s", 7: ">", 8: "o", 10: "D", 12: "P", 16: "X"}
SPARE = ("#5A2A82", "#B8860B", "#2E6E2E", "#A0527A", "#20606E", "#7A1F1F")


def identity(name: str) -> Identity:
    """The look of a contender's name; the same in every figure, whoever else takes part."""
    if name.startswith(FRAME):
        points = re.search(r"Gauss (\d+)", name)
        marker = "*" if points is None or int(points[1]) < 12 else "P"
        return Identity(FRAME, TABLE[FRAME][0], marker, DOTTED if "passes" in name else SOLID)
    if name.startswith(OURS):
        found = re.search(r"degree (\d+)", name) or re.search(r"Gauss (\d+)", name)
        degree = int(found[1]) if found else 8
        marker = OF_DEGREE.get(degree, "o")
        dash = DASH_DOT if name.endswith("general kernel") else chart_line(name)
        family = CLOCK if name.startswith(CLOCK) else OURS
        return Identity(family, blue(degree), marker, dash)
    family = next((one for one in TABLE if name.startswith(one)), None)
    if family is None:
        family = name.partition(",")[0]
        place = sum(family.encode())  # not a hash: that differs from process to process
        return Identity(family, SPARE[place % len(SPARE)], "h", DASHED)
    color, marker, dash = TABLE[family]
    return Identity(family, color, marker, VARIANTS.get(name.rpartition(", ")[2], dash))


def line_color(name: str, place: int) -> str:
    """The colour of a line: a contender's own, that of galvi's degree where the name is "N = 4",
    else one by its place."""
    degree = re.fullmatch(r"N = (\d+)", name)
    if degree:
        return blue(int(degree[1]))
    known = name.startswith(OURS) or any(name.startswith(family) for family in TABLE)
    return identity(name).color if known else COLOURS[place % len(COLOURS)]


@cache
def blue(degree: int) -> str:
    """The colour of a degree, by its logarithm between 2 and 16."""
    place = np.clip(np.log2(max(degree, 2)) - 1.0, 0.0, 3.0)
    anchors = np.array([to_rgb(color) for color in BLUES])
    return to_hex([np.interp(place, range(len(BLUES)), anchors[:, k]) for k in range(3)])


def in_order(names: Iterable[str]) -> list[str]:
    """Each name once: galvi's by degree, its frames, then the others as in TABLE, then unknown."""
    families = (OURS, *TABLE)

    def key(name: str) -> tuple[int, str, list[tuple[int, str]]]:
        family = identity(name).family
        place = families.index(family) if family in families else len(families)
        parts = re.findall(r"\d+|\D+", name.casefold())
        natural = [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]
        return place, family.casefold(), natural

    return sorted(dict.fromkeys(names), key=key)


Entry = tuple[str, list[str]]


def grouped(names: Iterable[str], most: int = MOST) -> list[tuple[str, list[str]]]:
    """(label, names) of the entries of a legend, at most so many.

    Where there is room each name has its own; else families share an entry, galvi's first of all,
    then those of TOGETHER, then the last ones of the order.
    """
    ordered = in_order(names)
    if len(ordered) <= most:
        return [(name, [name]) for name in ordered]
    families: dict[str, list[str]] = {}
    for name in ordered:
        families.setdefault(identity(name).family, []).append(name)
    entries = [(_label(family, members), members) for family, members in families.items()]
    for together in TOGETHER:
        if len(entries) <= most:
            break
        entries = _joined(entries, [e for e in entries if identity(e[1][0]).family in together])
    if len(entries) > most:
        return _joined(entries, entries[most - 1 :])
    return _split(entries, most)


def _split(entries: list[Entry], most: int) -> list[Entry]:
    """Expands families other than galvi's while at most `most` entries result."""
    for entry in entries:
        _, names = entry
        of_degrees = names[0].startswith(OURS) and not names[0].startswith((FRAME, CLOCK))
        if not of_degrees and len(entries) + len(names) - 1 <= most:
            place = entries.index(entry)
            entries = [*entries[:place], *((n, [n]) for n in names), *entries[place + 1 :]]
    return entries


def _joined(entries: list[Entry], those: list[Entry]) -> list[Entry]:
    if len(those) < 2:
        return entries
    first = entries.index(those[0])
    labels = [identity(names[0]).family for _, names in those]
    prefix = labels[0].split()[0]
    if all(label.split()[0] == prefix for label in labels):
        labels[1:] = [label.removeprefix(f"{prefix} ") for label in labels[1:]]
    one = ",\n".join(", ".join(labels[k : k + 2]) for k in range(0, len(labels), 2))
    joined = (one, [name for _, members in those for name in members])
    rest = [entry for entry in entries if entry not in those]
    return [*rest[:first], joined, *rest[first:]]


def _label(family: str, members: list[str]) -> str:
    if len(members) == 1:
        return members[0]
    degrees = sorted({int(n) for name in members for n in re.findall(r"degree (\d+)", name)})
    if family == OURS and len(degrees) > 1:
        return f"galvi, degrees {', '.join(map(str, degrees))}"
    return family

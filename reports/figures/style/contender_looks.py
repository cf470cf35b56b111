"""Order, colours and markers of contenders in legends."""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable

import numpy as np
from matplotlib.colors import to_hex, to_rgb

BLUES = ("#A9D8F5", "#3A8FE0", "#1B4FA8", "#000A28")  # from the lowest degree to the highest
FRAME, IN_FRAME = "frame", "#1414E6"
FAMILIES = (  # after Okabe and Ito (2008), and Tol (2021)
    *("#D55E00", "#009E73", "#CC79A7", "#9A4FB5", "#E69F00", "#8C5A2B"),
    *("#C2124B", "#8A8A00", "#7F7F7F", "#5DBB3F", "#444444"),
)
SHADES = (0.0, -0.4, 0.45)  # of a family's first, second and third member: towards black or white
MARKERS = ("o", "s", "^", "D", "v", "P", "X", "<", ">", "*", "p", "d", "h")


def in_order(names: Iterable[str], ours: Callable[[str], bool]) -> list[str]:
    """Each name once: galvi's first, then the others by family; alphabetical, numbers by value."""

    def key(name: str) -> tuple[bool, list[tuple[int, str]], list[tuple[int, str]]]:
        return not ours(name), _natural(_family(name)), _natural(name)

    return sorted(dict.fromkeys(names), key=key)


def contender_looks(names: Iterable[str], ours: Callable[[str], bool]) -> dict[str, dict[str, str]]:
    """Colour and marker of each name, in the order of `in_order`.

    Blues that darken with the degree for galvi, in every chart, and one colour for its moving
    frames; for the others a hue for each
    family (the name before a comma) and a shade for each member. Markers repeat after 13 on either
    side, and never with the same colour up to 11 families of 3.
    """
    ordered = in_order(names, ours)
    mine = [name for name in ordered if ours(name)]
    known = list(dict.fromkeys(map(_family, mine)))
    degrees = [name for name in known if FRAME not in name]
    blues = dict.fromkeys(known, IN_FRAME) | dict(zip(degrees, _blues(len(degrees)), strict=True))
    looks = {
        name: {"color": blues[_family(name)], "marker": MARKERS[k % len(MARKERS)]}
        for k, name in enumerate(mine)
    }
    families: dict[str, list[str]] = {}
    others = [name for name in ordered if not ours(name)]
    for name in others:
        families.setdefault(_family(name), []).append(name)
    colors = {
        name: _shade(FAMILIES[f % len(FAMILIES)], SHADES[k % len(SHADES)])
        for f, members in enumerate(families.values())
        for k, name in enumerate(members)
    }
    return looks | {
        name: {"color": colors[name], "marker": MARKERS[k % len(MARKERS)]}
        for k, name in enumerate(others)
    }


def _family(name: str) -> str:
    return name.partition(",")[0]


def _natural(name: str) -> list[tuple[int, str]]:
    """Key that puts degree 6 before degree 12."""
    parts = re.findall(r"\d+|\D+", name.casefold())
    return [(int(part), "") if part.isdecimal() else (-1, part) for part in parts]


def _blues(count: int) -> list[str]:
    """From light to dark; the middle one where there is one only."""
    anchors = np.array([to_rgb(color) for color in BLUES])
    if count < 2:
        return [BLUES[2]] * count
    places = np.linspace(0.0, len(BLUES) - 1.0, count)
    parts = [np.interp(places, range(len(BLUES)), anchors[:, k]) for k in range(3)]
    return [to_hex(color) for color in np.transpose(parts)]


def _shade(color: str, amount: float) -> str:
    """Towards white where the amount is positive, towards black where it is negative."""
    target = np.ones(3) if amount > 0.0 else np.zeros(3)
    return to_hex((1.0 - abs(amount)) * np.array(to_rgb(color)) + abs(amount) * target)

"""Legends: galvi by degree, then the peers by family, and no two taken for one another."""

from __future__ import annotations

import itertools
import re

import numpy as np
from matplotlib.colors import to_rgb

from benchmarks.work_precision.problem import ATTITUDE, POSITION
from benchmarks.work_precision.problems import work_precision_problems
from galvi.charts import CHARTS
from reports.figures.study_plots.work_precision import dashes
from reports.figures.style.contender_looks import (
    BLUES,
    FAMILIES,
    MARKERS,
    contender_looks,
    in_order,
)
from reports.tables.matched_error import is_ours

APART = 20.0  # in CIELAB, of two with one marker; 54 when this was written, 36 of 22 made-up names
SHARED = 14.0  # of any two; 16 when this was written, of galvi's degrees


def lab(color: str) -> np.ndarray:
    """CIELAB coordinates under D65."""
    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    ) @ linear / [0.9505, 1.0, 1.089]  # fmt: skip
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


def nearest(looks: dict[str, dict[str, str]], one_marker: bool) -> float:
    """Least distance of two colours, among all pairs or those with the same marker."""
    pairs = itertools.combinations(looks.values(), 2)
    return min(
        (
            float(np.linalg.norm(lab(a["color"]) - lab(b["color"])))
            for a, b in pairs
            if not one_marker or a["marker"] == b["marker"]
        ),
        default=np.inf,
    )


def contenders(quantity: str = POSITION) -> list[str]:
    """Of the studies that share a legend."""
    alike = [case for case in work_precision_problems(False) if case.quantity == quantity]
    return [label for case in alike for label, _, _ in case.participants]


def test_galvi_comes_first_by_degree_and_peers_follow_by_family():
    names = ["b 2", "galvi degree 12", "galvi degree 8", "a512", "a, looser", "B 10", "a", "a"]
    assert in_order(names, is_ours) == [
        *("galvi degree 8", "galvi degree 12"),
        *("a", "a, looser", "a512", "b 2", "B 10"),
    ]
    assert in_order(reversed(names), is_ours) == in_order(names, is_ours)
    degrees = [name for name in in_order(contenders(), is_ours) if is_ours(name)]
    degrees = [name for name in degrees if "frame" not in name]
    assert [int(name.split()[2].rstrip(",")) for name in degrees] == [2, 4, 6, 8, 12, 16]


def test_nobody_in_the_report_can_be_taken_for_another():
    looks = contender_looks(contenders(), is_ours)
    assert list(looks) == in_order(contenders(), is_ours) and len(looks) >= 18
    assert nearest(looks, one_marker=True) > APART
    apart = {name: look for name, look in looks.items() if "frame" not in name}  # of one colour
    assert nearest(apart, one_marker=False) > SHARED
    for mine in (True, False):
        side = [look["marker"] for name, look in looks.items() if is_ours(name) is mine]
        assert len(set(side)) == len(side)


def test_charts_of_a_degree_share_a_blue_and_neither_marker_nor_line():
    looks = contender_looks(contenders(ATTITUDE), is_ours)
    mine = {name: look for name, look in looks.items() if is_ours(name)}
    more = [name for name in mine if len(set(re.findall(r"\d+", name))) > 1]  # points
    assert len(mine) == 6 * len(CHARTS) + len(more) and len(more) == 4
    for name in mine:
        if name in more:
            alike = [one for one in mine if one.startswith(name.partition(",")[0])]
            assert len({mine[one]["color"] for one in alike}) == 1
        elif name.endswith(", Cayley"):
            alike = [name.replace("Cayley", chart.name) for chart in CHARTS]
            assert len({mine[one]["color"] for one in alike}) == 1
            assert len({mine[one]["marker"] for one in alike}) == len(CHARTS)
            assert len({str(dashes(one)) for one in alike}) == len(CHARTS) and dashes(name) == "-"
    assert len({(look["color"], look["marker"]) for look in mine.values()}) == len(mine)
    others = tuple(f", {chart.name}" for chart in CHARTS if chart.name != "Cayley")
    degrees = {
        name: look for name, look in looks.items() if not name.endswith(others) and name not in more
    }
    assert nearest(degrees, one_marker=True) > APART
    assert nearest(degrees, one_marker=False) > SHARED


def test_twenty_and_more_are_told_apart():
    for ours in (1, 4, 8):
        names = [f"galvi degree {k}" for k in range(ours)]
        names += [f"family {k // 2}, {k % 2}" for k in range(22 - ours)]
        looks = contender_looks(names, is_ours)
        assert len({look["color"] for look in looks.values()}) == len(names)
        assert nearest(looks, one_marker=True) > APART
    assert contender_looks(["galvi"], is_ours) == {"galvi": {"color": BLUES[2], "marker": "o"}}


def test_colours_that_repeat_would_be_found():
    names = in_order(contenders(), is_ours)
    repeated = {
        name: {"color": FAMILIES[k % 7], "marker": MARKERS[k % 7]} for k, name in enumerate(names)
    }
    assert nearest(repeated, one_marker=True) < APART
    assert nearest(repeated, one_marker=False) < SHARED

"""One look for each contender in every figure, and legends that stay readable."""

from __future__ import annotations

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from matplotlib.colors import to_rgb

from benchmarks.work_precision.problems import work_precision_problems
from galvi.charts import CHARTS
from reports.figures.style.identities import OURS, TABLE, grouped, identity, in_order

APART = 10.0  # in CIELAB, of two families that meet in a figure, unless their markers differ
LONGEST = 10  # entries of a legend: the families of the rigid bodies
MARKERS_APART = 20.0  # of two families with one marker; 23 when this was written


def lab(color: str) -> np.ndarray:
    """CIELAB coordinates under D65."""
    rgb = np.array(to_rgb(color))
    linear = np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)
    xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    ) @ linear / [0.9505, 1.0, 1.089]  # fmt: skip
    f = np.where(xyz > 216 / 24389, np.cbrt(xyz), (24389 / 27 * xyz + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


PROBLEMS = {
    case.problem.name: [label for label, _, _ in case.participants]
    for case in work_precision_problems(False)
}
NAMES = in_order(name for names in PROBLEMS.values() for name in names)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_no_two_of_a_comparison_look_alike(problem):
    looks = {name: identity(name) for name in PROBLEMS[problem]}
    drawn = {(one.color, one.marker, str(one.dash)) for one in looks.values()}
    variants = {n for n in looks if n.startswith(OURS)}  # the same degree, with more points
    families = {identity(name).family for name in looks if name not in variants}
    assert len(drawn) >= len(families) + (1 if variants else 0)
    others = {one.family: one for name, one in looks.items() if name not in variants}
    for a, b in itertools.combinations(others.values(), 2):
        least = MARKERS_APART if a.marker == b.marker else APART
        assert np.linalg.norm(lab(a.color) - lab(b.color)) > least, (a.family, b.family)


def test_a_look_does_not_depend_on_who_else_takes_part():
    for names in PROBLEMS.values():
        assert [identity(name) for name in names] == [identity(name) for name in list(names)]
    degree = {identity(f"galvi degree 8, Gauss 8{rest}").color for rest in ("", ", Cayley")}
    assert len(degree) == 1


def test_every_known_code_has_a_row_of_its_own():
    for name in NAMES:
        assert name.startswith(OURS) or identity(name).family in TABLE, name


def test_galvi_darkens_with_the_degree_and_charts_differ_by_their_lines():
    lightness = [lab(identity(f"galvi degree {s}, Gauss {s}").color)[0] for s in (2, 4, 8, 12, 16)]
    assert np.all(np.diff(lightness) < 0.0)
    dashes = {str(identity(f"galvi degree 8, Gauss 8, {chart.name}").dash) for chart in CHARTS}
    assert len(dashes) == len(CHARTS)


@pytest.mark.parametrize("problem", PROBLEMS)
def test_a_legend_has_at_most_ten_entries_and_names_everybody(problem):
    entries = grouped(PROBLEMS[problem])
    assert len(entries) <= LONGEST
    assert sorted(name for _, names in entries for name in names) == sorted(set(PROBLEMS[problem]))


@given(st.lists(st.sampled_from(NAMES), min_size=1, unique=True))
def test_whoever_takes_part_is_in_one_entry_of_the_legend(names):
    entries = grouped(names)
    assert len({label for label, _ in entries}) == len(entries)
    assert sorted(name for _, members in entries for name in members) == sorted(names)


def test_an_unknown_integrator_has_a_look_that_stays():
    one = identity("my leapfrog")
    assert one == identity("my leapfrog") and one.family == "my leapfrog"
    assert in_order(["my leapfrog", "heyoka", "galvi degree 8, Gauss 8"])[-1] == "my leapfrog"


def test_families_that_share_a_colour_would_be_found():
    a = b = identity("heyoka")
    assert not np.linalg.norm(lab(a.color) - lab(b.color)) > APART

"""Quadrature rules: exact up to their degree, and not beyond."""

from decimal import Decimal

import numpy as np
import pytest

import galvi
from galvi.extended_precision import extended_precision
from galvi.rules import RULES

FEWEST_POINTS = {galvi.lobatto: 2, galvi.newton_cotes: 2}  # which have two end points
MOST_POINTS = {galvi.newton_cotes: 8}
POINT_COUNTS = (1, 2, 3, 4, 5, 8, 13, 40)
FAMILIES_AND_POINTS = [
    (family, points)
    for family in RULES
    for points in POINT_COUNTS
    if FEWEST_POINTS.get(family, 1) <= points <= MOST_POINTS.get(family, max(POINT_COUNTS))
]


def moment_defect(rule, power):
    """|sum_j w_j x_j^power - 1/(power + 1)| in many digits."""
    with extended_precision():
        total = sum(
            (
                w * (x**power if power else 1)
                for x, w in zip(rule.exact_nodes, rule.exact_weights, strict=True)
            ),
            Decimal(0),
        )
        return abs(total - 1 / Decimal(power + 1))


def assert_degree(rule):
    for power in range(rule.degree + 1):
        assert moment_defect(rule, power) < Decimal("1e-50")
    # The first moment a rule misses is smaller the more points it has: about 4^-degree for Gauss.
    assert moment_defect(rule, rule.degree + 1) > Decimal("1e-49")


@pytest.mark.parametrize(("family", "points"), FAMILIES_AND_POINTS)
def test_a_rule_is_exact_to_its_degree_and_not_one_further(family, points):
    rule = family(points)
    assert rule.points == points
    assert rule.symmetric == (family is not galvi.radau)
    assert_degree(rule)


@pytest.mark.parametrize("points", [1, 2, 5, 13])
def test_radau_from_the_left_is_the_mirror_of_radau(points):
    left, right = galvi.radau(points, left=True), galvi.radau(points)
    assert left.nodes[0] == 0.0
    assert right.nodes[-1] == 1.0
    with extended_precision():
        gaps = [x + y - 1 for x, y in zip(left.exact_nodes, right.exact_nodes[::-1], strict=True)]
    assert max(map(abs, gaps)) < Decimal("1e-59")
    assert left.exact_weights == tuple(reversed(right.exact_weights))
    assert_degree(left)


@pytest.mark.parametrize(
    ("family", "points"), [pair for pair in FAMILIES_AND_POINTS if pair[1] in (2, 5)]
)
@pytest.mark.parametrize("pieces", [2, 3])
def test_a_rule_on_pieces_keeps_its_degree_and_has_no_more(family, points, pieces):
    rule = family(points)
    repeated = galvi.composite(rule, pieces)
    shared = pieces - 1 if rule.nodes[0] == 0.0 and rule.nodes[-1] == 1.0 else 0
    assert repeated.points == pieces * points - shared
    assert repeated.degree == rule.degree
    assert repeated.symmetric == rule.symmetric
    assert_degree(repeated)


def test_one_piece_is_the_rule_itself_and_trapezoids_join():
    assert galvi.composite(galvi.gauss(3), 1) is galvi.gauss(3)
    joined = galvi.composite(galvi.lobatto(2), 4)
    assert joined.nodes.tolist() == [0.0, 0.25, 0.5, 0.75, 1.0]
    assert joined.weights.tolist() == [0.125, 0.25, 0.25, 0.25, 0.125]
    assert joined.name == "Lobatto 2 on 4 pieces"


def test_radau_and_newton_cotes_are_those_of_the_textbooks():
    """Abramowitz and Stegun 25.4.14, 25.4.17; Hairer and Wanner, Solving ODEs II, IV.5."""
    assert galvi.radau(2).nodes.tolist() == [1 / 3, 1.0]
    assert galvi.radau(2).weights.tolist() == [0.75, 0.25]
    root = np.sqrt(6)
    assert np.allclose(galvi.radau(3).nodes, [(4 - root) / 10, (4 + root) / 10, 1], rtol=1e-15)
    assert np.allclose(
        galvi.radau(3).weights, [(16 - root) / 36, (16 + root) / 36, 1 / 9], rtol=1e-15
    )
    boole = np.array([7, 32, 12, 32, 7]) / 90
    assert np.array_equal(galvi.newton_cotes(5).weights, boole)
    eight = np.array([751, 3577, 1323, 2989, 2989, 1323, 3577, 751]) / 17280
    assert np.array_equal(galvi.newton_cotes(8).weights, eight)


def test_nine_equidistant_points_do_have_a_negative_weight_and_eight_have_none():
    for points, expected_sign in ((9, -1), (8, 1)):
        powers = np.vander(np.linspace(0, 1, points), increasing=True).T
        weights = np.linalg.solve(powers, 1 / np.arange(1, points + 1))
        assert np.sign(weights.min()) == expected_sign

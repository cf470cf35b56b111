"""Quadrature rules: exact up to their degree, and not beyond."""

from decimal import Decimal

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.decimals import many_digits
from galvi.rules import RULES

SIZES = [
    (family, points)
    for family in RULES
    for points in (1, 2, 3, 4, 5, 8, 13, 40)
    if points > 1 or family is not galvi.lobatto  # which has two end points
]


def moment_defect(rule, power):
    """|sum_j w_j x_j^power - 1/(power + 1)| in many digits."""
    with many_digits():
        total = sum(
            (
                w * (x**power if power else 1)
                for x, w in zip(rule.exact_nodes, rule.exact_weights, strict=True)
            ),
            Decimal(0),
        )
        return abs(total - 1 / Decimal(power + 1))


@pytest.mark.parametrize(("family", "points"), SIZES)
def test_a_rule_is_exact_to_its_degree_and_not_one_further(family, points):
    rule = family(points)
    assert rule.points == points
    assert rule.symmetric
    for power in range(rule.degree + 1):
        assert moment_defect(rule, power) < Decimal("1e-50")
    # The first moment a rule misses is smaller the more points it has: about 4^-degree for Gauss.
    assert moment_defect(rule, rule.degree + 1) > Decimal("1e-49")


@given(points=st.integers(1, 60))
def test_gauss_nodes_and_weights_are_those_of_numpy(points):
    x, w = np.polynomial.legendre.leggauss(points)
    rule = galvi.gauss(points)
    assert np.allclose(rule.nodes, (1 + x) / 2, rtol=0, atol=1e-15)
    assert np.allclose(rule.weights, w / 2, rtol=0, atol=1e-14)


def test_two_lobatto_points_are_the_trapezoid_and_three_are_simpson():
    assert galvi.lobatto(2).weights.tolist() == [0.5, 0.5]
    assert np.allclose(galvi.lobatto(3).weights, [1 / 6, 4 / 6, 1 / 6], rtol=1e-16)
    assert np.array_equal(galvi.clenshaw_curtis(3).weights, galvi.lobatto(3).weights)


@pytest.mark.parametrize("family", RULES)
@pytest.mark.parametrize("points", [0, -1, 2.5, float("nan"), "3", True, None])
def test_a_number_of_points_that_is_none_is_refused_in_one_sentence(family, points):
    with pytest.raises(ValueError, match=r"points must be a whole number of at least .; received"):
        family(points)


@pytest.mark.parametrize(
    ("nodes", "weights", "sentence"),
    [
        ((0.2, 0.8), (0.5, 0.6), "sum to 1"),
        ((0.2, 0.8), (1.5, -0.5), "must be positive"),
        ((0.8, 0.2), (0.5, 0.5), "must increase"),
        ((0.2, 1.8), (0.5, 0.5), r"inside \[0, 1\]"),
        ((0.2,), (0.5, 0.5), "one weight for each node"),
        ((), (), "at least one"),
        ((0.2, float("nan")), (0.5, 0.5), "finite"),
    ],
)
def test_numbers_that_are_no_rule_are_refused(nodes, weights, sentence):
    with pytest.raises(ValueError, match=sentence):
        galvi.Rule("mine", 1, nodes, weights)

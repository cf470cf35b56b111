"""Function spaces: what the protocol promises, for every space."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.spaces import SPACES
from galvi.spaces.legendre import legendre

DEGREES = st.integers(1, 64)


@pytest.mark.parametrize("space", SPACES)
@given(degree=DEGREES)
def test_the_first_basis_function_is_one_and_all_others_start_at_zero(space, degree):
    values = space(degree).basis(np.linspace(0, 1, 7))
    assert np.all(values[:, 0] == 1.0)
    assert np.allclose(values[0, 1:], 0.0, atol=1e-16)


@pytest.mark.parametrize("space", SPACES)
@given(degree=DEGREES)
def test_the_derivative_is_that_of_the_basis(space, degree):
    this = space(degree)
    rule = galvi.gauss(40)
    for end in (0.3, 1.0):
        gained = end * rule.weights @ this.derivative(end * rule.nodes)
        rise = this.basis(np.array([end])) - this.basis(np.zeros(1))
        assert np.allclose(gained, rise[0], atol=1e-14)


@given(degree=DEGREES)
def test_the_nodal_view_reproduces_every_polynomial_of_the_space(degree):
    space = galvi.Polynomials(degree)
    t = np.concatenate([np.linspace(0, 1, 23), space.nodes])
    nodal = space.lagrange(t) @ space.basis(space.nodes)
    assert np.allclose(nodal, space.basis(t), atol=2e-14)
    assert np.allclose(space.lagrange(t).sum(axis=1), 1.0, atol=1e-14)


def test_the_nodes_are_the_chebyshev_points_of_the_dissertation():
    n = 6
    expected = 0.5 - 0.5 * np.cos(np.arange(n + 1) * np.pi / n)
    assert np.allclose(galvi.Polynomials(n).nodes, expected, atol=1e-16)


def test_legendre_polynomials_are_those_of_numpy():
    x = np.linspace(-1, 1, 11)
    assert np.allclose(legendre(x, 30), np.polynomial.legendre.legvander(x, 30), atol=1e-14)


@pytest.mark.parametrize("degree", [0, -2, 65, 2.5, float("inf"), "four"])
def test_a_degree_outside_1_to_64_is_refused(degree):
    with pytest.raises(ValueError, match=r"degree must be a whole number from 1 to 64; received"):
        galvi.Polynomials(degree)

"""Function spaces: what the protocol promises, for every space."""

from decimal import Decimal

import mpmath
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.extended_precision import decimals, extended_precision, rounded
from galvi.spaces import SPACES
from galvi.spaces.fourier import spherical_bessel
from galvi.spaces.polynomials import integrals, legendre

DEGREES = st.integers(1, 64)
SIZES = (1, 2, 3, 5, 9)
TESTED_SPACES = [make(n) for make in SPACES for n in SIZES]
each_space = pytest.mark.parametrize("space", TESTED_SPACES, ids=str)
SAMPLE_TIMES = np.arange(1, 400) * 0.6180339887498949 % 1.0


def distances_from_space(space, functions):
    """The largest distance of each column of ``functions``, values at SAMPLE_TIMES, from its least
    squares fit in the space."""
    basis = space.basis(SAMPLE_TIMES)
    gap = basis @ np.linalg.lstsq(basis, functions, rcond=None)[0] - functions
    return np.max(np.abs(gap), axis=0)


def test_every_kind_of_space_that_galvi_exports_is_tested():
    kinds = {type(make(1)) for make in SPACES}
    exported = {
        value
        for name in galvi.__all__
        if isinstance(value := getattr(galvi, name), type) and hasattr(value, "basis")
    }
    assert exported == kinds
    assert len(kinds) >= 6


@each_space
def test_the_first_basis_function_is_one_and_all_others_start_at_zero(space):
    values = space.basis(np.linspace(0, 1, 7))
    assert values.shape == (7, space.dimension)
    assert np.all(values[:, 0] == 1.0)
    assert np.all(values[0, 1:] == 0.0)


@each_space
def test_the_derivative_is_that_of_the_basis(space):
    t = decimals(SAMPLE_TIMES[:3])
    with extended_precision():
        offset = decimals([2.0**-60])
        difference = space.basis(t + offset) - space.basis(t - offset)
        errors = difference / (2 * offset) - space.derivative(t)
    assert np.max(np.abs(rounded(errors))) < 1e-31  # 5e-34; second order in 2^-60


@each_space
def test_a_space_contains_its_degree_and_not_one_further(space):
    distances = distances_from_space(space, legendre(2.0 * SAMPLE_TIMES - 1.0, space.degree + 1))
    assert np.max(distances[:-1]) < 1e-12  # 3e-14
    assert distances[-1] > 1e-6  # 1.6e-5, degree 9 on 3 pieces


@each_space
def test_floats_and_decimals_give_the_same_functions(space):
    with extended_precision():
        exact = decimals(SAMPLE_TIMES[:9])
        values, slopes = space.basis(exact), space.derivative(exact)
    assert np.allclose(rounded(values), space.basis(SAMPLE_TIMES[:9]), rtol=0, atol=2e-15)  # 1e-16
    largest = np.max(np.abs(rounded(slopes)))
    assert np.allclose(
        rounded(slopes), space.derivative(SAMPLE_TIMES[:9]), rtol=0, atol=1e-14 * largest
    )  # 9e-16


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


def test_legendre_polynomials_and_their_integrals_are_those_of_numpy():
    x = np.linspace(-1, 1, 11)
    assert np.allclose(legendre(x, 30), np.polynomial.legendre.legvander(x, 30), atol=1e-14)
    for l in (0, 1, 7):
        integral = np.polynomial.Legendre.basis(l, domain=[0, 1]).integ(lbnd=0)
        assert np.allclose(integrals(0.5 + 0.5 * x, 9)[:, l], integral(0.5 + 0.5 * x), atol=1e-15)


@pytest.mark.parametrize("degree", [0, -2, 65, 2.5, float("inf"), "four"])
def test_a_degree_outside_1_to_64_is_refused(degree):
    sentence = r"degree must be a whole number from 1 to 64; received"
    for space in (
        galvi.Polynomials,
        lambda d: galvi.PiecewisePolynomials(d, 2),
        lambda d: galvi.PolynomialFourier(d, 1),
    ):
        with pytest.raises(ValueError, match=sentence):
            space(degree)


SAVED = [
    (galvi.PolynomialFourier(2, 2, 3.0), galvi.gauss(12)),
    (galvi.ComponentPolynomials((5, 4)), galvi.gauss(5)),
    (galvi.PiecewisePolynomials(2, 3), galvi.composite(galvi.radau(3, left=True), 3)),
    (galvi.PiecewiseHermite(2), galvi.composite(galvi.newton_cotes(5), 2)),
]


@pytest.mark.parametrize(("space", "rule"), SAVED, ids=[str(space) for space, _ in SAVED])
def test_runs_with_every_space_are_saved_loaded_and_resumed_to_the_bit(space, rule, tmp_path):
    method = galvi.Galerkin(space, rule)
    problem = galvi.problems.kepler(0.2)
    uncut = galvi.integrate(problem, method, 0.3, 12)
    galvi.save(galvi.integrate(problem, method, 0.3, 5), tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    assert loaded.method == method
    assert np.array_equal(galvi.resume(loaded, steps=7).q[-1], uncut.q[-1])
    assert np.array_equal(loaded(1.234), uncut(1.234))


def test_spherical_bessel_functions_are_those_of_mpmath():
    with extended_precision(), mpmath.workdps(80):
        for x in (0.01, 3.0, 40.0):
            values = spherical_bessel(Decimal(x), 130)
            scale = mpmath.sqrt(mpmath.pi / (2 * mpmath.mpf(x)))
            for l in (0, 1, 5, 20):
                expected = scale * mpmath.besselj(l + mpmath.mpf(1) / 2, mpmath.mpf(x))
                assert abs(mpmath.mpf(str(values[l])) / expected - 1) < 1e-57  # 2e-59

"""Spaces on pieces of a step: a step on n pieces is n steps; joints of values and slopes."""

import numpy as np
import pytest

import galvi


@pytest.mark.parametrize(
    ("degree", "pieces", "rule"),
    [
        (1, 4, galvi.gauss(1)),
        (2, 3, galvi.gauss(2)),
        (2, 5, galvi.radau(3, left=True)),
        (3, 2, galvi.gauss(5)),
    ],
    ids=str,
)
def test_a_step_on_pieces_is_that_many_steps(degree, pieces, rule):
    problem = galvi.problems.kepler(0.3)
    piecewise = galvi.Galerkin(
        galvi.PiecewisePolynomials(degree, pieces), galvi.composite(rule, pieces)
    )
    plain = galvi.Galerkin(galvi.Polynomials(degree), rule)
    piecewise_run = galvi.integrate(problem, piecewise, 0.4, 20)
    plain_run = galvi.integrate(problem, plain, 0.4 / pieces, 20 * pieces)
    assert np.allclose(piecewise_run.q, plain_run.q[::pieces], rtol=0, atol=1e-13)  # 4e-15
    t = np.linspace(0.0, 8.0, 97)
    assert np.allclose(piecewise_run(t), plain_run(t), rtol=0, atol=1e-13)  # 4e-15


def test_one_piece_is_the_space_of_polynomials():
    rule = galvi.gauss(5)
    for space, polynomials in (
        (galvi.PiecewiseHermite(1), galvi.Polynomials(3)),
        (galvi.PiecewisePolynomials(1, 1), galvi.Polynomials(1)),
        (galvi.PiecewisePolynomials(5, 1), galvi.Polynomials(5)),
    ):
        of_pieces, of_polynomials = (galvi.Galerkin(s, rule).table for s in (space, polynomials))
        for field in ("A", "beta", "integral"):
            assert np.array_equal(getattr(of_pieces, field), getattr(of_polynomials, field))


@pytest.mark.parametrize("pieces", [2, 3, 7])
def test_what_is_joined_does_not_jump(pieces):
    joints = np.arange(1, pieces) / pieces
    offset = 1e-9
    linear, cubic = galvi.PiecewisePolynomials(1, pieces), galvi.PiecewiseHermite(pieces)
    for space in (linear, cubic):
        assert np.allclose(space.basis(joints - offset), space.basis(joints + offset), atol=1e-8)
    assert np.allclose(cubic.derivative(joints - offset), cubic.derivative(joints), atol=1e-7)
    jump = np.max(np.abs(linear.derivative(joints - offset) - linear.derivative(joints)))
    assert jump == 1.0
    assert np.array_equal(linear.derivative(joints), linear.derivative(joints + offset))


def test_hermite_cubics_have_all_values_and_slopes_at_the_joints():
    space = galvi.PiecewiseHermite(4)
    joints = np.linspace(0.0, 1.0, 5)
    conditions = np.vstack([space.basis(joints), space.derivative(joints)])
    assert np.linalg.matrix_rank(conditions) == space.dimension == 10

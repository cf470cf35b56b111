"""Derivatives by differences: a length for each coordinate, and an estimate of the error."""

import numba
import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

import galvi
from galvi.systems import finite_differences
from galvi.systems.finite_differences import differenced_gradient, differences, noise_of

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
CART_POSITION = 1e4


def untraced(function):
    """The function behind a branch, which keeps it from being traced."""
    return lambda q: 0.0 if q[0] == np.inf else function(q)


def cosine(q):
    return -np.cos(q[0])


def angle_and_cart(q):
    """An angle beside a coordinate of 1e4."""
    return -np.cos(q[0]) + 0.5 * (q[1] - CART_POSITION) ** 2


def test_the_force_of_a_cosine_is_found_where_it_is_small_or_far_out():
    """-cos q is rounded to 1e-16, so that a force of q is known to 1e-15."""
    functions = (untraced(cosine), numba.njit(untraced(numba.njit(cosine))))
    gradients = [differenced_gradient(potential, False) for potential in functions]
    for q, error in ((0.5, 1e-12), (1e-4, 1e-9), (1e-8, 1e-5), (2000 * np.pi + 0.3, 1e-8)):
        for slope in gradients:
            assert abs(slope(np.array([q]))[0] / np.sin(q) - 1.0) < error
        assert noise_of(functions[0], np.array([q])) < 100.0 * error


def test_each_coordinate_has_a_length_of_its_own(monkeypatch):
    q = np.array([0.3, CART_POSITION + 0.1])
    exact = [np.sin(0.3), 0.1]
    slope = differenced_gradient(untraced(angle_and_cart), False)(q)
    np.testing.assert_allclose(slope, exact, rtol=0.0, atol=1e-9)
    # Planted: the largest coordinate is the length of all, and no other length is tried.
    monkeypatch.setattr(finite_differences, "lengths_of", lambda q: np.full(q.size, np.max(abs(q))))
    monkeypatch.setattr(finite_differences, "FINER_STEPS", 0)
    assert (
        not abs(differenced_gradient.__wrapped__(untraced(angle_and_cart), False)(q)[0] - exact[0])
        < 1e-3
    )


@pytest.mark.parametrize(
    ("potential", "q0", "exact"),
    [
        (cosine, [0.3 + 2000 * np.pi], cosine),
        (lambda q: 100.0 + 0.5 * q @ q, [1.0], lambda q: 0.5 * q @ q),  # terms that cancel
    ],
)
def test_runs_are_those_of_the_potential(potential, q0, exact):
    def run(function):
        start = galvi.Problem(galvi.Canonical(1.0, function), q0, np.zeros(len(q0)))
        return galvi.integrate(start, EIGHT, 0.2, 50)

    differenced, traced = run(untraced(potential)), run(exact)
    assert differenced.success and traced.success
    np.testing.assert_allclose(differenced.q, traced.q, rtol=1e-9, atol=1e-9 * abs(q0[0]))


def test_a_force_below_the_rounding_of_its_potential_is_said():
    start = galvi.Problem(galvi.Canonical(1.0, untraced(cosine)), [1e-8], [0.0])
    run = galvi.integrate(start, EIGHT, 0.2, 50)
    assert not run.success and "the gradient of the potential is differenced" in run.status


def test_where_no_length_agrees_the_start_is_refused():
    noise = np.random.default_rng(1)
    noisy = galvi.Canonical(1.0, untraced(lambda q: noise.normal()))
    with pytest.raises(ValueError, match=r"gradient .* which is differenced, or give one"):
        galvi.integrate(galvi.Problem(noisy, [1.0], [0.0]), EIGHT, 0.2, 1)


def test_what_a_potential_raises_is_raised_where_it_leaves_no_derivative():
    def edge(q):
        if q[0] < 1.0:
            raise ValueError("below the edge")
        return (q[0] - 1.0) ** 2

    slope = differenced_gradient(edge, False)(np.array([1.0 + 2.0**-9]))  # longer steps leave it
    assert abs(slope[0] / 2.0**-8 - 1.0) < 1e-8
    with pytest.raises(ValueError, match="below the edge"):
        differenced_gradient(edge, False)(np.array([1.0]))


@given(
    log_length=st.floats(-8, 8),
    log_position=st.floats(-3, 3),
    offset=st.floats(-3, 3),
    log_second_coordinate=st.floats(-6, 6),
)
@example(log_length=0.0, log_position=-3.0, offset=3.0, log_second_coordinate=4.0)
@settings(max_examples=100)
def test_an_error_is_at_least_what_it_is_said_to_be_of(
    log_length, log_position, offset, log_second_coordinate
):
    """The derivative of a sine of any length at any position, beside a coordinate of any size, is
    right within 20 times its error."""
    unit, x = 10.0**log_length, 10.0**log_position

    def value(q):
        return np.array([np.sin(q[0] / unit) + 10.0**offset + 0.0 * q[1]])

    q = np.array([x * unit, 10.0**log_second_coordinate])
    slope, error = differences(value, q, finite_differences.lengths_of(q))
    if np.isfinite(error[0, 0]):
        rounding = 2.0**-52 * abs(q[0]) / unit**2  # of the argument
        assert abs(slope[0, 0] - np.cos(q[0] / unit) / unit) <= 20.0 * error[0, 0] + 4.0 * rounding


def wall(q):
    return 5e3 * max(0.0, q[0] - 1.0) ** 2


def far_away(q):
    if abs(q[0] - 1.0) > 0.2:
        raise IndexError("beyond the table")
    return 0.5 * q[0] ** 2


def at_a_pole(q):
    return 1e6 - 1.0 / abs(q[0])  # a longer step lands on 0


@pytest.mark.parametrize(
    ("potential", "slopes"),
    [
        (wall, {1.0 - 1e-5: 0.0, 0.3: 0.0, 1.0 + 1e-5: 0.1}),
        (numba.njit(far_away), {1.0: 1.0}),
        (at_a_pole, {1.0: 1.0}),
    ],
)
def test_one_side_of_a_kink_and_the_edge_of_a_domain(potential, slopes):
    """A force that is 0 on one side of a kink was NaN; values far away are not needed."""
    gradient = differenced_gradient(potential, False)
    for q, slope in slopes.items():
        assert abs(gradient(np.array([q]))[0] - slope) <= 1e-6 * max(1.0, abs(slope)), q


def test_a_wall_lets_a_body_fly_and_throws_it_back():
    """Half of a period of the wall's spring, of frequency 100, then back with the same speed."""
    start = galvi.Problem(galvi.Canonical(1.0, wall), [0.3], [1.0])
    run = galvi.integrate(start, galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2)), 1e-3, 1500)
    assert run.success
    assert abs(run.q[-1, 0] - (1.0 - (1.5 - 0.7 - np.pi / 100.0))) < 1e-3

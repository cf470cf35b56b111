"""Given derivatives are compared with their functions when a problem is made."""

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

import galvi
from galvi.systems import derivative_check

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
FAMILIES = {
    "quartic": (lambda x: x @ x + (x @ x) ** 2, lambda x: (2.0 + 4.0 * x @ x) * x),
    "waves": (lambda x: float(np.sum(np.cos(x))), lambda x: -np.sin(x)),
    "attraction": (lambda x: -1.0 / np.sqrt(x @ x), lambda x: x * (x @ x) ** -1.5),
    "wall": (lambda x: float(np.sum(np.maximum(x, 0.0) ** 2)), lambda x: 2.0 * np.maximum(x, 0.0)),
    "kink": (lambda x: float(np.sum(np.abs(x))), np.sign),
    "none": (lambda x: 1.0, np.zeros_like),
}


def problem_with_gradient(gradient, q0=(1.0, -0.3), potential=lambda q: 0.5 * q @ q, **fields):
    system = galvi.Canonical(1.0, potential, gradient, **fields)
    return galvi.Problem(system, q0, np.zeros(len(q0)))


@pytest.mark.parametrize("q0", [(1.0, -0.3), (1.0, 0.0), (0.0, 0.0), (1e-8, 1e8)])
@pytest.mark.parametrize(
    "wrong",
    [
        lambda q: -q,
        lambda q: 1.001 * q,
        lambda q: q * [1.0, -1.0],
        lambda q: q[::-1],
        np.zeros_like,
        numba.njit(lambda q: -q),
    ],
)
def test_a_wrong_sign_or_factor_is_refused_also_where_it_cannot_be_seen(wrong, q0):
    """At (0, 0) all of them are right, and at (1, 0) some: a second state shows the fault."""
    sentence = r"^gradient must be the derivative of the potential: along .* at q = .*expected "
    with pytest.raises(ValueError, match=sentence + ".* received .*Canonical check=False"):
        problem_with_gradient(wrong, q0)
    assert problem_with_gradient(wrong, q0, check=False).q0.size == 2


@given(
    name=st.sampled_from(sorted(FAMILIES)),
    q=st.lists(st.floats(-1e3, 1e3), min_size=1, max_size=3),
    scale=st.integers(-9, 9),
    strength=st.integers(-12, 12),
    offset=st.sampled_from([0.0, 1.0, -1e9]),
)
def test_no_right_pair_is_refused(name, q, scale, strength, offset):
    V, slope = FAMILIES[name]
    a, unit, start = 10.0**strength, 10.0**scale, np.array(q)
    with np.errstate(all="ignore"):
        problem_with_gradient(
            lambda x: a * slope(x / unit) / unit, start * unit, lambda x: offset + a * V(x / unit)
        )


@pytest.mark.parametrize("noise", [1e-12, 1e-4, 1e-1])
def test_noise_is_no_reason_to_refuse_and_hides_no_sign_below_a_thousandth(noise):
    generator = np.random.default_rng(5)

    def noisy(q):
        return 0.5 * q @ q + noise * generator.standard_normal()

    for _ in range(10):
        problem_with_gradient(lambda q: q, potential=noisy)
        if noise <= 1e-4:
            with pytest.raises(ValueError, match="gradient must be the derivative"):
                problem_with_gradient(lambda q: -q, potential=noisy)


def test_single_precision_a_short_period_and_a_domain_with_an_edge_are_no_reason_to_refuse():
    problem_with_gradient(lambda q: q, potential=lambda q: float(np.float32(0.5 * q @ q)))
    for phase in (7e6, 7e9, 7e15):
        problem_with_gradient(np.cos, (phase,), lambda q: float(np.sin(q[0])))

    def edge(q):
        if q[0] < 1.0:
            raise LookupError("outside of the table")
        return np.sqrt(q[0] - 1.0)

    problem_with_gradient(lambda q: 0.5 / np.sqrt(q - 1.0), (1.0 + 1e-9,), edge)


def test_hessians_are_checked_with_a_given_and_with_a_differenced_gradient():
    for gradient in (None, lambda q: q):
        problem_with_gradient(gradient, hessian=lambda q: np.eye(2))
        with pytest.raises(ValueError, match="hessian must be the derivative of the gradient"):
            problem_with_gradient(gradient, hessian=lambda q: np.diag([1.0, -1.0]))


def test_a_function_of_time_is_checked_where_it_vanishes_at_the_start():
    fields = {"potential": lambda q, t: np.sin(t) * q @ q, "explicit_time": True}
    problem_with_gradient(lambda q, t: 2.0 * np.sin(t) * q, **fields)
    with pytest.raises(ValueError, match="2 times that"):
        problem_with_gradient(lambda q, t: 4.0 * np.sin(t) * q, **fields)


def height(R):
    return float(R[2, 2] + 0.3 * R[0, 1])


def lift(R):
    return np.array([[0.0, 0.3, 0.0], [0.0, 0.0, 0.0], [0.0, 0.0, 1.0]])


@pytest.mark.parametrize("start", [np.eye(3), np.diag([1.0, -1.0, -1.0])])
def test_a_rigid_body_is_checked_along_a_rotation(start):
    def body(gradient, **fields):
        system = galvi.RigidBody((1.0, 2.0, 2.5), height, gradient, **fields)
        return galvi.Problem(system, start, [0.1, 0.0, 0.0])

    body(lift)
    body(lambda R: lift(R) + 5.0 * R)  # a part normal to the group does no work
    body(lambda R: -lift(R), check=False)
    for factor in (-1.0, 0.99):
        with pytest.raises(ValueError, match=r"about .* at R = .*RigidBody check=False"):
            body(lambda R, factor=factor: factor * lift(R))


GROUPS = (
    galvi.Rn(2),
    galvi.SO2(),
    galvi.SO3(),
    galvi.SE2(),
    galvi.SE3(),
    galvi.Product((galvi.SO3(), galvi.Rn(2))),
)


@pytest.mark.parametrize("group", GROUPS, ids=str)
def test_slopes_of_a_lagrangian_are_checked_on_every_group(group):
    d, size = group.dimension, int(np.prod(group.shape))
    weights = derivative_check.direction(size, 5)

    def L(q, v):
        return float(0.5 * v @ v + weights @ np.sin(q.ravel()))

    def slopes(by_v, by_q):
        return lambda q, v: np.concatenate([by_v * v, by_q * weights * np.cos(q.ravel())])

    unit = np.eye(group.shape[0]) if len(group.shape) == 2 else np.zeros(size)
    if isinstance(group, galvi.Product):
        unit = group.join(np.eye(3), np.zeros(2))

    def problem(*factors, **fields):
        system = galvi.Lagrangian(L, group, slopes(*factors), **fields)
        return galvi.Problem(system, unit, 0.3 * derivative_check.direction(d, 4))

    problem(1.0, 1.0)
    problem(1.0, -1.0, check=False)
    for factors, name in (((-1.0, 1.0), "dL/dv"), ((1.0, -1.0), "dL/dq"), ((1.0, 2.0), "dL/dq")):
        with pytest.raises(ValueError, match=f"slopes {name} must be the derivative of the Lag"):
            problem(*factors)


def test_the_switch_is_no_part_of_a_saved_system(tmp_path):
    run = galvi.integrate(problem_with_gradient(lambda q: q), FOUR, 0.1, 3)
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(
        tmp_path / "run.npz", problem=problem_with_gradient(lambda q: q, check=False)
    )
    assert np.array_equal(loaded.q, run.q)


def test_fixed_directions_are_generic():
    """Sizes fill the interval from 0.5 to 1.5, signs are mixed, and each direction differs."""
    first, second = (derivative_check.direction(60, number) for number in (0, 1))
    assert np.max(np.diff([0.5, *np.sort(np.abs(first)), 1.5])) < 0.04  # 0.027
    assert 20 < np.sum(first > 0.0) < 40
    assert np.min(np.abs(np.abs(first) - np.abs(second))) > 1e-3

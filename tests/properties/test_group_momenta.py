"""Momenta of bodies and points on groups: their definition, and what runs conserve of them."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import galvi
from benchmarks.measures.matrix_group import MatrixGroup
from galvi.diagnostics import group_momenta
from tests.properties.group_matrices import cross_matrix, element

SO2, SE2, SO3, SE3 = galvi.SO2(), galvi.SE2(), galvi.SO3(), galvi.SE3()
POINT = galvi.Rn(3)
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
GROUPS = {
    "SO2": SO2,
    "SE2": SE2,
    "SO3": SO3,
    "SE3": SE3,
    "two bodies": galvi.Product((SE3, SE3)),
    "body, top and point": galvi.Product((galvi.Product((SE3, SO3)), POINT)),
    "in the plane": galvi.Product((SE2, galvi.Rn(2), SO2)),
}
each_group = pytest.mark.parametrize("group", GROUPS.values(), ids=GROUPS)
PLANE = (SO2, SE2, GROUPS["in the plane"])
TINY = 1e-30  # step of a complex difference, which has no rounding


def moved_in_space(group, g, Q, c):
    """g after space was turned by Q and translated by c."""
    if isinstance(group, galvi.Product):
        parts = zip(group.factors, group.parts(g), strict=True)
        return group.join(*(moved_in_space(factor, part, Q, c) for factor, part in parts))
    if isinstance(group, galvi.Rn):
        return Q @ g + c
    if g.shape == Q.shape:
        return Q @ g
    n = len(c)
    return np.block([[Q, c[:, None]], [np.zeros((1, n)), np.ones((1, 1))]]) @ g


def by_definition(group, L, g, v, Q_rate, c_rate):
    """d/de L(g, v + e xi), where g xi is the rate of g while space turns and moves."""
    matrices, n = MatrixGroup(group), len(c_rate)
    after = moved_in_space(group, g + 0j, np.eye(n) + 1j * TINY * Q_rate, 1j * TINY * c_rate)
    rate = matrices.matrix(after).imag / TINY
    xi = matrices.vee(np.linalg.solve(matrices.matrix(g), rate))
    return L(g, v + 1j * TINY * xi).imag / TINY


def definitions(group, L, g, v):
    """Angular momentum, (3,) or a number, and, on groups with positions, linear momentum, (n,)."""
    n = 2 if group in PLANE else 3
    turns = [np.array([[0.0, -1.0], [1.0, 0.0]])] if n == 2 else map(cross_matrix, np.eye(3))
    angular = [by_definition(group, L, g, v, turn, np.zeros(n)) for turn in turns]
    if group in (SO2, SO3):
        return (np.array(angular).reshape(-1 if n == 3 else ()),)
    linear = [by_definition(group, L, g, v, np.zeros((n, n)), c) for c in np.eye(n)]
    return np.array(angular).reshape(-1 if n == 3 else ()), np.array(linear)


@cache
def any_problem(group):
    """A Lagrangian without symmetry whose mass depends on the configuration."""
    random, d = np.random.default_rng(7), group.dimension
    root, c, b = random.normal(size=(d, d)), random.normal(size=group.shape), random.normal(size=d)

    def L(q, v):
        s = np.sum(c * q)
        return 0.5 * v @ (root @ root.T + np.eye(d)) @ v + 0.1 * s**2 * v @ v + s * b @ v - s

    start = element(group, random.normal(size=d)), random.normal(size=d)
    return galvi.Problem(galvi.Lagrangian(L, group), *start)


def random_states(group, seed):
    """A trajectory of four independent random states, and their velocities."""
    random, problem = np.random.default_rng(seed), any_problem(group)
    q = np.array([element(group, vector) for vector in random.normal(size=(4, group.dimension))])
    v, times = random.normal(size=(4, group.dimension)), np.arange(4.0)
    p = problem.system.momentum(v, q, times)
    return galvi.Trajectory(problem, times, q, p, counts={}), v


def momenta_of_states(group, seed):
    """Angular and linear momenta of four states, by galvi and by definition."""
    run, v = random_states(group, seed)
    return momenta(run), momenta_by_definition(run.problem.system, run.q, v)


def momenta(run, t=None):
    """Angular and linear momenta by galvi; no linear one on groups without positions."""
    has_places = run.problem.system.group not in (SO2, SO3)
    return [galvi.momentum_map(run, t), *([galvi.linear_momentum(run, t)] if has_places else [])]


def momenta_by_definition(system, q, v):
    """Angular and linear momenta of several states, by definition."""
    states = zip(q, v, strict=True)
    by_state = [definitions(system.group, system.function, *state) for state in states]
    return [np.array(values) for values in zip(*by_state, strict=True)]


def assert_agree(computed, expected):
    for value, truth in zip(computed, expected, strict=True):
        assert value.shape == truth.shape
        assert np.allclose(value, truth, rtol=0.0, atol=1e-9 * np.abs(truth).max())


@each_group
@given(seed=st.integers(0, 2**31))
@settings(max_examples=10)
def test_momenta_are_those_of_noethers_definition(group, seed):
    assert_agree(*momenta_of_states(group, seed))


@pytest.mark.parametrize(
    "name, wrong",
    [
        ("rotate_to_space", lambda g, mu: mu),
        ("rotate_to_space", lambda g, mu: np.einsum("...ji,...j->...i", g[..., :3, :3], mu)),
        ("moment", lambda x, P: np.cross(P, x)),
        ("moment", lambda x, P: 0.0 * x),
        ("place_and_momentum", lambda factor, space: (factor.q[..., :3, 3], factor.p[..., 3:])),
    ],
)
def test_another_formula_does_not_agree(monkeypatch, name, wrong):
    monkeypatch.setattr(group_momenta, name, wrong)
    with pytest.raises(AssertionError):
        assert_agree(*momenta_of_states(GROUPS["two bodies"], 1))


def positions_of(group, q):
    """The positions of the factors that have one."""
    if isinstance(group, galvi.Product):
        parts = zip(group.factors, group.parts(q), strict=True)
        return [x for factor, part in parts for x in positions_of(factor, part)]
    if isinstance(group, galvi.Rn):
        return [q]
    return [] if group in (SO2, SO3) else [q[:-1, -1]]


def run_of_pulled_bodies(group, strength):
    """A run of bodies that attract each other, and that the origin attracts with ``strength``."""
    random, d, end = np.random.default_rng(5), group.dimension, 0
    masses = np.eye(d)
    for factor, _, _ in group_momenta.factors(group, np.zeros(group.shape), np.zeros(d)):
        block = slice(end, end + factor.dimension)
        root = 0.4 * random.normal(size=(factor.dimension,) * 2)
        masses[block, block] += root @ root.T * (not isinstance(factor, galvi.Rn))
        end = block.stop

    def L(q, v):
        lagrangian, positions = 0.5 * v @ masses @ v, positions_of(group, q)
        for k, x in enumerate(positions):
            lagrangian = (
                lagrangian - strength * x @ x - sum(0.4 * (x - y) @ (x - y) for y in positions[:k])
            )
        return lagrangian

    start = element(group, random.normal(size=d)), 0.5 * random.normal(size=d)
    run = galvi.integrate(galvi.Problem(galvi.Lagrangian(L, group), *start), FOUR, 0.1, 12)
    assert run.success, run.status
    return run


def change(values):
    """The largest change of a momentum, relative to its largest size."""
    return np.abs(values - values[0]).max() / np.abs(values).max()


@pytest.mark.slow_cases("two bodies", "body, top and point")
@each_group
def test_angular_momentum_is_kept_and_linear_momentum_where_the_origin_does_not_pull(group):
    for strength in (0.0, 0.7):
        run = run_of_pulled_bodies(group, strength)
        angular, *linear = momenta(run)
        assert change(angular) < 1e-12  # 3e-15
        assert all((change(component) < 1e-12) == (strength == 0.0) for component in linear)
    assert all(change(component) > 1e-4 for component in linear)
    times = np.array([0.0, 0.33, 0.8, 1.15])
    between, at_one = momenta(run, times), momenta(run, 0.33)
    assert_agree(
        between, momenta_by_definition(run.problem.system, run(times), run.velocity(times))
    )
    assert_agree(at_one, [values[1] for values in between])


@each_group
def test_the_defect_of_rotations_is_the_largest_over_the_factors(group):
    run, _ = random_states(group, 3)
    assert galvi.orthogonality_defect(run).max() < 1e-14
    first_entry = 0
    for factor, _, _ in group_momenta.factors(group, run.q, run.p):
        q = np.array(run.q)
        q.reshape(4, -1)[2, first_entry] += 1e-3  # R_11, or x of a point
        spoiled = galvi.Trajectory(run.problem, run.t, q, run.p, counts={})
        defect = galvi.orthogonality_defect(spoiled)
        assert defect.shape == (4,) and np.delete(defect, 2).max() < 1e-14
        assert (defect[2] > 1e-5) == (not isinstance(factor, galvi.Rn))
        first_entry += int(np.prod(factor.shape))

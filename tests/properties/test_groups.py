"""Groups and their charts: their maps, tangent maps and inverses against mpmath and matrices."""

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, polar
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures.matrix_group import MAPS, MatrixGroup
from galvi.charts import CHARTS
from galvi.charts.chart import coordinates, place, tangent, unwrapped
from galvi.groups import GROUPS
from galvi.kernels.lie import product
from galvi.kernels.lie.dispatch import angle_of, coordinate_of
from galvi.lanes.group_collocation import Chart
from galvi.systems.finite_differences import WEIGHTS, cayley_rotation
from tests.properties.angles import CAYLEY, EXPONENTIAL, RODRIGUES
from tests.properties.group_matrices import element, title, vectors

each_group = pytest.mark.parametrize("group", GROUPS, ids=title)
each_chart = pytest.mark.parametrize("chart", CHARTS, ids=title)
SE3, TINY = galvi.SE3(), 1e-30


@pytest.mark.slow_cases("Product")
@each_group
@given(draws=st.data())
def test_the_product_and_the_inverse_are_those_of_matrices(group, draws):
    a, b = (element(group, draws.draw(vectors(group))) for _ in range(2))
    ab, matrix = group.multiply(a, b), MatrixGroup(group).matrix
    assert np.allclose(matrix(ab), matrix(a) @ matrix(b), atol=1e-14)
    assert np.allclose(matrix(group.inverse(a)), np.linalg.inv(matrix(a)), atol=1e-13)
    group.check("ab", ab)


@each_group
def test_the_curve_along_which_slopes_are_checked_is_the_exponential_of_matrices(group):
    d, matrices = group.dimension, MatrixGroup(group)
    q, xi = element(group, np.linspace(0.2, 1.1, d)), np.linspace(-2.0, 3.0, d)
    moved = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)._curve(q, xi)
    for s in (-0.125, 0.0, 0.1):
        exact = matrices.matrix(q) @ expm(s * matrices.hat(xi))
        assert np.allclose(matrices.matrix(moved(s)), exact, rtol=0.0, atol=1e-14)


@each_group
@given(draws=st.data())
def test_the_bracket_is_the_commutator_of_matrices(group, draws):
    v, w = (draws.draw(vectors(group)) for _ in range(2))
    hat = MatrixGroup(group).hat
    V, W = hat(v), hat(w)
    assert np.allclose(hat(group.bracket(v, w)), V @ W - W @ V, atol=1e-14)


@each_group
def test_many_elements_are_multiplied_and_inverted_at_once(group):
    rng = np.random.default_rng(1)
    a, b = (
        np.array([element(group, v) for v in rng.normal(size=(6, group.dimension))])
        for _ in range(2)
    )
    assert group.multiply(a, b).shape == (6, *group.shape)
    for k in range(6):
        assert np.allclose(group.multiply(a, b)[k], group.multiply(a[k], b[k]), atol=1e-15)
        assert np.allclose(group.inverse(a)[k], group.inverse(a[k]), atol=1e-15)


def test_a_product_is_joined_and_taken_apart():
    group = galvi.Product((galvi.SE3(), galvi.Rn(2), galvi.SO2()))
    assert group.shape == (22,) and group.dimension == 9
    parts = [element(f, np.arange(1.0, 1.0 + f.dimension)) for f in group.factors]
    for part, returned in zip(parts, group.parts(group.join(*parts)), strict=True):
        assert np.array_equal(part, returned)
    many = [np.stack([part, part, part]) for part in parts]
    assert group.join(*many).shape == (3, 22)
    assert group.parts(group.join(*many))[0].shape == (3, 4, 4)


@each_group
def test_an_element_off_by_rounding_is_accepted(group):
    g = element(group, np.linspace(0.5, 1.0, group.dimension))
    group.check("g", g + 1e-10 * (np.abs(g) > 1e-3) * (np.abs(g) < 0.999))


@given(angle=st.floats(0.0, 3.1), seed=st.integers(0, 100), size=st.floats(0.0, 0.3))
def test_the_nearest_rotation_is_that_of_scipy(angle, seed, size):
    """Also for a reflection, whose orthogonal polar factor is no rotation."""
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8])).as_matrix()
    for mirrored in (1.0, -0.4):
        matrix = R @ np.diag([1.0, 0.9, mirrored]) + size * rng.uniform(-1.0, 1.0, (3, 3))
        nearest = galvi.nearest_rotation(matrix)
        galvi.SO3().check("near", nearest)
        # The same sum of squares, by quaternions (Davenport) in scipy.
        scipys = Rotation.align_vectors(matrix.T, np.eye(3))[0].as_matrix()
        assert np.linalg.norm(nearest - matrix) <= np.linalg.norm(scipys - matrix) + 1e-12
        if np.linalg.det(matrix) > 0.1:
            assert np.allclose(nearest, polar(matrix)[0], atol=1e-12)


def test_a_wrong_bracket_is_caught():
    """Planted: the bracket of SE(3) without its second term."""
    v, w = np.arange(1.0, 7.0), np.array([2.0, -1.0, 0.5, 1.0, 0.0, 3.0])
    hat = MatrixGroup(galvi.SE3()).hat
    wrong = np.concatenate([np.cross(v[:3], w[:3]), np.cross(v[:3], w[3:])])
    assert not np.allclose(hat(wrong), hat(v) @ hat(w) - hat(w) @ hat(v), atol=0.1)


# ---------------------------------------------------------------- charts


def unit(group):
    """The unit of the group."""
    return element(group, np.zeros(group.dimension))


def mapped(name, chart, group, xi, *vectors):
    """The value of the map ``name`` of galvi.kernels.lie.groups, of velocities or momenta (d,)."""
    maps = Chart(group.layout.tolist(), chart.number)
    return np.array(maps.apply(name, list(xi), *map(list, vectors)), dtype=float)


def tangent_slope(chart, group, xi, eta):
    """d(T(xi) eta)/dxi, (d, d)."""
    units = np.eye(xi.size)
    return np.array(
        [mapped("momentum_slope", chart, group, xi, eta, basis_vector) for basis_vector in units]
    )


def sized(group, size):
    """xi with a rotation by ``size`` in each factor that turns, and translations of about 1."""
    if isinstance(group, galvi.Product):
        return np.concatenate([sized(factor, size) for factor in group.factors])
    axis = np.array([2.0, -3.0, 6.0]) / 7.0
    translation = np.array([0.7, -0.4, 1.1])
    in_plane = [size, *translation[:2]]
    kinds = {galvi.Rn: translation, galvi.SO2: in_plane, galvi.SE2: in_plane}
    return np.array(kinds.get(type(group), [*(size * axis), *translation]))[: group.dimension]


def slopes_of(chart, group, xi):
    """Phi(xi)^-1 dPhi(xi), (d, d), by a complex step, which has no rounding."""
    matrices, chart_map = MatrixGroup(group), MAPS[chart]
    X = matrices.hat(xi)
    rates = [chart_map(X + 1j * TINY * basis_matrix).imag / TINY for basis_matrix in matrices.basis]
    return np.array([matrices.vee(np.linalg.solve(chart_map(X), rate)) for rate in rates]).T


@each_group
@each_chart
@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.5, 2.0, None])
def test_the_chart_and_its_maps_are_those_of_matrices(group, chart, angle):
    """The angle None stands for the largest coordinate of a step."""
    size = chart.farthest if angle is None else coordinate_of(chart.number, angle)
    xi = sized(group, size)
    g = element(group, np.linspace(-1.0, 1.0, group.dimension))
    element_at_xi, T = place(chart, group, g, xi), tangent(chart, group, xi)
    assert np.allclose(element_at_xi, MatrixGroup(group).chart(chart, g, xi), rtol=0.0, atol=2e-14)
    assert np.allclose(T, slopes_of(chart, group, xi), rtol=0.0, atol=3e-14)
    mu = np.linspace(1.0, -0.6, group.dimension)
    assert np.allclose(mapped("momentum", chart, group, xi, mu), T.T @ mu, rtol=0.0, atol=3e-13)
    if angle is not None:
        assert np.allclose(mapped("rate", chart, group, xi, T @ mu), mu, rtol=0.0, atol=3e-14)
        returned = mapped("covector", chart, group, xi, T.T @ mu)
        assert np.allclose(returned, mu, rtol=0.0, atol=3e-14)
    if chart == CAYLEY or angle is not None:
        returned = coordinates(chart, group, g, element_at_xi)
        # The coordinates stretch rotations by 1 + |xi|^2 / 4 in a Cayley chart.
        stretched = 1.0 + {CAYLEY: 0.25, EXPONENTIAL: 0.0, RODRIGUES: 0.0625}[chart] * size**2
        assert np.allclose(returned, xi, rtol=0.0, atol=4e-15 * stretched)


@pytest.mark.parametrize("group", [galvi.SO3(), galvi.SE3()], ids=title)
@pytest.mark.parametrize("angle", [1e-9, 1e-3, 0.5, 2.0, 3.1])
def test_the_exponential_chart_is_the_exponential_in_forty_digits(group, angle):
    xi = sized(group, angle)
    with mp.workdps(40):
        exact = np.array(
            mp.expm(mp.matrix(MatrixGroup(group).hat(xi).tolist()), method="taylor").tolist()
        )
    at_xi = place(EXPONENTIAL, group, unit(group), xi)
    assert np.max(np.abs(at_xi - exact.astype(float))) < 5e-16  # 2.3e-16
    mu = np.array([0.7, 0.2, -0.4, 0.0, 0.0, 0.0])[: group.dimension]
    change = mapped("coadjoint_change", EXPONENTIAL, group, xi, mu)[:3]  # not R mu less mu
    turned = (exact[:3, :3] - np.eye(3)) @ mu[:3]
    assert np.max(np.abs(change - turned.astype(float))) < 5e-16


@pytest.mark.slow_cases("Cayley-Rn")
@each_group
@each_chart
@given(draws=st.data())
def test_the_slope_of_the_tangent_map_is_that_of_differences(group, chart, draws):
    xi, eta = draws.draw(vectors(group, 1.7)), draws.draw(vectors(group, 1.0))
    slopes, nudge = tangent_slope(chart, group, xi, eta), 2.0**-6
    for basis_vector, column in zip(np.eye(group.dimension), slopes.T, strict=True):
        derivative = sum(
            weight
            / nudge
            * (
                tangent(chart, group, xi + k * nudge * basis_vector)
                - tangent(chart, group, xi - k * nudge * basis_vector)
            )
            @ eta
            for k, weight in enumerate(WEIGHTS, start=1)
        )
        assert np.allclose(column, derivative, rtol=0.0, atol=2e-10)


@each_group
@each_chart
def test_at_zero_a_chart_is_the_identity_and_so_is_its_tangent_map(group, chart):
    zero, d = np.zeros(group.dimension), group.dimension
    g = element(group, np.linspace(0.1, 1.0, d))
    assert np.array_equal(place(chart, group, unit(group), zero), unit(group))
    assert np.array_equal(tangent(chart, group, zero), np.eye(d))
    assert np.array_equal(coordinates(chart, group, unit(group), unit(group)), zero)
    assert np.allclose(coordinates(chart, group, g, g), zero, atol=1e-16)


@each_chart
def test_a_chart_says_by_which_angle_it_turns_and_where_it_ends(chart):
    assert chart.limit == (np.pi if chart == CAYLEY else 2 * np.pi)
    assert angle_of(chart.number, chart.farthest) == pytest.approx(0.995 * chart.limit, rel=1e-14)
    for size in (1e-9, 0.3, 2.0, 3.1, 0.99 * chart.farthest):
        R = place(chart, galvi.SO3(), np.eye(3), sized(galvi.SO3(), size))
        angle = angle_of(chart.number, size)
        assert np.trace(R) == pytest.approx(1.0 + 2.0 * np.cos(angle), abs=4e-15)


@each_chart
def test_where_a_chart_ends_its_tangent_map_has_no_inverse(chart):
    size = {CAYLEY: 1e8, EXPONENTIAL: 2 * np.pi, RODRIGUES: 1e8}[chart]
    T = tangent(chart, galvi.SO3(), sized(galvi.SO3(), size))
    assert np.linalg.svd(T)[1].min() < 1e-7
    inner_size = {CAYLEY: 1.0, EXPONENTIAL: np.pi, RODRIGUES: 4.0}[chart]
    T = tangent(chart, galvi.SO3(), sized(galvi.SO3(), inner_size))
    assert np.linalg.svd(T)[1].min() > 0.4


@each_group
def test_many_are_placed_at_once(group):
    rng, d = np.random.default_rng(2), group.dimension
    xi, g = rng.normal(size=(2, 3, d)), element(group, np.linspace(0.0, 1.0, d))
    many = place(CAYLEY, group, g, xi)
    assert many.shape == (2, 3, *group.shape)
    assert np.array_equal(many[1, 2], place(CAYLEY, group, g, xi[1, 2]))
    assert np.array_equal(tangent(CAYLEY, group, xi)[1, 2], tangent(CAYLEY, group, xi[1, 2]))
    bases = np.stack([g] * 6).reshape(2, 3, *group.shape)
    assert np.allclose(coordinates(CAYLEY, group, bases, many), xi, atol=1e-12)


@pytest.mark.slow_cases(
    "Cayley-SE3", "Cayley-Product", "Exponential-Product", "ModifiedRodrigues-Product"
)
@each_group
@each_chart
@given(draws=st.data())
def test_covectors_go_to_the_base_and_back_as_matrices_say(group, chart, draws):
    xi, mu = draws.draw(vectors(group, 2.0)), draws.draw(vectors(group))
    at_base = mu + mapped("coadjoint_change", chart, group, xi, mu)
    assert np.allclose(mapped("coadjoint", chart, group, xi, at_base), mu, atol=1e-13)
    matrices = MatrixGroup(group)
    chart_matrix = matrices.matrix(place(chart, group, unit(group), xi))
    adjoint = [
        matrices.vee(np.linalg.solve(chart_matrix, basis_matrix @ chart_matrix))
        for basis_matrix in matrices.basis
    ]
    assert np.allclose(at_base, np.array(adjoint) @ mu, atol=1e-12)  # mu . Ad(Phi^-1) e


@pytest.mark.slow_cases("Rn")
@each_group
@given(draws=st.data())
def test_a_euclidean_slope_is_pulled_back_along_the_group(group, draws):
    """For a function that is not linear in the entries, by a complex step."""
    g = element(group, draws.draw(vectors(group, 1.5)))
    weights = np.random.default_rng(5).normal(size=g.size)

    def function(k):
        return np.sin(weights @ k.ravel())

    slope, pulled = np.cos(weights @ g.ravel()) * weights, np.empty(group.dimension)
    product.left_derivative(group.layout, g.ravel().copy(), slope, pulled)
    moved = [
        MatrixGroup(group).moved(g, 1j * TINY * basis_vector)
        for basis_vector in np.eye(group.dimension)
    ]
    expected = [function(k).imag / TINY for k in moved]
    assert np.allclose(pulled, expected, rtol=0.0, atol=1e-13)


@pytest.mark.slow_cases("Rn")
@each_group
def test_rounding_is_taken_out_of_an_element_to_second_order(group):
    g = element(group, np.linspace(-1.0, 1.0, group.dimension))
    disturbed = g.ravel() + 1e-6 * np.random.default_rng(6).normal(size=g.size) * (
        g.ravel() % 1.0 != 0
    )
    restored = disturbed.copy()
    product.restore(group.layout, restored)
    group.check("restored", restored.reshape(group.shape))
    assert np.max(np.abs(restored - disturbed)) < 1e-5


def test_another_chart_is_caught_by_the_matrices():
    """Cayley's formulas are right to second order in xi, and both are seen at a turn of 0.1."""
    xi = sized(SE3, 0.1)
    exact = MatrixGroup(SE3).chart(EXPONENTIAL, np.eye(4), xi)
    assert np.max(np.abs(place(CAYLEY, SE3, np.eye(4), xi) - exact)) > 1e-5
    assert np.max(np.abs(tangent(CAYLEY, SE3, xi) - slopes_of(EXPONENTIAL, SE3, xi))) > 1e-4


def test_a_path_is_followed_past_pi_and_back_through_the_identity():
    angles = np.array([0.0, 3.0, 3.3, 3.0, 1.5, 0.0, 0.5])[:, None]
    wrapped = (angles + np.pi) % (2.0 * np.pi) - np.pi
    path = unwrapped(EXPONENTIAL, galvi.SO2(), wrapped)
    np.testing.assert_allclose(path, angles, rtol=0.0, atol=1e-15)


@given(vectors(galvi.SO3()))
def test_the_rotation_along_which_functions_are_differenced_is_one(w):
    R = cayley_rotation(w)
    np.testing.assert_allclose(R @ R.T, np.eye(3), rtol=0.0, atol=1e-15 * (1.0 + w @ w))

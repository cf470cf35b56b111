"""Groups: their laws against matrices, what is refused as an element, the nearest rotation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, polar
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures.matrix_group import MatrixGroup
from galvi.groups import GROUPS
from tests.properties.group_matrices import element, title, vectors


@pytest.mark.slow_cases("Product")
@pytest.mark.parametrize("group", GROUPS, ids=title)
@given(data=st.data())
def test_the_product_and_the_inverse_are_those_of_matrices(group, data):
    a, b = (element(group, data.draw(vectors(group))) for _ in range(2))
    ab, matrix = group.multiply(a, b), MatrixGroup(group).matrix
    assert np.allclose(matrix(ab), matrix(a) @ matrix(b), atol=1e-14)
    assert np.allclose(matrix(group.inverse(a)), np.linalg.inv(matrix(a)), atol=1e-13)
    group.check("ab", ab)


@pytest.mark.parametrize("group", GROUPS, ids=title)
def test_the_curve_along_which_slopes_are_checked_is_the_exponential_of_matrices(group):
    d, matrices = group.dimension, MatrixGroup(group)
    q, xi = element(group, np.linspace(0.2, 1.1, d)), np.linspace(-2.0, 3.0, d)
    moved = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)._moved(q, xi)
    for s in (-0.125, 0.0, 0.1):
        exact = matrices.matrix(q) @ expm(s * matrices.hat(xi))
        assert np.allclose(matrices.matrix(moved(s)), exact, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("group", GROUPS, ids=title)
@given(data=st.data())
def test_the_bracket_is_the_commutator_of_matrices(group, data):
    v, w = (data.draw(vectors(group)) for _ in range(2))
    hat = MatrixGroup(group).hat
    V, W = hat(v), hat(w)
    assert np.allclose(hat(group.bracket(v, w)), V @ W - W @ V, atol=1e-14)


@pytest.mark.parametrize("group", GROUPS, ids=title)
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
    for part, again in zip(parts, group.parts(group.join(*parts)), strict=True):
        assert np.array_equal(part, again)
    many = [np.stack([part, part, part]) for part in parts]
    assert group.join(*many).shape == (3, 22)
    assert group.parts(group.join(*many))[0].shape == (3, 4, 4)


@pytest.mark.parametrize("group", GROUPS, ids=title)
def test_an_element_off_by_rounding_is_accepted(group):
    g = element(group, np.linspace(0.5, 1.0, group.dimension))
    group.check("g", g + 1e-10 * (np.abs(g) > 1e-3) * (np.abs(g) < 0.999))


@given(angle=st.floats(0.0, 3.1), seed=st.integers(0, 100), size=st.floats(0.0, 0.3))
def test_the_nearest_rotation_is_that_of_scipy(angle, seed, size):
    """Also to a reflection, of which the orthogonal factor of the polar decomposition is none."""
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8])).as_matrix()
    for mirrored in (1.0, -0.4):
        matrix = R @ np.diag([1.0, 0.9, mirrored]) + size * rng.uniform(-1.0, 1.0, (3, 3))
        near = galvi.nearest_rotation(matrix)
        galvi.SO3().check("near", near)
        # The same sum of squares, by quaternions (Davenport) in scipy.
        scipys = Rotation.align_vectors(matrix.T, np.eye(3))[0].as_matrix()
        assert np.linalg.norm(near - matrix) <= np.linalg.norm(scipys - matrix) + 1e-12
        if np.linalg.det(matrix) > 0.1:
            assert np.allclose(near, polar(matrix)[0], atol=1e-12)


def test_a_wrong_bracket_is_caught():
    """Of SE(3) without the second term, as of the direct product of rotations and translations."""
    v, w = np.arange(1.0, 7.0), np.array([2.0, -1.0, 0.5, 1.0, 0.0, 3.0])
    hat = MatrixGroup(galvi.SE3()).hat
    wrong = np.concatenate([np.cross(v[:3], w[:3]), np.cross(v[:3], w[3:])])
    assert not np.allclose(hat(wrong), hat(v) @ hat(w) - hat(w) @ hat(v), atol=0.1)

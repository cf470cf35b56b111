"""Groups: their laws against matrices, what is refused as an element, the nearest rotation."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.linalg import expm, polar
from scipy.optimize import minimize
from scipy.spatial.transform import Rotation

import galvi
from galvi.groups import GROUPS
from tests.properties.group_matrices import as_matrix, element, hat, title, vectors

BODY_AND_CART = galvi.Product((galvi.SO3(), galvi.Rn(1)))


@pytest.mark.slow_cases("Product")
@pytest.mark.parametrize("group", GROUPS, ids=title)
@given(data=st.data())
def test_the_product_and_the_inverse_are_those_of_matrices(group, data):
    a, b, c = (element(group, data.draw(vectors(group))) for _ in range(3))
    ab = group.multiply(a, b)
    assert np.allclose(as_matrix(group, ab), as_matrix(group, a) @ as_matrix(group, b), atol=1e-14)
    inverse = np.linalg.inv(as_matrix(group, a))
    assert np.allclose(as_matrix(group, group.inverse(a)), inverse, atol=1e-13)
    left, right = group.multiply(ab, c), group.multiply(a, group.multiply(b, c))
    assert np.allclose(left, right, atol=1e-13)
    one = group.multiply(a, group.inverse(a))
    assert np.allclose(as_matrix(group, one), np.eye(len(as_matrix(group, a))), atol=1e-14)
    assert np.allclose(group.multiply(one, b), b, atol=1e-13)
    group.check("ab", ab)


@pytest.mark.parametrize("group", GROUPS, ids=title)
def test_the_curve_along_which_slopes_are_checked_is_the_exponential_of_matrices(group):
    d = group.dimension
    q, xi = element(group, np.linspace(0.2, 1.1, d)), np.linspace(-2.0, 3.0, d)
    moved = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)._moved(q, xi)
    for s in (-0.125, 0.0, 0.1):
        exact = as_matrix(group, q) @ expm(s * hat(group, xi))
        assert np.allclose(as_matrix(group, moved(s)), exact, rtol=0.0, atol=1e-14)


@pytest.mark.parametrize("group", GROUPS, ids=title)
@given(data=st.data())
def test_the_bracket_is_the_commutator_of_matrices(group, data):
    v, w = (data.draw(vectors(group)) for _ in range(2))
    V, W = hat(group, v), hat(group, w)
    assert np.allclose(hat(group, group.bracket(v, w)), V @ W - W @ V, atol=1e-14)
    assert np.allclose(group.bracket(w, v), -group.bracket(v, w), atol=1e-14)


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


def test_groups_are_values():
    for group in GROUPS:
        again = type(group)(**vars(group))
        assert again == group and hash(again) == hash(group)
    assert galvi.Rn(2) != galvi.Rn(3)
    assert galvi.Product([galvi.SO3()]) == galvi.Product((galvi.SO3(),))


OFF = np.eye(3) + 1e-4 * np.diag([1.0, 0.0, 0.0])
FLIPPED = np.diag([1.0, 1.0, -1.0])
SHEARED = np.eye(4) + np.diag([0.5, 0.0], 2)


@pytest.mark.parametrize(
    ("group", "q0", "sentence"),
    [
        (galvi.SO3(), OFF, r"q0 must be a rotation, R\^T R = I with determinant 1, to 1e-09; "
         r"received \|R\^T R - I\| = 2\.0e-04\. The nearest rotation is \[\[1\.0, 0\.0, 0\.0\], "
         r".*\], from galvi\.nearest_rotation\."),
        (galvi.SO3(), FLIPPED, r"received determinant -1\. The nearest rotation is"),
        (galvi.SO3(), np.zeros((3, 3)), r"received \|R\^T R - I\| = 1\.0e\+00"),
        (galvi.SO3(), np.eye(2), r"q0 must be a rotation matrix of shape \(3, 3\); received shape "
         r"\(2, 2\)\."),
        (galvi.SO3(), np.eye(3).ravel(), r"received shape \(9,\)"),
        (galvi.SO2(), np.diag([1.0, -1.0]), "received determinant -1"),
        (galvi.SO2(), np.eye(3), r"shape \(2, 2\); received shape \(3, 3\)"),
        (galvi.Rn(2), np.zeros(3), r"q0 must have shape \(2,\); received shape \(3,\)"),
        (galvi.SE3(), np.eye(3), r"q0 must be a rigid motion \[\[R, x\], \[0, 0, 0, 1\]\] of shape "
         r"\(4, 4\); received shape \(3, 3\)"),
        (galvi.SE3(), np.eye(4) + np.diag([1e-12], -3), r"with last row \[1e-12, 0\.0, 0\.0, 1\.0"),
        (galvi.SE3(), SHEARED, "the rotation of q0 must be a rotation"),
        (BODY_AND_CART, np.zeros(9), r"q0 must have shape \(10,\), the entries of all factors; "
         r"received shape \(9,\)\. Make it with Product\.join"),
        (BODY_AND_CART, BODY_AND_CART.join(OFF, np.zeros(1)), r"part 0 of q0 must be a rotation"),
        (galvi.Product((BODY_AND_CART, galvi.SO2())), np.zeros(14),
         "part 0 of part 0 of q0 must be a rotation"),
    ],
)  # fmt: skip
def test_what_is_no_element_is_refused_in_one_sentence(group, q0, sentence):
    system = galvi.Lagrangian(lambda q, v: 0.5 * v @ v, group)
    with pytest.raises(ValueError, match=sentence) as refused:
        galvi.Problem(system, q0, np.ones(group.dimension))
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize("group", GROUPS, ids=title)
def test_an_element_off_by_rounding_is_accepted(group):
    g = element(group, np.linspace(0.5, 1.0, group.dimension))
    group.check("g", g + 1e-10 * (np.abs(g) > 1e-3) * (np.abs(g) < 0.999))


@given(angle=st.floats(0.0, 3.1), seed=st.integers(0, 100), size=st.floats(0.0, 0.3))
def test_the_nearest_rotation_is_that_of_scipy(angle, seed, size):
    rng = np.random.default_rng(seed)
    R = Rotation.from_rotvec(angle * np.array([0.6, 0.0, 0.8])).as_matrix()
    matrix = R + size * rng.uniform(-1.0, 1.0, (3, 3))
    near = galvi.nearest_rotation(matrix)
    galvi.SO3().check("near", near)
    # The same sum of squares, by quaternions (Davenport) in scipy.
    scipys = Rotation.align_vectors(matrix.T, np.eye(3))[0].as_matrix()
    assert np.linalg.norm(near - matrix) <= np.linalg.norm(scipys - matrix) + 1e-12
    if np.linalg.det(matrix) > 0.1:
        assert np.allclose(near, polar(matrix)[0], atol=1e-12)


def test_no_rotation_is_nearer_to_a_reflection():
    """Where the orthogonal factor of the polar decomposition is no rotation."""
    matrix = np.diag([1.0, 0.8, -0.3]) + 0.1 * np.random.default_rng(3).normal(size=(3, 3))
    near = galvi.nearest_rotation(matrix)
    assert np.linalg.det(near) == pytest.approx(1.0)

    def distance(rotvec):
        return np.linalg.norm(Rotation.from_rotvec(rotvec).as_matrix() - matrix)

    starts = np.random.default_rng(4).normal(size=(8, 3))
    best = min(minimize(distance, x, tol=1e-12).fun for x in starts)
    assert np.linalg.norm(near - matrix) == pytest.approx(best, abs=1e-7)
    assert np.linalg.norm(polar(matrix)[0] - matrix) < best - 0.1


def test_a_wrong_bracket_is_caught():
    """Of SE(3) without the second term, as of the direct product of rotations and translations."""

    class Wrong(galvi.SE3):
        def bracket(self, v, w):
            return np.concatenate([np.cross(v[:3], w[:3]), np.cross(v[:3], w[3:])])

    v, w = np.arange(1.0, 7.0), np.array([2.0, -1.0, 0.5, 1.0, 0.0, 3.0])
    V, W = hat(Wrong(), v), hat(Wrong(), w)
    assert not np.allclose(hat(Wrong(), Wrong().bracket(v, w)), V @ W - W @ V, atol=0.1)

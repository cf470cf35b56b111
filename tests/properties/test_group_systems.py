"""One motion on a group, given as a body, as Lagrangians, in Python and compiled."""

import numba
import numpy as np
import pytest

import galvi
from galvi.charts import CHARTS
from tests.properties.group_bodies import FOUR, MOMENTS, SO3, bent, bent_slope, kinetic, run, start
from tests.properties.group_matrices import element, title
from tests.properties.lagrangians import opaque

THREE = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))

compiled_bent, compiled_slope = numba.njit(bent), numba.njit(bent_slope)


@pytest.mark.slow(
    beside="test_integrate.py::test_plain_python_functions_give_the_compiled_result_to_the_bit"
)
def test_plain_python_gives_the_compiled_result_and_so_does_a_differenced_gradient():
    plain = run(galvi.RigidBody(MOMENTS, bent, bent_slope))
    compiled = run(galvi.RigidBody(MOMENTS, compiled_bent, compiled_slope))
    differenced = run(galvi.RigidBody(MOMENTS, opaque(bent)), steps=5)
    # The sums in `bent_slope` are numpy's in one and numba's in the other.
    assert np.allclose(plain.q, compiled.q, rtol=0.0, atol=2e-14)
    assert np.allclose(plain.q[:6], differenced.q, rtol=0.0, atol=2e-11)


@pytest.mark.slow(
    beside="test_integrate.py::test_plain_python_functions_give_the_compiled_result_to_the_bit"
)
def test_plain_python_gives_the_compiled_result_to_the_bit_when_its_sums_are_the_same():
    def slope(R):
        return np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3], [0.1 * R[0, 1], 0.0, -2.0 * R[2, 2]]])

    def slopes(R, v):
        return np.array([v[0], 1.5 * v[1], 2.0 * v[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, R[2, 0], 0.0,
                         R[2, 2] * R[0, 2]])  # fmt: skip

    for make in (
        lambda wrap: galvi.RigidBody(MOMENTS, bent, wrap(slope), check=False),
        lambda wrap: galvi.Lagrangian(kinetic, SO3, wrap(slopes), check=False),
    ):
        plain, compiled = (
            galvi.integrate(start(make(wrap)), FOUR, 0.2, 30) for wrap in (lambda f: f, numba.njit)
        )
        assert np.all(np.isfinite(plain.q))
        assert np.array_equal(plain.q, compiled.q) and np.array_equal(plain.p, compiled.p)
        assert plain.counts == compiled.counts


@pytest.mark.slow(
    beside="test_integrate.py::test_an_explicit_time_dependence_is_seen_by_compiled_and_plain_functions"
)
def test_an_explicit_time_is_seen_by_all_kinds_of_functions():
    """Two spins about the vertical in a field that turns: against Canonical with V(q, t)."""
    angle = galvi.Canonical(
        2.0, lambda q, t: -np.cos(q[0] - 0.5 * t), lambda q, t: np.sin(q - 0.5 * t),
        explicit_time=True,
    )  # fmt: skip
    plane = galvi.integrate(galvi.Problem(angle, [0.0], [0.3]), THREE, 0.2, 6)

    def field(R, t):
        return -(R[0, 0] * np.cos(0.5 * t) + R[1, 0] * np.sin(0.5 * t))

    def slope(R, t):
        out = np.zeros((3, 3))
        out[0, 0], out[1, 0] = -np.cos(0.5 * t), -np.sin(0.5 * t)
        return out

    def L(R, v, t):
        return 0.5 * (MOMENTS[0] * v[0] ** 2 + MOMENTS[1] * v[1] ** 2 + 2.0 * v[2] ** 2) - field(
            R, t
        )

    def slopes(R, v, t):
        return np.concatenate((np.array(MOMENTS) * v, -numba_slope(R, t).ravel()))

    numba_slope = numba.njit(slope)
    systems = [
        galvi.RigidBody(MOMENTS, field, slope, explicit_time=True),
        galvi.RigidBody(MOMENTS, field, numba_slope, explicit_time=True),
        galvi.RigidBody(MOMENTS, field, explicit_time=True),
        galvi.Lagrangian(L, SO3, explicit_time=True),
        galvi.Lagrangian(L, SO3, slopes, explicit_time=True),
        galvi.Lagrangian(L, SO3, numba.njit(slopes), explicit_time=True),
    ]
    # the exponential chart of rotations about one axis is the angle itself
    method = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3), galvi.Exponential())
    for system in systems:
        run = galvi.integrate(start(system, np.eye(3), [0.0, 0.0, 0.3]), method, 0.2, 6)
        assert np.allclose(run.q[:, 0, 0], np.cos(plane.q[:, 0]), rtol=0.0, atol=1e-12)
        assert np.allclose(run.p[:, 2], plane.p[:, 0], rtol=0.0, atol=1e-12)


@pytest.mark.slow(beside="test_a_lagrangian_on_a_vector_space_is_chapter_two_to_round_off")
def test_a_rigid_body_given_as_a_lagrangian_moves_alike():
    J = np.array(galvi.problems.pendulum_3d().system.inertia)
    weight = np.zeros((3, 3))
    weight[2, 2] = -9.81

    def L(R, v):
        return 0.5 * v @ J @ v + 9.81 * R[2, 2]

    def slopes(R, v):
        return np.concatenate((J @ v, -weight.ravel()))

    problem = galvi.problems.pendulum_3d()
    body = galvi.integrate(problem, THREE, 0.2, 6)
    for given_slopes in (None, slopes, numba.njit(slopes)):
        system = galvi.Lagrangian(L, SO3, given_slopes)
        mine = galvi.Problem(system, problem.q0, problem.v0)
        assert np.allclose(mine.p0, problem.p0, rtol=0.0, atol=1e-11)
        run = galvi.integrate(mine, THREE, 0.2, 6)
        close = 5e-12 if given_slopes is None else 5e-14
        assert np.allclose(run.q, body.q, rtol=0.0, atol=close)
        assert np.allclose(run.p, body.p, rtol=0.0, atol=10 * close)
        assert np.allclose(galvi.energy(run), galvi.energy(body), rtol=0.0, atol=10 * close)


@pytest.mark.slow_cases(but=["Gauss 4-Exponential"])
@pytest.mark.parametrize("chart", CHARTS, ids=title)
@pytest.mark.parametrize(
    "method",
    [(4, galvi.gauss(4)), (3, galvi.lobatto(4)), (5, galvi.gauss(8))],
    ids=lambda pair: pair[1].name,
)
def test_a_lagrangian_on_a_vector_space_is_chapter_two_to_round_off(chart, method):
    problem = galvi.problems.kepler(0.6)

    def slopes(q, v):
        return np.concatenate((v, -q / np.sqrt(np.sum(q * q)) ** 3))

    def L(q, v):
        return 0.5 * np.sum(v * v) + 1.0 / np.sqrt(np.sum(q * q))

    pair = galvi.Polynomials(method[0]), method[1]
    expected = galvi.integrate(problem, galvi.Galerkin(*pair), 0.1, 20)
    for given_slopes in (slopes, numba.njit(slopes)):
        system = galvi.Lagrangian(L, galvi.Rn(2), given_slopes)
        mine = galvi.Problem(system, problem.q0, problem.v0)
        run = galvi.integrate(mine, galvi.Galerkin(*pair, chart), 0.1, 20)
        assert np.allclose(run.q, expected.q, rtol=0.0, atol=2e-13)
        assert np.allclose(run.p, expected.p, rtol=0.0, atol=2e-13)
        times = np.linspace(0.0, 2.0, 50)
        assert np.allclose(run(times), expected(times), rtol=0.0, atol=2e-13)
        assert np.allclose(run.velocity(times), expected.velocity(times), rtol=0.0, atol=2e-12)
        assert np.allclose(galvi.energy(run), galvi.energy(expected), rtol=0.0, atol=1e-12)


def test_a_pendulum_on_rotations_of_the_plane_is_the_one_of_the_angle():
    problem = galvi.problems.planar_pendulum(2.5)
    angle = galvi.integrate(problem, FOUR, 0.2, 60)

    def L(R, v):
        return 0.5 * v[0] ** 2 + R[0, 0]

    def slopes(R, v):
        return np.array([v[0], 1.0, 0.0, 0.0, 0.0])

    system = galvi.Lagrangian(L, galvi.SO2(), numba.njit(slopes))
    q0 = element(galvi.SO2(), problem.q0)
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), galvi.Exponential())
    run = galvi.integrate(galvi.Problem(system, q0, problem.v0), method, 0.2, 60)
    assert np.allclose(run.q[:, 0, 0], np.cos(angle.q[:, 0]), rtol=0.0, atol=1e-13)
    assert np.allclose(run.q[:, 1, 0], np.sin(angle.q[:, 0]), rtol=0.0, atol=1e-13)
    assert np.allclose(run.p, angle.p, rtol=0.0, atol=1e-13)
    with pytest.raises(ValueError, match=r"attitudes need a run on SO\(3\) or SE\(3\)"):
        galvi.rotations(run)


@pytest.mark.slow(beside="test_a_pendulum_on_rotations_of_the_plane_is_the_one_of_the_angle")
def test_a_body_in_the_plane_moves_as_in_its_angle_and_place():
    """With its centre of mass, c in its frame, off the origin, and a spring to the point 0."""
    mass, inertia, centre = 1.3, 0.7, np.array([0.4, -0.2])

    def on_group(g, v):
        moved = v[1:] + v[0] * np.array([-centre[1], centre[0]])
        place = g[:2, :2] @ centre + g[:2, 2]
        return 0.5 * inertia * v[0] ** 2 + 0.5 * mass * moved @ moved - place @ place

    def on_vectors(q, v):
        cosine, sine = np.cos(q[0]), np.sin(q[0])
        R = np.array([[cosine, -sine], [sine, cosine]])
        slope = np.array([[-sine, -cosine], [cosine, -sine]]) @ centre
        moved, place = v[1:] + v[0] * slope, R @ centre + q[1:]
        return 0.5 * inertia * v[0] ** 2 + 0.5 * mass * moved @ moved - place @ place

    q0, v0 = np.array([0.6, 0.3, -0.8]), np.array([1.1, 0.5, 0.2])
    g0 = element(galvi.SE2(), q0)
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6), galvi.Exponential())
    plane = galvi.Problem(galvi.Lagrangian(on_vectors, galvi.Rn(3)), q0, v0)
    body = galvi.Problem(
        galvi.Lagrangian(on_group, galvi.SE2()), g0, [v0[0], *(g0[:2, :2].T @ v0[1:])]
    )
    one, two = (galvi.integrate(problem, method, 0.1, 5) for problem in (plane, body))
    assert np.allclose(two.q, [element(galvi.SE2(), q) for q in one.q], rtol=0.0, atol=1e-11)
    assert np.allclose(galvi.energy(two), galvi.energy(one), rtol=0.0, atol=1e-11)


@pytest.mark.slow_cases(but=["falling-Cayley"])
@pytest.mark.parametrize("chart", CHARTS, ids=title)
@pytest.mark.parametrize("g", [(0.0, 0.0, 0.0), (0.5, 0.0, -9.81)], ids=["drifting", "falling"])
def test_a_free_body_turns_as_a_rigid_body_and_flies_as_a_point(chart, g):
    """In the air each of 20 steps rounds, at 12 stages, the moment of the linear momentum over its
    own way, up to 12.5 times 100, in the chart at its start; Newton's method loses less."""
    method = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12), chart)
    problem = galvi.problems.free_body_se3(g=g)
    turning = galvi.integrate(galvi.problems.free_rigid_body(), method, 0.25, 20)
    run = galvi.integrate(problem, method, 0.25, 20)
    close = 20 * 12 * 12.5 * 100.0 * 2.0**-53 if any(g) else 3e-14  # 1.1e-11 of 3.3e-11, and 5e-15
    assert np.allclose(run.q[:, :3, :3], turning.q, rtol=0.0, atol=close)
    assert np.allclose(run.p[:, :3], turning.p, rtol=0.0, atol=10 * close)
    v0, t = problem.v0[3:], run.t[:, None]
    fallen = v0 * t + 0.5 * np.array(g) * t**2
    assert np.allclose(run.q[:, :3, 3], fallen, rtol=0.0, atol=1e-12 * (1.0 + np.abs(fallen).max()))
    flown = problem.system.mass * (v0 + np.array(g) * t)
    assert np.allclose(
        galvi.linear_momentum(run), flown, rtol=0.0, atol=1e-12 * np.abs(flown).max()
    )
    energy = galvi.energy(run)  # that of turning changes by w times what p does
    allowed = 1e-12 * (1.0 + np.abs(fallen).max()) + 10 * close * np.linalg.norm(problem.v0[:3])
    assert np.allclose(energy, energy[0], rtol=0.0, atol=allowed)


@pytest.mark.slow(beside="test_a_pendulum_on_rotations_of_the_plane_is_the_one_of_the_angle")
def test_a_cart_with_a_pendulum_follows_its_equations():
    """On R^1 x SO(2), with a mass matrix that depends on the angle, against scipy."""
    from scipy.integrate import solve_ivp

    group = galvi.Product((galvi.Rn(1), galvi.SO2()))
    cart, bob, length, g = 2.0, 1.0, 0.7, 9.81

    def L(q, v):
        cosine = q[1]
        moving = 0.5 * (cart + bob) * v[0] ** 2 + 0.5 * bob * length**2 * v[1] ** 2
        return moving + bob * length * v[0] * v[1] * cosine + bob * g * length * cosine

    def slopes(q, v):
        coupled = bob * length
        return np.array([
            (cart + bob) * v[0] + coupled * q[1] * v[1],
            coupled * length * v[1] + coupled * q[1] * v[0],
            0.0, coupled * (v[0] * v[1] + g), 0.0, 0.0, 0.0,
        ])  # fmt: skip

    def right(t, y):
        sine, cosine = np.sin(y[1]), np.cos(y[1])
        M = np.array(
            [[cart + bob, bob * length * cosine], [bob * length * cosine, bob * length**2]]
        )
        force = [bob * length * y[3] ** 2 * sine, -bob * g * length * sine]
        return np.concatenate([y[2:], np.linalg.solve(M, force)])

    exact = solve_ivp(right, (0.0, 1.0), [0.3, 1.2, 0.5, -1.0], "DOP853", rtol=1e-13, atol=1e-13)
    x, angle, u, rate = exact.y[:, -1]
    q0 = group.join(np.array([0.3]), element(galvi.SO2(), [1.2]))
    method = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))
    close = 2e-9  # 3e-10, the method's error
    for given_slopes in (None, slopes, numba.njit(slopes)):
        problem = galvi.Problem(galvi.Lagrangian(L, group, given_slopes), q0, [0.5, -1.0])
        run = galvi.integrate(problem, method, 0.125, 8)
        there, turned = group.parts(run.q[-1])
        assert abs(there[0] - x) < close
        assert np.allclose(turned, element(galvi.SO2(), [angle]), rtol=0.0, atol=close)
        coupled = bob * length * np.cos(angle)
        momenta = (cart + bob) * u + coupled * rate, bob * length**2 * rate + coupled * u
        assert np.allclose(run.p[-1], momenta, rtol=0.0, atol=30 * close)
        energy = galvi.energy(run)
        assert np.allclose(energy, energy[0], rtol=0.0, atol=10 * close)

"""Rigid bodies and Lagrangians: derivatives against independent ones, bad input, equal systems."""

import numba
import numpy as np
import pytest
from hypothesis import given
from scipy.spatial.transform import Rotation

import galvi
from galvi.charts import CHARTS
from galvi.charts.maps import place
from galvi.systems.differences import WEIGHTS
from tests.galvi.group_matrices import element, title, vectors

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
THREE = galvi.Galerkin(galvi.Polynomials(3), galvi.gauss(3))
SO3, MOMENTS, SPIN = galvi.SO3(), (1.0, 1.5, 2.0), np.array([0.3, -0.8, 0.5])
R0 = Rotation.from_rotvec([0.4, -0.9, 1.3]).as_matrix()
TWIST = np.array([[0.3, -1.0, 0.2], [0.7, 0.1, 0.4], [-0.5, 0.6, 0.9]])


def bent(R):
    """A potential that is not linear in R."""
    return np.sum(TWIST * R) ** 2 + 0.5 * np.sum(TWIST.T * R)


def bent_slope(R):
    return 2.0 * np.sum(TWIST * R) * TWIST + 0.5 * TWIST.T


def timed(R, t):
    return np.cos(t) * np.sum(TWIST * R)


def timed_slope(R, t):
    return np.cos(t) * TWIST


compiled_bent, compiled_slope = numba.njit(bent), numba.njit(bent_slope)
compiled_timed_slope = numba.njit(timed_slope)


def start(system, q0=R0, v0=SPIN):
    return galvi.Problem(system, q0, v0)


def run(system, method=FOUR, step=0.2, steps=30, **more):
    done = galvi.integrate(start(system), method, step, steps, **more)
    assert done.success, done.status
    return done


def along(function, group, g, a, nudge=2.0**-7):
    """The derivative of function(g) along g hat(e_a), by differences of order eight."""
    unit = np.eye(group.dimension)[a]
    return sum(
        weight / nudge
        * (function(place(CHARTS[1], group, g, k * nudge * unit))
           - function(place(CHARTS[1], group, g, -k * nudge * unit)))
        for k, weight in enumerate(WEIGHTS, start=1)
    )  # fmt: skip


@pytest.mark.parametrize(
    "system",
    [
        galvi.RigidBody(MOMENTS, bent, bent_slope),
        galvi.RigidBody(MOMENTS, bent),
        galvi.RigidBody(MOMENTS, galvi.UniformGravity(2.0, (0.1, -0.3, 0.8), (1.0, 2.0, -9.0))),
        galvi.RigidBody(MOMENTS),
        galvi.RigidBody(MOMENTS, timed, timed_slope, explicit_time=True),
        galvi.RigidBody(MOMENTS, timed, explicit_time=True),
    ],
)
@given(v=vectors(SO3))
def test_the_torque_is_minus_the_slope_of_the_potential_along_the_group(system, v):
    R, t = element(SO3, v), 0.7

    def potential(R):
        return float(system.potential_energy(R, np.array(t)))

    expected = [-along(potential, SO3, R, a) for a in range(3)]
    assert np.allclose(system.torque(R, t), expected, rtol=0.0, atol=3e-11)


def test_the_weight_is_the_product_of_mass_gravity_and_height():
    gravity = galvi.UniformGravity(2.0, (0.0, 0.0, 0.5))
    assert np.array_equal(gravity.g, [0.0, 0.0, -9.81])
    assert gravity(np.eye(3)) == pytest.approx(2.0 * 9.81 * 0.5)
    assert gravity(R0) == pytest.approx(2.0 * 9.81 * (0.5 * R0[2, 2]))
    body = galvi.RigidBody(MOMENTS, gravity)
    upside = Rotation.from_euler("x", 0.3).as_matrix()  # it falls on to the side it leans to
    assert body.torque(upside, 0.0)[0] == pytest.approx(2.0 * 9.81 * 0.5 * np.sin(0.3))


NOT_FINITE = "potential and gradient must be finite at the start"
REMEDY = r" Give three positive moments, each at most the sum of the others, or such a matrix\."


@pytest.mark.parametrize(
    ("make", "error", "sentence"),
    [
        (lambda: galvi.RigidBody((1.0, -1.0, 1.0)), ValueError,
         r"inertia must be positive definite; received principal moments \[-1\.0, 1\.0, 1\.0\]\."
         + REMEDY),
        (lambda: galvi.RigidBody((0.0, 1.0, 1.0)), ValueError, "inertia must be positive definite"),
        (lambda: galvi.RigidBody((1.0, 1.0, 2.1)), ValueError,
         r"no body has the inertia \[1\.0, 1\.0, 2\.1\]: its largest moment exceeds the sum of the "
         r"others, which masses at real places cannot do\." + REMEDY),
        (lambda: galvi.RigidBody([[2, 0.5, 0], [0, 2, 0], [0, 0, 2]]), ValueError,
         "inertia must be symmetric; received"),
        (lambda: galvi.RigidBody([1.0, 2.0]), ValueError,
         r"inertia must have shape \(3,\) or \(3, 3\); received shape \(2,\)"),
        (lambda: galvi.RigidBody(3.0), ValueError, r"received shape \(\)"),
        (lambda: galvi.RigidBody((1.0, np.nan, 1.0)), ValueError, "inertia must hold finite"),
        (lambda: galvi.RigidBody("abc"), ValueError, "inertia must be an array of real numbers"),
        (lambda: galvi.FreeBody(1.0, (1.0, 1.0, 2.1)), ValueError, "no body has the inertia"),
        (lambda: galvi.FreeBody(-1.0, MOMENTS), ValueError, "mass must be positive; received -1"),
        (lambda: galvi.FreeBody(1.0, MOMENTS, 9.81), ValueError, r"g must have shape \(3,\)"),
        (lambda: galvi.RigidBody(MOMENTS, 3), TypeError, "potential must be a function of R"),
        (lambda: galvi.RigidBody(MOMENTS, bent, 3), TypeError, "gradient must be a function of R"),
        (lambda: galvi.RigidBody(MOMENTS, gradient=bent_slope), ValueError,
         "a gradient needs its potential; received none"),
        (lambda: galvi.RigidBody(MOMENTS, galvi.UniformGravity(1.0, SPIN), explicit_time=True),
         ValueError, r"explicit_time means functions of \(R, t\)"),
        (lambda: galvi.UniformGravity(0.0, SPIN), ValueError, "mass must be positive"),
        (lambda: galvi.UniformGravity(1.0, (0.0, 1.0)), ValueError, r"centre must have shape"),
        (lambda: galvi.UniformGravity(1.0, SPIN, np.ones(2)), ValueError, r"g must have shape"),
        (lambda: galvi.Problem(galvi.RigidBody(MOMENTS), 1.001 * R0, SPIN), ValueError,
         r"q0 must be a rotation, .* received \|R\^T R - I\| = 2\.0e-03\. The nearest rotation is"),
        (lambda: galvi.Problem(galvi.RigidBody(MOMENTS), R0, np.eye(3)), ValueError,
         r"v0 must have shape \(3,\); received shape \(3, 3\)\. v0 is the body velocity\."),
        (lambda: galvi.Problem(galvi.FreeBody(1.0, MOMENTS), R0, np.ones(6)), ValueError,
         "q0 must be a rigid motion"),
        (lambda: galvi.Problem(galvi.FreeBody(1.0, MOMENTS), np.eye(4), SPIN), ValueError,
         r"v0 must have shape \(6,\)"),
        (lambda: galvi.Lagrangian(3, SO3), TypeError, r"function must be a function of \(q, v\)"),
        (lambda: galvi.Lagrangian(bent, SO3, 3), TypeError, r"slopes must be a function of"),
        (lambda: galvi.Lagrangian(bent, 3), TypeError, r"group must be a group such as galvi.SO3"),
        (lambda: galvi.Lagrangian(bent, galvi.SO3), TypeError, "group must be a group such as"),
        (lambda: galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), galvi.Exponential), TypeError,
         r"chart must be a chart such as galvi\.Cayley\(\); received <class"),
        (lambda: galvi.Galerkin(galvi.Polynomials, galvi.gauss(2)), TypeError,
         r"space must be a space such as galvi\.Polynomials\(8\); received <class"),
        (lambda: galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2), 0), TypeError,
         r"chart must be a chart such as"),
    ],
)  # fmt: skip
def test_systems_that_cannot_be_are_refused_in_one_sentence(make, error, sentence):
    with pytest.raises(error, match=sentence):
        make()


def kinetic(q, v):
    return 0.5 * v @ v


@pytest.mark.parametrize(
    ("system", "sentence"),
    [
        (galvi.RigidBody(MOMENTS, lambda R: np.nan), NOT_FINITE),
        (galvi.RigidBody(MOMENTS, bent, lambda R: np.inf * R), NOT_FINITE),
        (galvi.RigidBody(MOMENTS, lambda R: R), r"potential must return a number; received an arr"),
        (galvi.RigidBody(MOMENTS, lambda R: None), "potential must return a real number; received"),
        (galvi.RigidBody(MOMENTS, lambda R: 1j), "potential must return a real number; received"),
        (galvi.RigidBody(MOMENTS, bent, lambda R: R[0]),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(3,\)"),
        (galvi.RigidBody(MOMENTS, bent, numba.njit(lambda R: R[0])),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(3,\)"),
        (galvi.RigidBody(MOMENTS, bent, numba.njit(lambda R: R[:2] + 0.0)),
         r"gradient must return an array of shape \(3, 3\), dV/dR; received shape \(2, 3\)"),
        (galvi.Lagrangian(lambda q, v: np.nan, SO3), "the Lagrangian must return a finite number"),
        (galvi.Lagrangian(lambda q, v: v, SO3), "the Lagrangian must return a number; received an"),
        (galvi.Lagrangian(lambda q, v: "a", SO3), "the Lagrangian must return a real number; rec"),
        (galvi.Lagrangian(lambda q, v: v[0] ** 2 + v[1] ** 2, SO3),
         r"the Lagrangian is degenerate at the start: d2L/dv2 is singular, with eigenvalues"),
        (galvi.Lagrangian(lambda q, v: 3.0 * v[0], SO3), "the Lagrangian is degenerate"),
        (galvi.Lagrangian(kinetic, SO3, lambda q, v: v),
         r"slopes must return dL/dv and dL/dq in an array of shape \(12,\); received shape \(3,\)"),
        (galvi.Lagrangian(kinetic, SO3, numba.njit(lambda q, v: v + 0.0)), "slopes must return"),
        (galvi.Lagrangian(kinetic, SO3, lambda q, v: np.full(12, np.nan)),
         "the derivatives of the Lagrangian must be finite at the start"),
    ],
)  # fmt: skip
def test_functions_that_cannot_be_used_are_refused_before_the_first_step(system, sentence):
    problem = start(system)
    with pytest.raises(ValueError, match=sentence):
        galvi.integrate(problem, FOUR, 0.1, 3)
    with pytest.raises(ValueError, match=sentence):
        galvi.integrate_many([problem], FOUR, 0.1, 3)


@pytest.mark.parametrize("which", ["potential", "gradient", "function", "slopes"])
def test_what_a_users_function_raises_reaches_the_caller(which):
    calls = []

    def raises(*qv):
        calls.append(1)
        if len(calls) > 400:
            raise LookupError("left the table")
        if which == "slopes":
            return np.concatenate([qv[1], np.zeros(9)])
        return {"gradient": 0.0 * qv[0], "function": 0.5 * np.sum(qv[-1] ** 2)}.get(which, 0.0)

    systems = {
        "potential": lambda: galvi.RigidBody(MOMENTS, raises),
        "gradient": lambda: galvi.RigidBody(MOMENTS, bent, raises),
        "function": lambda: galvi.Lagrangian(raises, SO3),
        "slopes": lambda: galvi.Lagrangian(kinetic, SO3, raises),
    }
    with pytest.raises(LookupError, match="left the table"):
        galvi.integrate(start(systems[which]()), FOUR, 0.1, 1000)


@pytest.mark.parametrize("plain", [True, False], ids=["python", "numba"])
@pytest.mark.parametrize("which", ["gradient", "slopes"])
def test_nan_from_a_users_function_during_the_run_is_a_failure(which, plain):
    def gradient(R):
        return 0.0 * R if R[0, 0] > 0.5 else np.nan * R

    def slopes(R, v):
        return np.concatenate((v, (0.0 if R[0, 0] > 0.5 else np.nan) * R.ravel()))

    if not plain:
        gradient, slopes = numba.njit(gradient), numba.njit(slopes)
    system = (
        galvi.RigidBody((1.0, 1.0, 1.0), bent, gradient)
        if which == "gradient"
        else galvi.Lagrangian(kinetic, SO3, slopes)
    )
    # turned about the vertical at unit speed, R_00 = cos t is below 0.5 from t = 1.047 on
    run = galvi.integrate(start(system, np.eye(3), [0.0, 0.0, 1.0]), FOUR, 0.1, 40)
    assert run.failed_step == 11 and not run.success
    assert run.status.startswith("Stopped at step 11 of 40, from t = 1: the force or the state")
    assert np.isfinite(run.q[:11]).all() and np.isnan(run.q[11:]).all()
    assert np.isnan(run.p[11:]).all() and np.isnan(run(1.05)).all()


def test_plain_python_gives_the_compiled_result_and_so_does_a_differenced_gradient():
    plain = run(galvi.RigidBody(MOMENTS, bent, bent_slope))
    compiled = run(galvi.RigidBody(MOMENTS, compiled_bent, compiled_slope))
    differenced = run(galvi.RigidBody(MOMENTS, bent), steps=5)
    # The sums in `bent_slope` are numpy's in one and numba's in the other.
    assert np.allclose(plain.q, compiled.q, rtol=0.0, atol=2e-14)
    assert np.allclose(plain.q[:6], differenced.q, rtol=0.0, atol=2e-11)
    assert differenced.counts["potential_evaluations"] == (
        3 * 24 * differenced.counts["force_evaluations"]
    )
    assert "potential_evaluations" not in plain.counts


def test_plain_python_gives_the_compiled_result_to_the_bit_when_its_sums_are_the_same():
    def slope(R):
        return np.array([[0.0, 0.0, 0.0], [0.0, 0.0, 0.3], [0.1 * R[0, 1], 0.0, -2.0 * R[2, 2]]])

    def slopes(R, v):
        return np.array([v[0], 1.5 * v[1], 2.0 * v[2], 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, R[2, 0], 0.0,
                         R[2, 2] * R[0, 2]])  # fmt: skip

    for make in (
        lambda wrap: galvi.RigidBody(MOMENTS, bent, wrap(slope)),
        lambda wrap: galvi.Lagrangian(kinetic, SO3, wrap(slopes)),
    ):
        plain, compiled = run(make(lambda f: f)), run(make(numba.njit))
        assert np.array_equal(plain.q, compiled.q) and np.array_equal(plain.p, compiled.p)
        assert plain.counts == compiled.counts


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


@pytest.mark.parametrize("chart", CHARTS, ids=title)
@pytest.mark.parametrize("g", [(0.0, 0.0, 0.0), (0.5, 0.0, -9.81)], ids=["drifting", "falling"])
def test_a_free_body_turns_as_a_rigid_body_and_flies_as_a_point(chart, g):
    """In the air with rounding of x times the linear momentum, here 100 times 100."""
    method = galvi.Galerkin(galvi.Polynomials(12), galvi.gauss(12), chart)
    problem = galvi.problems.free_body_se3(g=g)
    turning = galvi.integrate(galvi.problems.free_rigid_body(), method, 0.25, 20)
    run = galvi.integrate(problem, method, 0.25, 20)
    close = 3e-12 if any(g) else 3e-14  # 9e-13 and 5e-15
    assert np.allclose(run.q[:, :3, :3], turning.q, rtol=0.0, atol=close)
    assert np.allclose(run.p[:, :3], turning.p, rtol=0.0, atol=10 * close)
    v0, t = problem.v0[3:], run.t[:, None]
    fallen = v0 * t + 0.5 * np.array(g) * t**2
    assert np.allclose(run.q[:, :3, 3], fallen, rtol=0.0, atol=1e-12 * (1.0 + np.abs(fallen).max()))
    flown = problem.system.mass * (v0 + np.array(g) * t)
    assert np.allclose(
        galvi.linear_momentum(run), flown, rtol=0.0, atol=1e-12 * np.abs(flown).max()
    )
    energy = galvi.energy(run)
    assert np.allclose(energy, energy[0], rtol=0.0, atol=1e-12 * (1.0 + np.abs(fallen).max()))


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


def test_momentum_and_velocity_of_a_lagrangian_undo_each_other():
    problem = galvi.Problem(
        galvi.Lagrangian(lambda q, v: 0.25 * (v @ v) ** 2 + 0.5 * v @ v + q[0] * v[1], galvi.Rn(2)),
        [0.4, 0.1], [0.8, -0.5],
    )  # fmt: skip
    system = problem.system
    by_hand = (problem.v0 @ problem.v0 + 1.0) * problem.v0 + [0.0, 0.4]
    assert np.allclose(problem.p0, by_hand, rtol=0.0, atol=1e-11)
    assert np.allclose(system.velocity(problem.p0, problem.q0), problem.v0, rtol=0.0, atol=1e-10)
    with pytest.raises(ValueError, match="momentum depends on the configuration; give q"):
        system.momentum(problem.v0)


def test_a_wrong_gradient_is_caught_by_the_differences_and_by_the_energy():
    wrong = galvi.RigidBody(MOMENTS, bent, lambda R: bent_slope(R) + 1e-5 * TWIST.T)
    expected = [-along(bent, SO3, R0, a) for a in range(3)]
    assert not np.allclose(wrong.torque(R0, 0.0), expected, rtol=0.0, atol=1e-7)
    drift = [np.ptp(galvi.energy(run(system, step=0.05))) for system in (
        galvi.RigidBody(MOMENTS, bent, bent_slope), wrong)]  # fmt: skip
    assert drift[0] < 1e-9 < 1e-7 < drift[1]

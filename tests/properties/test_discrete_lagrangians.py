"""Discrete Lagrangians against runs, differences, closed forms and stationary polynomials."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import root

import galvi
from references.closed_forms.kepler_action import kepler_action
from references.closed_forms.oscillator import oscillator_action
from tests.properties.forced_systems import MASS, SYSTEMS
from tests.properties.group_matrices import element
from tests.properties.group_motions import COUPLED, RODRIGUES, collocation

FOUR, EXPONENTIAL = collocation(4), galvi.Exponential()
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER, SPRING = galvi.problems.kepler(0.3), galvi.problems.harmonic_oscillator(0.3)
ROUND = galvi.problems.kepler(0.1)
DRIVEN = replace(galvi.problems.driven_oscillator(), t0=0.7)
MASSLESS = galvi.Problem(
    galvi.NBody([1.0, 0.1, 0.0]), [[0, 0], [1, 0], [0, 2]], [[0, -0.1], [0, 1], [0.7, 0]]
)


def branching(q, v):
    """The Lagrangian of a bead on a parabola, behind a branch, which keeps it from being traced."""
    return 0.5 * v[0] ** 2 * (1.0 + q[0] ** 2) - 0.5 * q[0] ** 2 if q[0] < 1e9 else 0.0


def pair(space, rule):
    return galvi.Galerkin(space, rule)


FREE = {
    "kepler": (KEPLER, FOUR, 0.2),
    "Lobatto's rule": (SPRING, pair(galvi.Polynomials(3), galvi.lobatto(4)), 0.4),
    "Radau's rule": (KEPLER, pair(galvi.Polynomials(3), galvi.radau(3)), 0.2),
    "pieces": (
        KEPLER,
        pair(galvi.PiecewisePolynomials(2, 2), galvi.composite(galvi.gauss(3), 2)),
        0.2,
    ),
    "degrees by component": (KEPLER, pair(galvi.ComponentPolynomials((3, 5)), galvi.gauss(5)), 0.2),
    "backwards": (KEPLER, FOUR, -0.2),
    "a driven oscillator": (DRIVEN, FOUR, 0.3),
    "a full mass": (
        galvi.Problem(galvi.Canonical(MASS, galvi.LinearSpring(1.5)), [1.0, 0.5], [0.1, 0.4]),
        FOUR,
        0.3,
    ),
    "a double pendulum": (galvi.problems.double_pendulum(), FOUR, 0.05),
    "a body": (galvi.problems.free_rigid_body(), FOUR, 0.1),
    "a pendulum": (galvi.problems.pendulum_3d(), collocation(3, EXPONENTIAL), 0.1),
    "a top": (galvi.problems.heavy_top(), collocation(4, RODRIGUES), 0.05),
    "a moving body": (
        galvi.problems.free_body_se3(g=(0.0, 0.5, -9.81)),
        collocation(3, EXPONENTIAL),
        0.1,
    ),
    "a product": (COUPLED, collocation(3, RODRIGUES), 0.1),
    "an arm": (galvi.problems.skew_arm(), FOUR, 0.01),
    "a floating arm": (galvi.problems.skew_arm(floating=True), collocation(2, EXPONENTIAL), 0.02),
}
FORCED = {
    "planets": (galvi.problems.outer_solar_system(), FOUR, 50.0),
    "relativity": (
        galvi.Problem(
            galvi.NBody([1.0, 1e-3], forces=galvi.Relativity(9.0)),
            [[0, 0], [1, 0]],
            [[0, -1e-3], [0, 1]],
        ),
        FOUR,
        0.1,
    ),
    "a massless body": (MASSLESS, FOUR, 0.1),
    "a damped arm": (galvi.problems.skew_arm(damping=0.1), FOUR, 0.01),
    **{
        name: (galvi.Problem(system, [1.0, 0.5], [0.1, 0.4], 0.2), FOUR, 0.3)
        for name, (system, *_) in SYSTEMS.items()
    },
}


@pytest.mark.parametrize("name", FREE | FORCED)
def test_the_transforms_of_a_step_are_its_momenta_and_its_action_that_of_the_run(name):
    problem, method, h = (FREE | FORCED)[name]
    run = galvi.integrate(problem, method, h, 3)
    actions, size = galvi.action(run), np.max(np.abs(run.p))
    cancellation = np.max(np.abs(run.q)) / np.max(
        np.abs(np.diff(run.q, axis=0))
    )  # by which q1 - q0 loses digits
    for k in (0, 2):
        step = replace(problem, t0=float(run.t[k])), method, run.q[k], run.q[k + 1], h
        for p, momentum in zip(galvi.discrete_legendre_transforms(*step), run.p[k:], strict=False):
            assert p.shape == momentum.shape
            assert np.max(np.abs(p - momentum)) < 3e-15 * size * max(cancellation, 10.0)
        gap = galvi.discrete_lagrangian(*step) - (actions[k + 1] - actions[k])
        assert abs(gap) < 1e-14 * np.max(np.abs(actions))


DIFFERENCE_STEP, WEIGHTS = 2.0**-7, (4.0 / 5.0, -1.0 / 5.0, 4.0 / 105.0, -1.0 / 280.0)


def moved(problem, q, shift):
    """q exp(hat(shift))."""
    group = getattr(problem.system, "group", galvi.Rn(q.size))
    g = q.reshape(group.shape)
    return group.multiply(g, element(group, shift)).reshape(q.shape)


def differences(function, d, scale):
    """The derivative (d,) at 0 of a function of (d,), of order eight."""
    nudges = scale * np.eye(d)
    return np.array(
        [
            sum(w * (function(k * x) - function(-k * x)) for k, w in enumerate(WEIGHTS, 1)) / scale
            for x in nudges
        ]
    )


@pytest.mark.slow_cases("a floating arm", "a product")
@pytest.mark.parametrize("name", FREE)
def test_the_momenta_are_differences_of_the_discrete_lagrangian(name):
    problem, method, h = FREE[name]
    q0, q1 = galvi.integrate(problem, method, h, 1).q
    p0, p1 = galvi.discrete_legendre_transforms(problem, method, q0, q1, h)
    scale = DIFFERENCE_STEP * min(1.0, 10.0 * abs(h))

    def displaced_action(start, end):
        return galvi.discrete_lagrangian(
            problem, method, moved(problem, q0, start), moved(problem, q1, end), h
        )

    by_q0 = differences(lambda x: displaced_action(x, 0.0 * x), problem.v0.size, scale)
    by_q1 = differences(lambda x: displaced_action(0.0 * x, x), problem.v0.size, scale)
    size = np.max(np.abs([p0, p1]))
    for p, differenced in ((p0, -by_q0), (p1, by_q1)):
        assert np.allclose(p.ravel(), differenced, rtol=0.0, atol=3e-11 * size)


@pytest.mark.parametrize("sign", [1.0, -1.0], ids=["forwards", "backwards"])
@pytest.mark.parametrize("degree", [1, 2, 3])
def test_the_discrete_lagrangian_nears_the_action_in_closed_form_at_its_order(degree, sign):
    """An error of h^(2 s + 1) between ends that a motion joins; backwards in time the action has
    the opposite sign."""
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree))
    sizes, springs, orbits = 0.3 * 0.7 ** np.arange(4), [], []
    for h in sizes:
        x0, x1 = (1.0, np.cos(h) + 0.3 * np.sin(h))[:: int(sign)]
        exact = oscillator_action(1.0, 1.0, x0, x1, h)
        action = galvi.discrete_lagrangian(SPRING, method, [x0], [x1], sign * h)
        springs.append(abs(action - sign * exact))
        orbit = galvi.integrate(ROUND, EIGHT, h / 4, 4).q[::4]
        exact = kepler_action(1.0, *orbit.tolist(), h)
        action = galvi.discrete_lagrangian(ROUND, method, *orbit[:: int(sign)], sign * h)
        orbits.append(abs(action - sign * exact))
    for errors in (springs, orbits):
        order = np.polyfit(np.log(sizes), np.log(errors), 1)[0]
        assert abs(order - (2 * degree + 1)) < 0.15


def test_ends_far_apart_are_joined_too():
    """From the straight line alone, Newton's method does not converge to this arc."""
    method = galvi.Galerkin(galvi.Polynomials(16), galvi.gauss(16))
    action = galvi.discrete_lagrangian(KEPLER, method, [0.7, 0.0], [-0.5, 0.6], 1.5)
    assert abs(action - kepler_action(1.0, [0.7, 0.0], [-0.5, 0.6], 1.5)) < 1e-12
    assert galvi.discrete_lagrangian(SPRING, EIGHT, [0.0], [0.0], 1.0) == 0.0


def nonlinear(q, v, t):
    """L of a particle whose mass depends on its position and its velocity, with a driving force."""
    mass = 0.5 * (1.0 + q[0] ** 2) * v[0] ** 2 + 0.5 * v[1] ** 2 + 0.05 * v[1] ** 4
    return mass + 0.3 * q[0] * v[0] * v[1] - 0.5 * (q[0] * q[1]) ** 2 + 0.2 * np.sin(t) * q[0]


def damping(q, v):
    return -0.3 * v * abs(v[0])


def stationary_polynomial(degree, rule, q0, q1, h, t0):
    """L_d, p0 and p1 of `nonlinear` with `damping`, by the discrete Lagrange-d'Alembert principle
    for q0 + (q1 - q0) c + sum_k x_k c (1 - c) c^k; derivatives of L by complex steps."""
    c, chord = rule.nodes, np.subtract(q1, q0)
    shapes = np.array([c ** (k + 1) * (1.0 - c) for k in range(degree - 1)])
    shape_slopes = np.array([(k + 1) * c**k - (k + 2) * c ** (k + 1) for k in range(degree - 1)])

    def at_nodes(x):
        x = x.reshape(-1, 2)
        return q0 + np.outer(c, chord) + shapes.T @ x, (chord + shape_slopes.T @ x) / h, t0 + h * c

    def forces_and_momenta(x):
        tiny = 1e-200j * np.eye(2)
        rows = list(zip(*at_nodes(x), strict=True))
        forces = [[nonlinear(q + e, v, t).imag / 1e-200 for e in tiny] for q, v, t in rows]
        pushes = [damping(q, v) for q, v, _ in rows]
        momenta = [[nonlinear(q, v + e, t).imag / 1e-200 for e in tiny] for q, v, t in rows]
        weights = rule.weights[:, None]
        return h * weights * np.add(forces, pushes), weights * np.array(momenta)

    def residual(x):
        forces, momenta = forces_and_momenta(x)
        return (shapes @ forces + shape_slopes @ momenta).ravel()

    x = root(residual, np.zeros(2 * (degree - 1)), options={"xtol": 1e-15}).x
    forces, momenta = forces_and_momenta(x)
    values = [nonlinear(*row) for row in zip(*at_nodes(x), strict=True)]
    total = momenta.sum(axis=0)
    return h * rule.weights @ values, total - (1.0 - c) @ forces, total + c @ forces


@pytest.mark.parametrize("h", [0.5, -0.5])
@pytest.mark.parametrize("rule", [galvi.radau(3), galvi.gauss(7)], ids=["Radau", "more points"])
def test_the_step_between_two_places_is_the_stationary_polynomial(rule, h):
    system = galvi.Lagrangian(nonlinear, galvi.Rn(2), explicit_time=True, force=damping)
    problem = galvi.Problem(system, [1.0, 0.5], [0.1, 0.2], t0=1.3)
    step = problem, galvi.Galerkin(galvi.Polynomials(3), rule), [0.9, -0.2], [0.6, 0.4], h
    action, p0, p1 = stationary_polynomial(3, rule, *step[2:], 1.3)
    assert abs(galvi.discrete_lagrangian(*step) - action) < 1e-13
    assert np.allclose(galvi.discrete_legendre_transforms(*step), [p0, p1], rtol=0.0, atol=1e-13)


@pytest.mark.parametrize("unit", [1e-12, 3e12])
def test_the_unit_of_length_has_no_effect(unit):
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(unit**3)), [unit, 0], [0, unit])
    ends, method = np.array([[0.7, 0.0], [-0.5, 0.6]]), collocation(12)
    momenta = galvi.discrete_legendre_transforms(problem, method, *unit * ends, 1.5)
    expected = galvi.discrete_legendre_transforms(KEPLER, method, *ends, 1.5)
    assert np.allclose(np.divide(momenta, unit), expected, rtol=0.0, atol=1e-13)


def test_a_step_of_more_than_half_a_turn_has_an_action_of_its_own():
    """`action` takes the angle of the step, `discrete_lagrangian` the smallest between its ends."""
    h, rate = 1.0, 4.0
    turning = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, rate))
    run = galvi.integrate(turning, collocation(1, EXPONENTIAL), h, 1)
    shorter = galvi.discrete_lagrangian(turning, collocation(1, EXPONENTIAL), *run.q, h)
    for action, angle in ((galvi.action(run)[1], rate), (shorter, 2.0 * np.pi - rate)):
        assert abs(action - 3.4 * angle**2 / (2.0 * h)) < 1e-12


def test_coordinates_of_different_units_are_all_solved_for():
    """A spring of a million metres, and a pendulum whose length is a micrometre."""
    system = galvi.Canonical(1.0, lambda q: 0.5 * q[0] ** 2 - 1e-12 * np.cos(1e6 * q[1]))
    problem = galvi.Problem(system, [1e6, 2e-6], [0.0, 2e-6])
    run = galvi.integrate(problem, EIGHT, 1.0, 1)
    momenta = galvi.discrete_legendre_transforms(problem, EIGHT, *run.q, 1.0)
    assert np.allclose(np.subtract(momenta, run.p) / [1e6, 1e-6], 0.0, rtol=0.0, atol=1e-13)


def test_the_discrete_lagrangian_of_a_steady_turn_is_exact_in_the_exponential_chart():
    """The turn is a straight line in that chart, of action J angle^2 / (2 h)."""
    turning = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, 1.0))
    turn = element(galvi.SO3(), [0.0, 0.0, 2.0])
    for h in (0.5, -3.0):
        action = galvi.discrete_lagrangian(turning, collocation(1, EXPONENTIAL), np.eye(3), turn, h)
        assert abs(action - 3.4 * 2.0**2 / (2.0 * h)) < 1e-13 / abs(h)
        polynomial = galvi.discrete_lagrangian(turning, collocation(12), np.eye(3), turn, h)
        assert 0.0 < abs(polynomial / action - 1.0) < 1e-6  # 2e-8: not a polynomial in Cayley's


@pytest.mark.parametrize("name", ["kepler", "a driven oscillator", "a pendulum", "a top"])
def test_the_action_of_a_run_is_stationary_when_a_state_within_it_moves(name):
    problem, method, h = FREE[name]
    run = galvi.integrate(problem, method, h, 2)
    second = replace(problem, t0=float(run.t[1]))

    def total(shift):
        middle = moved(problem, run.q[1], shift)
        return galvi.discrete_lagrangian(
            problem, method, run.q[0], middle, h
        ) + galvi.discrete_lagrangian(second, method, middle, run.q[2], h)

    d, scale = problem.v0.size, DIFFERENCE_STEP * h
    assert abs(total(np.zeros(d)) - galvi.action(run)[-1]) < 1e-13
    assert np.max(np.abs(differences(total, d, scale))) < 1e-11 * np.max(np.abs(run.p))
    first_step_slopes = differences(
        lambda x: galvi.discrete_lagrangian(
            problem, method, run.q[0], moved(problem, run.q[1], x), h
        ),
        d,
        scale,
    )
    assert np.max(np.abs(first_step_slopes)) > 0.1  # the action of one step is not stationary


@pytest.mark.parametrize("name", ["kepler", "Lobatto's rule", "a driven oscillator"])
def test_the_reversed_step_has_the_opposite_action_with_a_symmetric_method(name):
    problem, method, h = FREE[name]
    q0, q1 = galvi.integrate(problem, method, h, 1).q
    forward = galvi.discrete_lagrangian(problem, method, q0, q1, h)
    backward = galvi.discrete_lagrangian(replace(problem, t0=problem.t0 + h), method, q1, q0, -h)
    assert abs(forward + backward) < 1e-14 * max(1.0, abs(forward))


def test_the_action_of_a_run_that_kept_less_is_the_same():
    full = galvi.integrate(KEPLER, FOUR, 0.1, 2500)
    action = galvi.action(full)
    thin = galvi.integrate(KEPLER, FOUR, 0.1, 2500, save_every=700)
    saved = [0, 700, 1400, 2100, 2500]
    assert action.shape == full.t.shape
    assert action[0] == 0.0
    assert np.allclose(galvi.action(thin), action[saved], rtol=1e-13)
    resumed_action = galvi.action(galvi.resume(full, 10))
    uncut_action = galvi.action(galvi.integrate(KEPLER, FOUR, 0.1, 2510))
    assert np.allclose(
        resumed_action, uncut_action[2500:] - uncut_action[2500], rtol=0.0, atol=1e-12
    )
    crossing = galvi.events.plane_crossing((0.0, 1.0))
    with_events = galvi.integrate(KEPLER, FOUR, 0.1, 2500, events=crossing)
    assert np.allclose(galvi.action(with_events), action, rtol=1e-13)


def walled(q):
    """A potential that is not defined from q = 1 on."""
    return -0.1 * np.sqrt(1.0 - q[0])


def test_the_action_does_not_depend_on_how_many_steps_are_evaluated_together(monkeypatch):
    run = galvi.integrate(DRIVEN, FOUR, 0.3, 5)
    action = galvi.action(run)
    monkeypatch.setattr("galvi.diagnostics.discrete_lagrangians.CHUNK", 2)
    assert np.allclose(galvi.action(run), action, rtol=1e-14)


@pytest.mark.filterwarnings("ignore:invalid value")
def test_the_action_past_a_failed_step_is_nan():
    problem = galvi.Problem(galvi.Canonical(1.0, walled), [0.0], [1.0])
    runs = [galvi.integrate(problem, FOUR, 0.2, 8, save_every=n) for n in (1, 2)]
    failed = runs[0].failed_step
    assert failed is not None
    assert 3 < failed < 8
    full, thin = map(galvi.action, runs)
    assert np.isfinite(full[:failed]).all()
    assert np.isnan(full[failed:]).all()
    assert np.allclose(thin, full[[0, 2, 4, 6, 8][: len(thin)]], rtol=1e-13, equal_nan=True)


def test_the_action_of_a_lagrangian_that_cannot_be_traced_is_that_of_one_that_can():
    def bead(q, v):
        return 0.5 * v[0] ** 2 * (1.0 + q[0] ** 2) - 0.5 * q[0] ** 2

    traced, untraced = (
        galvi.action(
            galvi.integrate(
                galvi.Problem(galvi.Lagrangian(L, galvi.Rn(1)), [1.0], [0.2]), FOUR, 0.3, 3
            )
        )
        for L in (bead, branching)
    )
    assert np.allclose(traced, untraced, rtol=1e-10)


def test_springs_among_the_forces_of_a_tree_belong_to_its_lagrangian():
    """A spring of a tendon is a force with a potential, that of a joint is a part of L."""
    pytest.importorskip("mujoco")
    body = '<inertial pos="0 .1 -.2" mass="1.5" diaginertia=".01 .02 .015"/>'
    text = '<mujoco><worldbody><body><joint name="a" axis="0 1 0" {}/>' + body
    text += "</body></worldbody>{}</mujoco>"
    spring = 'fixed stiffness="3" springlength="0"'
    tendon = f'<tendon><{spring}><joint joint="a" coef="1"/></fixed></tendon>'
    with_tendon, with_joint = (
        galvi.action(
            galvi.integrate(
                galvi.from_mujoco(text.format(*springs)).with_initial_state([0.4], [1.0]),
                FOUR,
                0.05,
                3,
            )
        )
        for springs in (("", tendon), ('stiffness="3"', ""))
    )
    assert np.allclose(with_tendon, with_joint, rtol=1e-12)

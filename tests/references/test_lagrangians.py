"""Lagrangians on R^d: galvi, DOP853, heyoka, closed forms and stored truths agree."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
import sympy
from hypothesis import given
from hypothesis import strategies as st
from numba import njit

import galvi
from references.closed_forms.kepler import KEPLER
from references.forces.on_symbols import formulas_of, has_values, symbolic_array
from references.heyoka.lagrangian import HEYOKA_LAGRANGIAN, HEYOKA_LAGRANGIAN_QUADRUPLE
from references.newton import acceleration, is_differenced
from references.scipy.ivp import DOP853, TIGHT
from references.scipy.lagrangian_ivp import LAGRANGIAN_DOP853, accelerations
from references.textbook.lagrange_equations import LagrangeEquations

needs_heyoka = pytest.mark.skipif(
    bool(HEYOKA_LAGRANGIAN.missing), reason=HEYOKA_LAGRANGIAN.missing or "present"
)
x, y, u, w, s, k = sympy.symbols("x y u w s k", real=True)
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def from_sympy(L, start, speeds, t0=0.0, **options):
    count = len(start)
    system = galvi.Lagrangian.from_sympy(L, [x, y][:count], [u, w][:count], **options)
    return galvi.Problem(system, start, speeds, t0=t0)


PROBLEMS = {
    "elastic pendulum": galvi.problems.elastic_pendulum(),
    "elastic pendulum, uneven": galvi.problems.elastic_pendulum(0.7, 31.0, 1.1, 5.0, 0.9, -0.4),
    "polar Kepler": galvi.problems.kepler_polar(),
    "coupled and driven": from_sympy(
        (u**2 + w**2) / 3 + u * w * sympy.cos(x - y) / 4 - sympy.cos(s) * x**2 / 3 - k * y**4,
        [0.3, 0.4],
        [0.1, 0.2],
        0.7,
        t=s,
        parameters={k: 0.1},
    ),
    "not quadratic in the velocity": from_sympy(
        -sympy.sqrt(1 - u**2) - sympy.exp(x / 3) / 2 + u * sympy.sin(x), [0.2], [0.4]
    ),
}
POTENTIALS = {
    "henon-heiles": galvi.problems.henon_heiles(),
    "chain of springs": galvi.problems.fermi_pasta_ulam_tsingou(4, beta=0.3),
    "orbit": galvi.problems.kepler(0.3),
    "pendulum": galvi.problems.planar_pendulum(),
    "two masses": galvi.Problem(
        galvi.Canonical([2.0, 0.3], galvi.LinearSpring(1.5)), [1.0, 2.0], [0.5, 0.0]
    ),
    "coupled masses": galvi.Problem(
        galvi.Canonical([[2.0, 0.3], [0.3, 1.0]], galvi.CosinePotential(1.5)), [1.0, 2.0], [0.5, 0]
    ),
}
STARS = np.array([0.1, -0.2])
STIFFNESS = np.array([[2.0, 0.3], [0.3, 1.0]])


def logarithmic(q):
    return 0.5 * np.log(0.01 + q[0] ** 2 + (q[1] / 0.9) ** 2)


def gradient_in_floats(q):
    """The gradient of q0^4 / 4 + q1^2, in an array of floats."""
    gradient = np.zeros(2)
    gradient[0], gradient[1] = q[0] ** 3, 2.0 * q[1]
    return gradient


@njit
def jitted(q):
    return np.array([np.tanh(q[0]), np.arctan(q[1])])


def canonical(potential, gradient=None, mass=1.0, t0=0.0, **options):
    system = galvi.Canonical(mass, potential, gradient, **options)
    return galvi.Problem(system, [0.8, 0.4], [0.1, 0.7], t0=t0)


USER_POTENTIALS = {
    "logarithmic": canonical(logarithmic),
    "logarithmic, two masses": canonical(logarithmic, mass=[1.0, 2.5]),
    "logarithmic, coupled masses": canonical(logarithmic, mass=STIFFNESS),
    "a norm": canonical(lambda q: -1.0 / np.linalg.norm(q - STARS)),
    "a matrix": canonical(lambda q: q @ STIFFNESS @ q + np.dot(q, q) / 3 + np.sum(q**4)),
    "an angle": canonical(lambda q: np.arctan2(q[1], q[0]) ** 2 + np.hypot(*q)),
    "constants that are no fractions": canonical(
        lambda q: (4.5 * q[0] ** 2 + 2.0 * q[1] ** 2) ** 1.3 + 2.0 ** q[1] - (3.0 * q[1] + 9) ** 0.5
    ),
    "of the time": canonical(
        lambda q, t: q[0] ** 2 * np.cos(3.0 * t) + np.cosh(q[1]), explicit_time=True, t0=0.7
    ),
    "a gradient in floats": canonical(lambda q: q[0] ** 4 / 4 + q[1] ** 2, gradient_in_floats),
    "a compiled gradient": canonical(lambda q: 0.0, jitted, check=False),
    "friction": canonical(lambda q: q @ q, force=lambda q, v: -0.1 * np.linalg.norm(v) * v),
    "a force of the time": canonical(
        galvi.LinearSpring(1.0), force=lambda q, v, t: np.sin(t) * q - v / 7, timed_force=True
    ),
}


DURATION = 2.0


def final_error(run, truth) -> float:
    assert run.success, run.status
    return float(max(np.abs(run.q[-1] - truth.q[-1]).max(), np.abs(run.p[-1] - truth.p[-1]).max()))


def dop853_run(problem):
    peer = LAGRANGIAN_DOP853 if isinstance(problem.system, galvi.Lagrangian) else DOP853
    return peer.run(problem, DURATION, {"samples": 1, **TIGHT})


@needs_heyoka
@pytest.mark.parametrize("name", USER_POTENTIALS)
def test_heyoka_and_dop853_agree_about_a_potential_of_ones_own(name):
    problem = USER_POTENTIALS[name]
    run = HEYOKA_LAGRANGIAN.run(problem, DURATION, {"samples": 1, "compact_mode": True})
    assert final_error(run, dop853_run(problem)) < 1e-12  # 5e-14
    if not HEYOKA_LAGRANGIAN_QUADRUPLE.missing:
        assert (
            final_error(run, HEYOKA_LAGRANGIAN_QUADRUPLE.run(problem, DURATION, {})) < 1e-13
        )  # 1e-14


@pytest.mark.parametrize("name", PROBLEMS)
def test_galvi_and_dop853_agree(name):
    problem = PROBLEMS[name]
    run = galvi.integrate(problem, EIGHT, DURATION / 80, 80, save_every=80)
    assert final_error(run, dop853_run(problem)) < 2e-13  # 3e-14


@needs_heyoka
@pytest.mark.parametrize("name", [*PROBLEMS, *POTENTIALS])
def test_heyoka_and_dop853_agree(name):
    problem = (PROBLEMS | POTENTIALS)[name]
    setting = {"samples": 1, "compact_mode": True}
    assert (
        final_error(HEYOKA_LAGRANGIAN.run(problem, DURATION, setting), dop853_run(problem)) < 5e-13
    )  # 5e-14
    assert HEYOKA_LAGRANGIAN_QUADRUPLE.exact and not HEYOKA_LAGRANGIAN.exact


def test_a_wrong_sign_in_lagrange_s_equations_is_caught():
    problem = PROBLEMS["elastic pendulum"]
    equations = LagrangeEquations.of(problem)
    flipped = {v: -v for v in equations.v[:1]}  # the Coriolis term of the angle changes its sign
    wrong = replace(equations, pull=tuple(f.xreplace(flipped) for f in equations.pull))
    q, v = np.array([1.1, 0.4]), np.array([0.3, 0.7])
    right = accelerations(equations)(q, v, 0.0)
    assert abs(accelerations(wrong)(q, v, 0.0) - right).max() > 0.5
    m, k, l, g = (problem.parameters[n] for n in ("mass", "stiffness", "length", "gravity"))
    by_hand = [
        q[0] * v[1] ** 2 - k / m * (q[0] - l) + g * np.cos(q[1]),
        (-2.0 * v[0] * v[1] - g * np.sin(q[1])) / q[0],
    ]
    np.testing.assert_allclose(right, by_hand, rtol=1e-14)


def test_polar_kepler_is_the_orbit_in_other_coordinates():
    e, duration = 0.3, 20.0
    run = LAGRANGIAN_DOP853.run(galvi.problems.kepler_polar(e), duration, {"samples": 4, **TIGHT})
    truth = KEPLER.run(galvi.problems.kepler(e), duration, {"samples": 4})
    r, angle = run.q.T
    plane = np.stack([r * np.cos(angle), r * np.sin(angle)], axis=1)
    assert np.abs(plane - truth.q).max() < 1e-12  # 1e-13
    assert angle[-1] > 6.0 * np.pi  # it counts the turns


@pytest.mark.parametrize("name", [*USER_POTENTIALS, *POTENTIALS])
def test_a_potential_is_written_out_and_its_slopes_are_not_differenced(name):
    problem = (USER_POTENTIALS | POTENTIALS)[name]
    equations = LagrangeEquations.of(problem)
    assert HEYOKA_LAGRANGIAN.supports(problem) and HEYOKA_LAGRANGIAN_QUADRUPLE.supports(problem)
    for offset in (0.0, 0.3):
        q, v, t = problem.q0 + offset, problem.v0 - offset, problem.t0 + offset
        solved = accelerations(equations)(q, v, t)
        np.testing.assert_allclose(solved, acceleration(problem)(q, v, t), rtol=1e-9, atol=1e-11)
        momenta = [float(p.subs(dict(zip(equations.v, v, strict=True)))) for p in equations.momenta]
        np.testing.assert_allclose(momenta, problem.system.momentum(v), rtol=1e-15)
    assert not is_differenced(problem)


@njit
def branching(q):
    return q if q[0] > 0.0 else 2.0 * q


def kinked(q):
    try:
        return 0.5 * q[0] ** 2 if q[0] > 0.0 else q[0] ** 2
    except TypeError:
        return 0.5 * q[0] ** 2


def kepler_s_equation(q):
    anomaly = q[0]
    for _ in range(50):
        anomaly = anomaly - (anomaly - np.sin(anomaly) / 2 - q[0]) / (1 - np.cos(anomaly) / 2)
    return anomaly**2


WITHOUT_FORMULA = {
    "a branch": lambda q: q[0] ** 2 if q[0] > 0.0 else 2.0 * q[0] ** 2,
    "np.where": lambda q: np.where(q[0] > 0.0, q[0] ** 2, 0.0),
    "the larger": lambda q: max(q[0], q[1]),
    "a table": lambda q: np.interp(q[0], [0.0, 1.0, 2.0], [0.0, 1.0, 4.0]),
    "a float": lambda q: float(q @ q),
    "a branch that is hidden": kinked,
    "an iteration": kepler_s_equation,
}


@pytest.mark.parametrize("name", WITHOUT_FORMULA)
def test_a_potential_without_a_formula_is_refused_with_the_reason(name):
    problem = canonical(WITHOUT_FORMULA[name], check=False)
    assert LagrangeEquations.of(problem) is None and not HEYOKA_LAGRANGIAN.supports(problem)
    assert is_differenced(problem)
    with pytest.raises(ValueError, match="The reason is its potential, of which no formula"):
        HEYOKA_LAGRANGIAN.run(problem, 1.0, {})


@given(st.integers(0, 2**32 - 1))
def test_a_formula_of_any_expression_has_the_values_of_its_function(seed):
    potential, draw = random_potential(seed), np.random.default_rng(seed)
    (formula,) = formulas_of(potential, symbolic_array([x, y]))
    points = [(draw.standard_normal(2),) for _ in range(9)]
    assert has_values([formula], [(x, y)], potential, points)
    assert not has_values([formula + sympy.sin(x) / 10**9], [(x, y)], potential, points)


def random_potential(seed):
    """A smooth function of q (2,) of moderate size, of five random pairs of operations."""
    unary = (
        np.sin,
        np.cos,
        np.tanh,
        np.arctan,
        lambda z: np.exp(np.sin(z)),
        lambda z: np.sqrt(1.0 + z * z),
        lambda z: np.log(2.0 + np.cos(z)),
        np.arcsinh,
    )
    binary = (
        lambda a, b: a + b,
        lambda a, b: a - 0.3 * b,
        lambda a, b: np.sin(a) * b,
        lambda a, b: a / (1.0 + b**2),
        lambda a, b: np.hypot(a, b),
    )

    def potential(q):
        draw, terms = np.random.default_rng(seed), [q[0], q[1], np.sum(q) / 3]
        for _ in range(5):
            a, b = (terms[draw.integers(len(terms))] for _ in "ab")
            combined = binary[draw.integers(len(binary))](a, b)
            terms.append(unary[draw.integers(len(unary))](combined))
        return terms[-1] + terms[-2]

    return potential


def test_what_has_no_formula_is_not_taken():
    gradient = galvi.Canonical(1.0, lambda q: 0.5 * float(q @ q), branching, check=False)
    assert LagrangeEquations.of(galvi.Problem(gradient, [1.0, 2.0], [0.0, 0.0])) is None
    kink = from_sympy(u**2 / 2 - sympy.Abs(x) ** 3, [0.2], [0.4])
    assert LAGRANGIAN_DOP853.supports(kink) and not HEYOKA_LAGRANGIAN.supports(kink)
    polar = PROBLEMS["polar Kepler"].system
    slopes = replace(polar, slopes=lambda q, v: np.concatenate((v, np.zeros(2))), check=False)
    assert LagrangeEquations.of(galvi.Problem(slopes, [1.0, 0.0], [0.0, 1.0])) is None


def test_numbers_of_a_formula_are_not_rounded():
    mean, power = formulas_of(
        lambda q: [0.1 * q[0] + q[0] / 3.0, np.sqrt(q[0]) ** 3], symbolic_array([x])
    )
    assert mean == x * (sympy.Rational(0.1) + sympy.Rational(1, 3))
    assert power == x ** sympy.Rational(3, 2)
    assert LagrangeEquations.of(PROBLEMS["coupled and driven"]).timed
    assert not LagrangeEquations.of(PROBLEMS["polar Kepler"]).timed

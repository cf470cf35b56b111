"""Lagrangians from SymPy move as hand-written ones and as equations derived by hand."""

import pickle

import mpmath
import numpy as np
import pytest
from scipy.integrate import solve_ivp

import galvi

pytest.importorskip("sympy")

import sympy
from sympy.physics.mechanics import dynamicsymbols

from tests.properties.symbolic_letters import FOUR, c, from_sympy, k, m, t, u, w, x, y

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def hoop():
    """A bead on a hoop of radius 1 that turns about the vertical; `hoop_right_side` is by hand."""
    theta, spin = dynamicsymbols("theta"), sympy.Symbol("Omega")
    rate = theta.diff(dynamicsymbols._t)
    L = m * (rate**2 + spin**2 * sympy.sin(theta) ** 2) / 2 + m * k * sympy.cos(theta)
    return from_sympy(L, [theta], parameters={m: 2.0, k: 9.81, spin: 4.0})


def hoop_right_side(t, s):
    return [s[1], np.sin(s[0]) * (16.0 * np.cos(s[0]) - 9.81)]


def growing_mass():
    """A mass that grows, (1 + t) v^2 / 2, on a spring that stiffens."""
    return from_sympy((1 + t) * u**2 / 2 - (1 + t) ** 2 * x**2 / 2, x, u, t)


def growing_mass_right_side(t, s):
    return [s[1], -((1.0 + t) ** 2 * s[0] + s[1]) / (1.0 + t)]


def magnet():
    """A charge in a plane, in a magnetic field of strength c and on an anharmonic spring."""
    spring = (x**2 + 2 * y**2) / 2 + x**4 / 4
    return from_sympy(
        (u**2 + w**2) / 2 + c * (x * w - y * u) / 2 - spring, [x, y], [u, w], parameters={c: 1.5}
    )


def magnet_right_side(t, s):
    return [s[2], s[3], 1.5 * s[3] - s[0] - s[0] ** 3, -1.5 * s[2] - 2.0 * s[1]]


MOTIONS = {
    "bead on a hoop": (hoop, hoop_right_side, [0.4], [1.0], 0.05),
    "growing mass": (growing_mass, growing_mass_right_side, [1.0], [0.5], 0.1),
    "magnetic field": (magnet, magnet_right_side, [1.0, -0.5], [0.3, 0.8], 0.1),
}


@pytest.fixture(scope="module", params=MOTIONS)
def motion(request):
    """The problem, its right-hand side derived by hand, and a step."""
    make, right_side, q0, v0, step = MOTIONS[request.param]
    return galvi.Problem(make(), q0, v0, t0=0.5), right_side, step


def end_by_hand(problem, right_side, duration):
    start = np.concatenate([problem.q0, problem.v0])
    span = (problem.t0, problem.t0 + duration)
    return solve_ivp(right_side, span, start, "DOP853", rtol=3e-14, atol=1e-15).y[:, -1]


def test_the_motion_is_that_of_equations_derived_by_hand(motion):
    problem, right_side, step = motion
    run = galvi.integrate(problem, EIGHT, step, 20)
    end = end_by_hand(problem, right_side, 20 * step)
    v = problem.system.velocity(run.p[-1:], run.q[-1:], run.t[-1:], run.velocity(run.t[-1]))[0]
    assert run.success, run.status
    np.testing.assert_allclose(run.q[-1], end[: problem.q0.size], rtol=0, atol=1e-13)  # 3e-15
    np.testing.assert_allclose(v, end[problem.q0.size :], rtol=0, atol=1e-12)  # 4e-14, of the bead
    if not problem.system.explicit_time:
        assert np.ptp(galvi.energy(run)) < 1e-13  # 4e-15


def test_a_damped_and_driven_oscillator_follows_its_closed_form_in_extended_precision():
    system = from_sympy(
        u**2 / 2 - k * x**2 / 2,
        x,
        u,
        t,
        parameters={k: 1.0, c: 0.25},
        force=[c * sympy.cos(t) - c * u],
    )
    run = galvi.integrate(galvi.Problem(system, [1.0], [0.0]), EIGHT, 0.25, 40)
    with mpmath.workdps(30):
        frequency = mpmath.sqrt(1 - mpmath.mpf(1) / 64)
        truth = [
            mpmath.sin(time)
            + mpmath.exp(-time / 8)
            * (
                mpmath.cos(frequency * time)
                - mpmath.mpf(7) / 8 / frequency * mpmath.sin(frequency * time)
            )
            for time in map(mpmath.mpf, run.t)
        ]
    assert np.max(np.abs(run.q[:, 0] - np.array(truth, dtype=float))) < 1e-14  # 2e-16


def test_a_sign_gone_wrong_would_be_seen():
    start = ([1.0, -0.5], [0.3, 0.8])
    wrong = from_sympy(
        (u**2 + w**2) / 2 - c * (x * w - y * u) / 2 - (x**2 + 2 * y**2) / 2 - x**4 / 4,
        [x, y],
        [u, w],
        parameters={c: 1.5},
    )
    run = galvi.integrate(galvi.Problem(wrong, *start), EIGHT, 0.1, 20)
    end = end_by_hand(run.problem, magnet_right_side, 2.0)
    assert np.ptp(galvi.energy(run)) < 1e-12 and np.max(np.abs(run.q[-1] - end[:2])) > 0.1  # 2.0


def test_a_problem_from_sympy_can_be_pickled_saved_and_resumed(tmp_path):
    problem = galvi.Problem(magnet(), [1.0, -0.5], [0.3, 0.8])
    run = galvi.integrate(problem, FOUR, 0.1, 10)
    copy = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(galvi.integrate(copy, FOUR, 0.1, 10).q, run.q)
    galvi.save(run, tmp_path / "run.npz")
    with pytest.raises(ValueError, match="needs its problem"):
        galvi.load(tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz", problem)
    assert np.array_equal(galvi.resume(loaded, 3).q, galvi.resume(run, 3).q)

"""The plane pendulum's closed form against Taylor series, and against methods of steps."""

from __future__ import annotations

import mpmath as mp
import numpy as np
import pytest

import galvi
from references.closed_forms.pendulum import PENDULUM
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.euler import STORMER_VERLET

# weight, mass, q0, v0
CASES = {
    "released": (1.0, 1.0, 2.0, 0.0),
    "swinging": (1.3, 0.7, 2.0, -1.0),
    "swinging after many turns": (1.0, 2.0, -100.0, 0.5),
    "going round": (1.0, 1.0, 3.0, 8.0),
    "going round backwards": (1.0, 1.0, 100.0, -3.0),
    "separatrix": (1.0, 1.0, 0.0, 2.0),
    "separatrix backwards": (1.0, 1.0, 0.0, -2.0),
    "just inside": (1.0, 1.0, 0.0, 2.0 - 4e-16),
    "just outside": (1.0, 1.0, 0.0, 2.0 + 4e-16),
    "almost upright": (1.0, 1.0, np.pi, 0.0),
    "almost at rest": (1.0, 1.0, 1e-9, -1e-20),
    "at rest": (1.0, 1.0, 0.0, 0.0),
}
PER_UNIT, TERMS = 8, 40


def start(weight: float, mass: float, q0: float, v0: float) -> galvi.Problem:
    return galvi.Problem(galvi.Canonical(mass, galvi.CosinePotential(weight)), [q0], [v0])


def by_taylor_series(weight, mass, q0, v0, duration):
    """q and v after a whole time, from q'' = -(weight / mass) sin q alone, with 50 digits."""
    with mp.workdps(50):
        q, v, strength = mp.mpf(q0), mp.mpf(v0), mp.mpf(weight) / mp.mpf(mass)
        for _ in range(abs(duration) * PER_UNIT):
            Q, V, S, C = [q], [v], [mp.sin(q)], [mp.cos(q)]
            for k in range(TERMS):
                turned = [mp.fdot(x[: k + 1], V[k::-1]) / (k + 1) for x in (C, S)]
                Q.append(V[k] / (k + 1))
                V.append(-strength * S[k] / (k + 1))
                S.append(turned[0])
                C.append(-turned[1])
            h = mp.mpf(1 if duration > 0 else -1) / PER_UNIT
            q, v = mp.polyval(Q[::-1], h), mp.polyval(V[::-1], h)
        return float(q), float(v)


@pytest.mark.parametrize("duration", [5, -3])
@pytest.mark.parametrize("name", CASES)
def test_every_kind_of_motion_is_the_taylor_series_rounded_once(name, duration):
    case = CASES[name]
    run = PENDULUM.run(start(*case), float(duration), {"samples": 4})
    q, v = by_taylor_series(*case, duration)
    # 0 was measured for all: both are rounded once, from more than 30 digits
    assert run.q[-1, 0] == pytest.approx(q, rel=3e-16, abs=0.0)
    assert run.p[-1, 0] == pytest.approx(case[1] * v, rel=6e-16, abs=0.0)


@pytest.mark.parametrize("name", CASES)
def test_it_moves_without_a_jump(name):
    weight, mass, _, _ = case = CASES[name]
    run = PENDULUM.run(start(*case), 60.0, {"samples": 600})
    v = run.p[:, 0] / mass
    moved, mean = np.diff(run.q[:, 0]), 0.05 * (v[1:] + v[:-1])
    # the trapezium rule's error is h^3 / 12 times the largest third derivative of q
    fastest = np.abs(v).max()
    assert np.all(np.abs(moved - mean) <= 0.1**3 / 12 * weight / mass * fastest * 1.01 + 1e-15)


def test_the_period_is_four_quarters():
    period = 4.0 * float(mp.ellipk(mp.sin(1) ** 2))
    run = PENDULUM.run(galvi.problems.planar_pendulum(2.0), 1e6 * period, {"samples": 4})
    np.testing.assert_allclose(run.q[:, 0], 2.0, atol=1e-15)  # 0
    half = PENDULUM.run(galvi.problems.planar_pendulum(2.0), period, {"samples": 2})
    np.testing.assert_allclose(half.q[:, 0], [2.0, -2.0, 2.0], rtol=1e-15)


def test_every_angle_is_its_own_pendulum():
    system = galvi.Canonical([0.3, 2.0], galvi.CosinePotential(1.7))
    both = PENDULUM.run(galvi.Problem(system, [1.0, -0.5], [0.2, 3.0]), 9.0, {"samples": 3})
    for k, (mass, q0, v0) in enumerate([(0.3, 1.0, 0.2), (2.0, -0.5, 3.0)]):
        alone = PENDULUM.run(start(1.7, mass, q0, v0), 9.0, {"samples": 3})
        assert np.array_equal(both.q[:, k], alone.q[:, 0])
        assert np.array_equal(both.p[:, k], alone.p[:, 0])


def test_scipy_and_small_steps_find_it():
    problem = galvi.problems.planar_pendulum(2.0)
    exact = PENDULUM.run(problem, 20.0, {}).q[-1]
    assert np.abs(DOP853.run(problem, 20.0, TIGHT).q[-1] - exact).max() < 3e-13  # 3e-14
    errors = [
        np.abs(STORMER_VERLET.run(problem, 20.0, {"step": h}).q[-1] - exact).max()
        for h in (0.02, 0.01, 0.005)
    ]
    slopes = np.log2(np.array(errors[:-1]) / errors[1:])
    assert np.all(np.abs(slopes - 2.0) < 0.05)


def test_another_force_or_a_coupling_mass_is_refused():
    weight = galvi.CosinePotential(1.0)
    for system in (
        galvi.Canonical(1.0, weight, gradient=lambda q: 2.0 * np.sin(q), check=False),
        galvi.Canonical(np.array([[2.0, 1.0], [1.0, 2.0]]), weight),
        galvi.Canonical(1.0, galvi.LinearSpring(1.0)),
    ):
        assert not PENDULUM.supports(galvi.Problem(system, [1.0, 0.5], [0.0, 0.0]))

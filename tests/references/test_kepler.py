"""The two-body closed form against 60-digit arithmetic and other formulas."""

from __future__ import annotations

import math

import mpmath as mp
import numpy as np
import pytest

import galvi
from references.closed_forms.kepler import KEPLER

EPS = 2.0**-52
BOUND = 4.0  # eps (|q| + |v| |t|); 0.39 was measured when it was set
TIMES = [1e-12, 1e-6, 1e-3, 0.5, math.pi, 2 * math.pi, 100.0, 12345.678, 1e7, -3.3]


def truth(mu, q0, v0, t):
    """q and v by the perifocal formulas and bisection on E - e sin E = M, at 60 digits."""
    mu, t = mp.mpf(mu), mp.mpf(t)
    q0, v0 = ([mp.mpf(x) for x in np.asarray(u).tolist()] for u in (q0, v0))
    dot = lambda a, b: sum(x * y for x, y in zip(a, b, strict=True))  # noqa: E731
    r0 = mp.sqrt(dot(q0, q0))
    a = 1 / (2 / r0 - dot(v0, v0) / mu)
    n = mp.sqrt(mu / a**3)
    sigma = dot(q0, v0) / mp.sqrt(mu * a)
    vector = [((dot(v0, v0) - mu / r0) * x - dot(q0, v0) * y) / mu for x, y in zip(q0, v0)]  # noqa: B905
    e = mp.sqrt(dot(vector, vector))
    E0 = mp.atan2(sigma, 1 - r0 / a) if e else mp.mpf(0)
    b = a * mp.sqrt(1 - e * e)
    P = [x / e for x in vector] if e else [x / r0 for x in q0]
    Q = [
        mp.sin(E0) * (x - a * (mp.cos(E0) - e) * p) / b
        + mp.cos(E0) * (y + n * a * a / r0 * mp.sin(E0) * p) * r0 / (n * a * b)
        for x, y, p in zip(q0, v0, P, strict=True)
    ]
    M = E0 - e * mp.sin(E0) + n * t
    low, high = M - 1.1, M + 1.1
    for _ in range(210):
        E = (low + high) / 2
        low, high = (low, E) if E - e * mp.sin(E) > M else (E, high)
    r = a * (1 - e * mp.cos(E))
    q = [a * (mp.cos(E) - e) * x + b * mp.sin(E) * y for x, y in zip(P, Q, strict=True)]
    v = [n * a / r * (b * mp.cos(E) * y - a * mp.sin(E) * x) for x, y in zip(P, Q, strict=True)]
    return q, v


def norm(x):
    return mp.sqrt(sum(y * y for y in x))


def excess(mu, q0, v0, t):
    """Error of q in units of eps (|q| + |v| |t|) and of v in units of eps (|v| + |q''| |t|)."""
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(mu)), q0, v0)
    run = KEPLER.run(problem, t, {})
    with mp.workdps(60):
        q, v = truth(mu, q0, v0, t)
        wrong = [
            norm([mp.mpf(x) - y for x, y in zip(got.tolist(), true, strict=True)])
            for got, true in ((run.q[-1], q), (run.p[-1], v))
        ]
        pull = mu / norm(q) ** 2
        return max(
            float(wrong[0] / (EPS * (norm(q) + norm(v) * abs(t)))),
            float(wrong[1] / (EPS * (norm(v) + pull * abs(t)))),
        )


@pytest.mark.parametrize("e", [0.0, 1e-9, 0.3, 0.9, 0.999, 0.999999, 1.0 - 1e-9, 1.0 - 1e-13])
def test_from_pericentre_the_error_is_a_rounding_for_any_eccentricity(e):
    problem = galvi.problems.kepler(e)
    assert max(excess(1.0, problem.q0, problem.v0, t) for t in TIMES) <= BOUND


@pytest.mark.parametrize("e", [0.3, 0.9, 0.999999])
def test_from_apocentre_through_pericentre_too(e):
    v = math.sqrt((1.0 - e) / (1.0 + e))
    near = [math.pi * (1.0 + 1e-9), math.pi * (1.0 - 1e-5)]
    worst = max(
        excess(1.0, [-1.0 - e, 0.0, 0.0], [0.0, -0.6 * v, -0.8 * v], t) for t in TIMES + near
    )
    assert worst <= BOUND


def test_from_anywhere_with_any_strength():
    random = np.random.default_rng(20000101)
    for _ in range(30):
        mu = 10.0 ** random.uniform(-3.0, 3.0)
        q0, v0 = random.normal(size=(2, 3))
        speed = random.uniform(0.05, 1.38) * math.sqrt(mu / np.linalg.norm(q0))
        v0 *= speed / np.linalg.norm(v0)
        assert excess(mu, q0, v0, 10.0 ** random.uniform(-3.0, 4.0)) <= BOUND


def test_many_times_at_once_are_the_same_as_one_by_one():
    problem = galvi.problems.kepler(0.999999)
    run = KEPLER.run(problem, 20.0, {"samples": 16})
    for t, q in zip(run.t[1:], run.q[1:], strict=True):
        assert np.array_equal(KEPLER.run(problem, t, {}).q[-1], q)


def test_two_bodies_move_about_a_centre_that_drifts():
    masses, q0, v0 = (
        [2.0, 0.5],
        [[1.0, 0.0, 3.0], [2.0, 0.5, 3.0]],
        [[0.1, 0.0, 0.2], [0.0, 1.3, 0]],
    )
    problem = galvi.Problem(galvi.NBody(masses, G=1.7), q0, v0)
    run = KEPLER.run(problem, 50.0, {})
    relative = np.subtract(q0[1], q0[0]), np.subtract(v0[1], v0[0])
    with mp.workdps(60):
        apart, _ = truth(mp.mpf(1.7) * 2.5, *relative, 50.0)
    centre = (np.dot(masses, q0) + 50.0 * np.dot(masses, v0)) / 2.5
    apart = np.array([float(x) for x in apart])
    np.testing.assert_allclose(run.q[-1], [centre - 0.2 * apart, centre + 0.8 * apart], rtol=1e-14)
    np.testing.assert_allclose(galvi.energy(run), galvi.energy(run)[0], rtol=1e-14)


@pytest.mark.parametrize(
    ("q0", "v0"),
    [([1.0, 0.0], [0.0, 1.5]), ([1.0, 0.0], [0.5, 0.0]), ([1.0, 2.0], [0.0, 0.0]), ([1.0], [0.1])],
    ids=["hyperbola", "radial", "at rest", "on a line"],
)
def test_what_is_no_ellipse_is_refused(q0, v0):
    problem = galvi.Problem(galvi.Canonical(1.0, galvi.CentralForce(1.0)), q0, v0)
    assert not KEPLER.supports(problem)

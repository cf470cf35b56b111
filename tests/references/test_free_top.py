"""Free and thrown bodies in closed form."""

from __future__ import annotations

from decimal import Decimal

import mpmath as mp
import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures import rigid_invariants
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.heyoka.rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

FULL = [[3.0, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]]
TILTED = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
# (12, 15, 20) with momentum along (1, b, 1) is on the separatrix, in floating point too
CASES = {
    "H's": ((3.3, 2.5, 3.4), (2.0, -1.9, 1.0)),
    "about the longest axis": ((1.0, 2.0, 2.5), (0.3, -0.2, 2.0)),
    "about the shortest axis": ((1.0, 2.0, 2.5), (-2.0, 0.3, 0.1)),
    "separatrix": ((12.0, 15.0, 20.0), (5.0, 0.7, 3.0)),
    "separatrix, the other way": ((12.0, 15.0, 20.0), (5.0, -0.7, -3.0)),
    "just inside": ((12.0, 15.0, 20.0), (5.0, 0.7, 3.0 + 1e-15)),
    "just outside": ((12.0, 15.0, 20.0), (5.0 + 1e-15, 0.7, -3.0)),
    "almost about the middle axis": ((12.0, 15.0, 20.0), (1e-9, 1.0, -1e-12)),
    "almost steady": ((1.0, 2.0, 2.5), (1e-10, 0.0, -3.0)),
    "two short": ((1.0, 1.0, 1.5), (1.0, 2.0, -3.0)),
    "two long": ((2.0, 1.0, 2.0), (1.0, 2.0, 3.0)),
    "almost two": ((1.0, 1.0 + 2.0**-52, 1.5), (1.0, 2.0, 3.0)),
    "full": (FULL, (1.0, 2.0, 3.0)),
    "full with two equal": ([[2, 0.5, 0.5], [0.5, 2, 0.5], [0.5, 0.5, 2]], (1.0, 2.0, 3.0)),
    "all equal": ((1.5, 1.5, 1.5), (1.0, 2.0, 3.0)),
    "steady about the middle axis": ((12.0, 15.0, 20.0), (0.0, -2.0, 0.0)),
    "at rest": ((12.0, 15.0, 20.0), (0.0, 0.0, 0.0)),
}
PER_UNIT, TERMS = 16, 30


def start(name: str) -> galvi.Problem:
    return galvi.problems.free_rigid_body(*CASES[name], attitude=TILTED)


def by_taylor_series(problem: galvi.Problem, duration: int):
    """R and p after a whole time, from R' = R hat(v) and p' = p x v alone, with 40 digits."""
    with mp.workdps(40):
        J = mp.matrix(problem.system.inertia.tolist())
        inverse, h = J**-1, mp.mpf(1) / PER_UNIT
        rows = [[mp.mpf(x) for x in row] for row in problem.q0.tolist()]
        rows.append(list(J * mp.matrix(problem.v0.tolist())))  # p' = p x v, as for a row of R
        for _ in range(duration * PER_UNIT):
            series = [[[x] for x in row] for row in rows]
            v: list[list[mp.mpf]] = [[], [], []]
            for k in range(TERMS):
                for i in range(3):
                    v[i].append(sum(inverse[i, j] * series[3][j][k] for j in range(3)))
                for row in series:
                    new = [
                        product(row[i - 2], v[i - 1], k) - product(row[i - 1], v[i - 2], k)
                        for i in range(3)
                    ]
                    for i in range(3):
                        row[i].append(new[i] / (k + 1))
            rows = [[mp.polyval(x[::-1], h) for x in row] for row in series]
        states = np.array([[float(x) for x in row] for row in rows])
    return states[:3], states[3]


def product(a, b, k):
    return mp.fdot(a[: k + 1], b[k::-1])


@pytest.mark.slow_cases(
    but=["two short", "two long", "all equal", "steady about the middle axis", "at rest"]
)
@pytest.mark.parametrize("name", CASES)
def test_every_kind_of_motion_is_the_taylor_series_rounded_once(name):
    problem = start(name)
    run = FREE_TOP.run(problem, 1.0, {"samples": 4})
    q, p = by_taylor_series(problem, 1)
    # 0 was measured for all: both are rounded once, from more than 30 digits
    np.testing.assert_allclose(run.q[-1], q, rtol=3e-16, atol=1e-20)
    np.testing.assert_allclose(run.p[-1], p, rtol=3e-16, atol=1e-20)
    assert np.array_equal(run.q[0], problem.q0) and np.array_equal(run.p[0], problem.p0)


@pytest.mark.parametrize("name", ["H's", "about the shortest axis", "full", "two short"])
def test_it_is_where_scipy_goes(name):
    problem = start(name)
    run, other = (c.run(problem, -30.0, {"samples": 5, **s}) for c, s in
                  ((FREE_TOP, {}), (RIGID_DOP853, TIGHT)))  # fmt: skip
    np.testing.assert_allclose(run.q, other.q, atol=2e-12)  # 3e-13
    np.testing.assert_allclose(run.p, other.p, atol=2e-12)  # 2e-13


@pytest.mark.parametrize("t", [1e3, 1e6, -1e9])
def test_long_times_by_mpmaths_integral_of_the_third_kind(t):
    """About the longest axis, from m_b = 0, where sn starts from 0."""
    J, v = (1.0, 2.0, 2.5), (0.3, 0.0, 2.0)
    problem = galvi.problems.free_rigid_body(J, v)
    run = FREE_TOP.run(problem, t, {})
    with mp.workdps(60):
        Ia, Ib, Ic = map(mp.mpf, J)
        a, c = Ia * mp.mpf(v[0]), Ic * mp.mpf(v[2])
        size = mp.hypot(a, c)
        b = a * mp.sqrt(Ib * (Ic - Ia) / (Ia * (Ic - Ib)))
        rate = c * mp.sqrt((Ic - Ib) * (Ic - Ia) / (Ia * Ib)) / Ic
        m = (Ib - Ia) * a**2 * Ic / ((Ic - Ib) * Ia * c**2)
        u = rate * mp.mpf(t)
        sn, cn, dn = (mp.ellipfun(name, u, m=m) for name in ("sn", "cn", "dn"))
        ratio = (b / a) ** 2
        turns = mp.nint(u / (2 * mp.ellipk(m)))
        phi = mp.atan2(sn * (-1) ** int(turns), cn * (-1) ** int(turns)) + turns * mp.pi
        third = (u - mp.ellippi(1 - ratio, phi, m)) / (ratio - 1)  # of sn^2 / (1 - n sn^2)
        psi = size * (mp.mpf(t) / Ia + (1 / Ib - 1 / Ia) * ratio * third / rate)
        momentum = [a * cn, b * sn, c * dn]
        back = frame([a, 0, c], size) * about_third(psi) * frame(momentum, size).T
        q = np.array(back.tolist(), dtype=np.float64)
        p = np.array([float(x) for x in momentum])
    np.testing.assert_allclose(run.q[-1], q, rtol=3e-16, atol=1e-18)  # 0
    np.testing.assert_allclose(run.p[-1], p, rtol=3e-16, atol=1e-18)  # 0


def frame(m, size):
    a, b, c = (x / size for x in m)
    h = mp.hypot(a, b)
    return mp.matrix([[a * c / h, -b / h, a], [b * c / h, a / h, b], [-h, 0, c]])


def about_third(psi):
    c, s = mp.cos(psi), mp.sin(psi)
    return mp.matrix([[c, -s, 0], [s, c, 0], [0, 0, 1]])


@pytest.mark.parametrize("name", CASES)
def test_momentum_energy_and_the_rotation_are_kept_for_a_million(name):
    problem = start(name)
    run = FREE_TOP.run(problem, 1e6, {"samples": 4})
    spatial = rigid_invariants.spatial_momentum(run.q, run.p)
    size = np.linalg.norm(problem.p0)
    np.testing.assert_allclose(spatial, spatial[[0] * 5], atol=1e-15 * size)  # 3e-16
    energy = rigid_invariants.energy(problem, run.q, run.p)
    np.testing.assert_allclose(energy, energy[0], rtol=2e-15)  # 5e-16
    assert rigid_invariants.orthogonality_defect(run.q).max() < 1e-15  # 2e-16


SKEW = [[3.0, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]]
MOTION = np.eye(4)
MOTION[:3, :3], MOTION[:3, 3] = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix(), (1.0, -2.0, 0.5)
PROBLEMS = {
    "without gravity": galvi.problems.free_body_se3(),
    "falling": galvi.problems.free_body_se3(g=(0.5, -1.0, -9.81)),
    "from elsewhere": galvi.Problem(
        galvi.FreeBody(1.7, SKEW, (1.0, 2.0, -7.0)), MOTION, [1.0, 2.0, 3.0, 0.3, 0.2, -0.1]
    ),
}
every = pytest.mark.parametrize("name", PROBLEMS)
DURATION = 3.0


@every
def test_it_turns_as_a_free_body_and_falls_on_a_parabola(name):
    problem = PROBLEMS[name]
    run = THROWN_BODY.run(problem, DURATION, {"samples": 6})
    system, R, v = problem.system, problem.q0[:3, :3], problem.v0
    turning = galvi.Problem(galvi.RigidBody(system.inertia), R, v[:3])
    turned = FREE_TOP.run(turning, DURATION, {"samples": 6})
    assert np.array_equal(run.q[:, :3, :3], turned.q) and np.array_equal(run.p[:, :3], turned.p)
    for t, q, p in zip(run.t.tolist(), run.q, run.p, strict=True):
        t = Decimal(t)
        for i in range(3):
            speed = sum(Decimal(R[i, j]) * Decimal(v[3 + j]) for j in range(3))
            g = Decimal(system.g[i])
            place = Decimal(problem.q0[i, 3]) + t * speed + t * t * g / 2
            assert abs(Decimal(q[i, 3]) - place) <= Decimal(2.0**-53) * abs(place)
            drift = system.mass * (q[i, :3] @ p[3:]) / system.mass**2
            assert drift == pytest.approx(float(speed + t * g), abs=1e-13)


@pytest.mark.slow_cases("falling")
@every
def test_galvi_comes_to_it(name):
    problem = PROBLEMS[name]
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    truth = THROWN_BODY.run(problem, DURATION, {"samples": 1})
    run = galvi.integrate(problem, method, DURATION / 40, 40, save_every=40)
    assert np.abs(run.q[-1] - truth.q[-1]).max() < 1e-12  # 3e-13, places of size 40


@pytest.mark.skipif(bool(HEYOKA_RIGID.missing), reason=HEYOKA_RIGID.missing or "present")
@every
def test_heyoka_comes_to_it_in_double_and_quadruple_precision(name):
    problem = PROBLEMS[name]
    truth = THROWN_BODY.run(problem, DURATION, {"samples": 3})
    size = np.abs(truth.q).max()
    for peer, bound in ((HEYOKA_RIGID, 1e-14), (HEYOKA_RIGID_QUADRUPLE, 2.0**-53)):
        run = peer.run(problem, DURATION, {"samples": 3, "compact_mode": True})
        assert np.abs(run.q - truth.q).max() <= bound * size
        assert np.abs(run.p - truth.p).max() <= 1e-13 * np.abs(truth.p).max()

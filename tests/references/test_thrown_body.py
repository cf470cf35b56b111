"""The thrown body's closed form, MuJoCo and heyoka on SE(3)."""

from __future__ import annotations

from decimal import Decimal

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi
from references.closed_forms.top_motion import FREE_TOP, THROWN_BODY
from references.heyoka.rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.mujoco.steps import MUJOCO_RK4

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


@every
def test_its_energy_stays(name):
    energy = galvi.energy(THROWN_BODY.run(PROBLEMS[name], DURATION, {"samples": 6}))
    assert np.ptp(energy) < 1e-14 * max(np.abs(energy).max(), 100.0)


@every
def test_galvi_comes_to_it(name):
    problem = PROBLEMS[name]
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    truth = THROWN_BODY.run(problem, DURATION, {"samples": 1})
    run = galvi.integrate(problem, method, DURATION / 40, 40, save_every=40)
    assert np.abs(run.q[-1] - truth.q[-1]).max() < 1e-12  # 3e-13, places of size 40


@pytest.mark.skipif(bool(MUJOCO_RK4.missing), reason=MUJOCO_RK4.missing or "present")
@every
def test_mujoco_comes_to_it_with_order_4(name):
    truth = THROWN_BODY.run(PROBLEMS[name], DURATION, {"samples": 1})
    steps = DURATION / np.array([200, 400, 800])
    runs = [MUJOCO_RK4.run(PROBLEMS[name], DURATION, {"step": h, "save_every": 800}) for h in steps]
    errors = [np.abs(run.q[-1] - truth.q[-1]).max() for run in runs]
    assert np.polyfit(np.log(steps), np.log(errors), 1)[0] == pytest.approx(4.0, abs=0.1)


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


def test_a_body_that_is_pushed_or_on_a_pivot_is_not_taken():
    assert not THROWN_BODY.supports(galvi.problems.free_rigid_body())
    assert not THROWN_BODY.supports(galvi.problems.heavy_top())
    assert not THROWN_BODY.supports(galvi.problems.kepler())

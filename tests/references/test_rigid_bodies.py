"""References for rigid bodies against each other: orders, failures, and planted faults."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures import rigid_invariants
from references import rigid_equations
from references.closed_forms.top_motion import FREE_TOP
from references.heyoka.rigid import HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE
from references.rigid_equations import RigidEquations, torque
from references.scipy import ivp
from references.scipy.rigid_ivp import RIGID_DOP853, RIGID_ODE45
from references.textbook.euler import MATRIX_EULER
from references.textbook.quaternions import QUATERNION_DOP853, QUATERNION_RK4
from references.textbook.quaternions import TIGHT as TIGHT_COMPILED

FULL_INERTIA = [[3.0, 0.4, 0.2], [0.4, 2.5, -0.3], [0.2, -0.3, 3.4]]
TILTED = Rotation.from_rotvec([0.3, -1.0, 2.0]).as_matrix()
LEVER = galvi.UniformGravity(1.3, (0.1, -0.4, 0.6), (1.0, 2.0, -5.0))
FREE = {
    "free rigid body": galvi.problems.free_rigid_body(),
    "free box": galvi.problems.free_box(),
    "free, full inertia, tilted": galvi.problems.free_rigid_body(
        FULL_INERTIA, (1.0, -2.0, 0.5), TILTED
    ),
}
HEAVY = {
    "heavy top": galvi.problems.heavy_top(),
    "3D pendulum": galvi.problems.pendulum_3d(),
    "spherical pendulum": galvi.problems.spherical_pendulum(),
    "heavy, full inertia, tilted": galvi.Problem(
        galvi.RigidBody(FULL_INERTIA, LEVER), TILTED, (1.0, -2.0, 0.5)
    ),
}
PROBLEMS = {**FREE, **HEAVY}
SOUND = (RIGID_DOP853, QUATERNION_RK4, QUATERNION_DOP853)
# name: setting of a run of duration 4, bound on its `difference`; measured values in comments
SETTINGS = {
    RIGID_DOP853.name: (dict(ivp.TIGHT), 5e-13),  # 4e-14
    RIGID_ODE45.name: (dict(ivp.TIGHT), 1e-12),  # 1e-13
    QUATERNION_RK4.name: ({"step": 0.001}, 1e-9),  # 8e-11
    QUATERNION_DOP853.name: (dict(TIGHT_COMPILED), 2e-13),  # 1e-14
    MATRIX_EULER.name: ({"step": 0.001}, 0.3),  # 0.12
    HEYOKA_RIGID.name: ({}, 2e-14),  # 2e-15
    HEYOKA_RIGID_QUADRUPLE.name: ({}, 4e-16),  # 0 for free bodies
}
CONTENDERS = (*SOUND, RIGID_ODE45, MATRIX_EULER, HEYOKA_RIGID, HEYOKA_RIGID_QUADRUPLE)
PRESENT = [contender for contender in CONTENDERS if not contender.missing]


def truth(problem: galvi.Problem, duration: float) -> galvi.Trajectory:
    if FREE_TOP.supports(problem):
        return FREE_TOP.run(problem, duration, {})
    if HEYOKA_RIGID_QUADRUPLE.missing:
        return RIGID_DOP853.run(problem, duration, ivp.TIGHT)
    return HEYOKA_RIGID_QUADRUPLE.run(problem, duration, {})


def difference(run: galvi.Trajectory, exact: galvi.Trajectory) -> float:
    """The larger of the error of R and the relative error of p at the end."""
    size = np.abs(exact.p[-1]).max()
    return max(np.abs(run.q[-1] - exact.q[-1]).max(), np.abs(run.p[-1] - exact.p[-1]).max() / size)


@pytest.mark.slow_cases(
    "SciPy RK45 (ode45), matrices-free box",
    "SciPy RK45 (ode45), matrices-heavy top",
    "SciPy RK45 (ode45), matrices-heavy, full inertia, tilted",
)
@pytest.mark.parametrize("name", PROBLEMS)
@pytest.mark.parametrize("contender", PRESENT, ids=lambda c: c.name)
def test_every_contender_finds_the_motion(contender, name):
    setting, tolerance = SETTINGS[contender.name]
    run = contender.run(PROBLEMS[name], 4.0, setting)
    assert run.success and difference(run, truth(PROBLEMS[name], 4.0)) <= tolerance
    assert run.counts.get("force_evaluations", run.counts.get("steps")) > 3


@pytest.mark.parametrize("name", ["free, full inertia, tilted", "heavy, full inertia, tilted"])
@pytest.mark.parametrize(
    ("method", "steps"),
    [(MATRIX_EULER, (1000, 2000, 4000)), (QUATERNION_RK4, (100, 200, 400, 800))],
    ids=lambda value: getattr(value, "name", ""),
)
def test_the_order_is_what_is_claimed_and_no_more(method, steps, name):
    problem = PROBLEMS[name]
    exact = truth(problem, 2.0)
    errors = [difference(method.run(problem, 2.0, {"step": 2.0 / n}), exact) for n in steps]
    order = -np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(order - method.order) < 0.05  # 1.002, 1.004, 3.999, 4.012


@pytest.mark.parametrize("name", ["free rigid body", "heavy top"])
def test_the_compiled_dop853_spends_about_what_scipys_does(name):
    problem = PROBLEMS[name]
    for tolerance in (1e-6, 1e-12):
        compiled, scipys = (
            c.run(problem, 20.0, {"tolerance": tolerance}).counts["force_evaluations"]
            for c in (QUATERNION_DOP853, RIGID_DOP853)
        )
        assert 0.9 < compiled / scipys < 1.1  # 1.00 to 1.05


@pytest.mark.parametrize("contender", SOUND, ids=lambda c: c.name)
def test_the_rotation_stays_one_whatever_the_step(contender):
    loose = {"step": 0.25} if contender is QUATERNION_RK4 else {"tolerance": 1e-3, "samples": 20}
    run = contender.run(HEAVY["3D pendulum"], 20.0, loose)
    assert rigid_invariants.orthogonality_defect(run.q).max() < 2e-15  # 7e-16


@pytest.mark.parametrize(
    ("contender", "setting"), [(MATRIX_EULER, {"step": 0.01}), (RIGID_ODE45, {})]
)
def test_methods_on_matrices_leave_the_rotations_and_the_momentum_sphere(contender, setting):
    problem = FREE["free rigid body"]
    run = contender.run(problem, 100.0, setting)
    size = np.linalg.norm(run.p, axis=1) / np.linalg.norm(problem.p0)
    assert rigid_invariants.orthogonality_defect(run.q)[-1] > 2e-3  # Euler 9e3, RK45 5e-3
    assert abs(size[-1] - 1.0) > 5e-7  # 0.09, 1e-6
    spatial = rigid_invariants.spatial_momentum(run.q, run.p) / np.linalg.norm(problem.p0)
    assert np.linalg.norm(spatial[-1] - spatial[0]) > 5e-4  # 0.6, 1e-3


def test_samples_in_between_and_backwards_are_on_the_same_motion():
    for problem in (FREE["free, full inertia, tilted"], HEAVY["heavy, full inertia, tilted"]):
        exact = RIGID_DOP853.run(problem, -4.0, ivp.TIGHT)
        compiled = QUATERNION_DOP853.run(problem, -4.0, {"samples": 9, **TIGHT_COMPILED})
        assert difference(compiled, exact) < 1e-12  # 1e-13
        fine = QUATERNION_RK4.run(problem, -4.0, {"step": -0.001, "save_every": 7})
        assert difference(fine, exact) < 1e-11  # 8e-13
        full = QUATERNION_RK4.run(problem, -4.0, {"step": -0.001})
        assert np.array_equal(fine.q[:-1], full.q[:-1:7])
        assert np.array_equal(fine.t[:-1], full.t[:-1:7])


def test_a_long_run_is_the_same_whether_or_not_it_is_cut_into_calls(monkeypatch):
    problem = HEAVY["heavy top"]
    runs = [(QUATERNION_RK4, {"step": 0.01}), (QUATERNION_DOP853, {"tolerance": 1e-9})]
    uncut = [contender.run(problem, 10.0, setting) for contender, setting in runs]
    monkeypatch.setattr("references.textbook.quaternions.CHUNK", 7)
    for (contender, setting), before in zip(runs, uncut, strict=True):
        after = contender.run(problem, 10.0, setting)
        assert np.abs(after.q - before.q).max() < 1e-9 and after.success
        assert after.counts["steps"] == pytest.approx(before.counts["steps"], abs=2)


def bent(R, t):
    return 0.3 * np.sin(t) * R[0, 1] + 0.2 * R[2, 2] ** 2


def test_the_torque_is_minus_the_slope_of_the_potential_along_every_turn():
    heavy, general = (
        galvi.RigidBody(FULL_INERTIA, LEVER),
        galvi.RigidBody(FULL_INERTIA, bent, explicit_time=True),
    )
    for system, potential in ((heavy, LEVER), (general, lambda R: bent(R, 0.7))):
        for axis in np.eye(3):
            plus, minus = (Rotation.from_rotvec(s * 1e-5 * axis).as_matrix() for s in (1, -1))
            slope = (potential(TILTED @ plus) - potential(TILTED @ minus)) / 2e-5
            assert torque(system, TILTED, 0.7) @ axis == pytest.approx(-slope, abs=1e-8)


def test_steps_that_are_too_large_end_the_run_with_a_sentence():
    fast = galvi.problems.free_rigid_body(velocity=(2e3, -1.9e3, 1e3))
    for contender in (MATRIX_EULER, QUATERNION_RK4):
        run = contender.run(fast, 100.0, {"step": 1.0, "save_every": 3})
        first = run.failed_step
        assert not run.success and f"tep {first}, towards t =" in run.status
        assert run.counts["steps"] == first - 1
        completed = np.append(np.arange(0, 100, 3), 100) < first
        assert np.all(np.isfinite(run.q[completed])) and np.all(np.isnan(run.q[~completed]))
        assert np.all(np.isfinite(run.p[completed])) and np.all(np.isnan(run.p[~completed]))


def test_an_adaptive_run_that_cannot_go_on_says_so():
    wild = galvi.problems.free_rigid_body(velocity=(2e200, -1.9e200, 1e200))
    run = QUATERNION_DOP853.run(wild, 10.0, {"samples": 4})
    assert not run.success and "the tolerance cannot be reached" in run.status
    assert np.all(np.isnan(run.q[1:])) and np.all(np.isfinite(run.q[0]))
    with pytest.raises(ValueError, match="tolerance must be at least 1e-16"):
        QUATERNION_DOP853.run(wild, 10.0, {"tolerance": 1e-17})


def test_a_body_at_rest_with_nothing_to_turn_it_stays():
    still = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, 0.0), attitude=TILTED)
    for contender in PRESENT:
        setting = {"step": 0.5} if contender in (QUATERNION_RK4, MATRIX_EULER) else {"samples": 2}
        run = contender.run(still, 1.0, setting)
        assert run.success and np.abs(run.q - TILTED).max() < 4e-16 and np.all(run.p == 0.0)


def reversed_precession(self, slope=RigidEquations.slope):
    correct = slope(self)
    return lambda t, y: correct(t, y) * np.append(np.ones(y.size - 3), -np.ones(3))


FAULTS = {  # the first keeps energy, rotations and the size of p
    "gyroscopic term": ("free rigid body", RigidEquations, "slope", reversed_precession),
    "torque": (
        "3D pendulum",
        rigid_equations,
        "torque",
        lambda system, R, t: -torque(system, R, t),
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_term_of_the_wrong_sign_is_caught(fault, monkeypatch):
    name, *patch = FAULTS[fault]
    exact = truth(PROBLEMS[name], 4.0)
    monkeypatch.setattr(*patch)
    setting, tolerance = SETTINGS[RIGID_DOP853.name]
    run = RIGID_DOP853.run(PROBLEMS[name], 4.0, setting)
    assert difference(run, exact) > 1e9 * tolerance
    if name in FREE:
        energy = rigid_invariants.energy(PROBLEMS[name], run.q, run.p)
        assert abs(energy[-1] / energy[0] - 1.0) < 1e-13
        assert rigid_invariants.orthogonality_defect(run.q).max() < 1e-15

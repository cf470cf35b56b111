"""Forces by the references' own formulas, and references that take external forces."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import pytest
from numba import njit

import galvi
from galvi.systems.canonical_on_rn import CanonicalOnRn
from references import REFERENCES, Contender, reference
from references.closed_forms.top_motion import FREE_TOP
from references.forces.force import derivative, gradient
from references.newton import (
    FORMULAS,
    acceleration,
    acceleration_jacobian,
    external_force,
    is_forced,
    potential_force,
)
from references.scipy.ivp import DOP853, TIGHT
from references.textbook.euler import SEMI_IMPLICIT_EULER

Q, V, T = np.array([0.7, -0.4, 1.1]), np.array([0.3, 0.2, -0.5]), 0.8
POTENTIALS = (
    galvi.LinearSpring(1.7),
    galvi.CosinePotential(2.3),
    galvi.CentralForce(1.3),
    galvi.UniformField((0.2, -0.1, 0.5)),
    galvi.SpringChain(0.4, 0.9),
)
every_potential = pytest.mark.parametrize("potential", POTENTIALS, ids=lambda p: type(p).__name__)
BODIES = galvi.Problem(
    galvi.NBody([1.0, 2e-3, 0.4], G=1.3),
    [[0.0, 0.1], [1.0, -0.2], [-0.3, 2.0]],
    [[0.0, 0.0], [0.1, 1.0], [0.8, 0.0]],
)


def point_in(potential, **fields):
    return galvi.Problem(galvi.Canonical(1.5, potential, **fields), Q, V)


def test_every_formula_is_tried_here():
    assert {type(potential) for potential in POTENTIALS} == set(FORMULAS)


@every_potential
def test_a_formula_is_minus_the_slope_of_its_potential(potential):
    force = potential_force(point_in(potential))
    assert force.compiled and force.formula is not None
    np.testing.assert_allclose(force(Q, V, T), -gradient(potential, Q), rtol=1e-11, atol=1e-12)


@pytest.mark.slow_cases("SpringChain")
@every_potential
def test_its_jacobian_is_exact(potential):
    problem = point_in(potential)
    exact = problem.system.acceleration_jacobian(Q, T)
    jacobian = acceleration_jacobian(problem)(Q, T)
    np.testing.assert_allclose(jacobian, exact, rtol=1e-14, atol=1e-15)
    by_differences = point_in(lambda q: potential(q))
    np.testing.assert_allclose(
        acceleration_jacobian(by_differences)(Q, T), exact, rtol=1e-6, atol=1e-7
    )


def test_gravity_is_newtons_law_and_its_jacobian_too():
    system, at_rest = BODIES.system, np.zeros(BODIES.q0.shape)
    energy = lambda x: float(system.potential_energy(x.reshape(3, 2), 0.0))  # noqa: E731
    exact = -gradient(energy, BODIES.q0.ravel()).reshape(3, 2) / system.masses[:, None]
    np.testing.assert_allclose(acceleration(BODIES)(BODIES.q0, at_rest, 0.0), exact, rtol=1e-9)
    np.testing.assert_allclose(
        acceleration_jacobian(BODIES)(BODIES.q0, 0.0),
        system.acceleration_jacobian(BODIES.q0, 0.0),
        rtol=1e-13,
        atol=1e-15,
    )


@pytest.mark.parametrize("coefficient", [0.44, None])
def test_the_wind_is_the_one_that_is_stated(coefficient):
    problem = galvi.problems.brownout(drag_coefficient=coefficient)
    for q in ([8.5, 0.0, 3.0], [0.1, 0.2, 9.0], [-6.0, 4.0, 5.5]):
        force = external_force(problem)(np.array(q), V, T)
        galvi_force = problem.system.force(np.array(q), V, T)
        np.testing.assert_allclose(force, galvi_force, rtol=1e-12)


def test_a_derivative_by_differences_has_eleven_digits():
    for f, exact in ((np.sin, 1.0), (np.exp, 1.0), (lambda s: 1.0 / (1.0 + 3.0 * s), -3.0)):
        assert abs(derivative(f, 1.0) / exact - 1.0) < 1e-11  # 2e-13
    assert derivative(lambda s: 0.0, 1.0) == 0.0


@pytest.mark.slow(
    beside="tests/suite/architecture/test_layers.py::test_every_import_contract_holds"
)
def test_no_reference_asks_galvi_for_a_force(monkeypatch):
    def refused(*arguments, **named):
        raise AssertionError("a reference asked galvi for a force")

    problems = [BODIES, galvi.problems.brownout(), galvi.problems.henon_heiles()]
    problems += [galvi.problems.spherical_pendulum(), galvi.problems.double_pendulum()]
    problems += [point_in(potential) for potential in POTENTIALS] + [
        point_in(lambda q: float(q @ q))
    ]
    body = galvi.RigidBody([1.0, 2.0, 2.5], lambda R: float(R[2, 2]), force=lambda R, w: -0.1 * w)
    problems += [
        galvi.Problem(replace(body, force=None), np.eye(3), V),
        galvi.Problem(body, np.eye(3), V),
    ]
    for system in (galvi.Canonical, galvi.NBody, galvi.RigidBody, CanonicalOnRn, *FORMULAS):
        for name in (
            "force_kernel",
            "lagrangian_kernel",
            "law",
            "acceleration",
            "acceleration_jacobian",
            "potential_gradient",
            "potential_hessian",
            "gradient",
            "hessian",
            "slope",
            "torque",
        ):
            if callable(getattr(system, name, None)):
                monkeypatch.setattr(system, name, refused)
    monkeypatch.setattr(galvi.RotorDrag, "__call__", refused)
    monkeypatch.setattr(galvi.RotorDrag, "compiled", refused)
    names_run = set()
    for contender in REFERENCES:
        for problem in problems:
            if not contender.missing and contender.supports(problem):
                settings = ({"step": 0.25}, {"samples": 1})
                key = "step" if "save_every" in _keys(contender, problem) else "samples"
                contender.run(problem, 0.5, settings[key == "samples"])
                names_run.add(contender.name)
    assert {"semi-implicit Euler", "implicit Euler", "SciPy DOP853", "Stormer-Verlet"} <= names_run
    assert "SciPy DOP853, quaternions" in names_run and "explicit Euler, matrices" in names_run


def _keys(contender, problem):
    with pytest.raises(ValueError) as refusal:
        contender.run(problem, 1.0, {"no such key": 1})
    return str(refusal.value)


DAMPING_RATE, DURATION = 0.4, 1.0
SPRING = galvi.problems.harmonic_oscillator()
FREE_BODY = galvi.problems.free_rigid_body()
INERTIA = np.array(FREE_BODY.system.inertia)

# name: setting of a run of duration 1, tolerance on q; measured errors in comments
ON_VECTORS: Mapping[str, tuple[dict[str, Any], float]] = {
    "explicit Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "symplectic Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "semi-implicit Euler": ({"step": 1e-4}, 1e-4),  # 4e-5
    "SciPy RK45 (ode45)": ({"tolerance": 1e-9}, 1e-8),  # 1e-10
    "SciPy DOP853": (dict(TIGHT), 1e-14),  # 3e-16
    "SciPy Radau": ({"tolerance": 1e-9}, 1e-10),  # 9e-13
    "heyoka, Lagrangians": ({"compact_mode": True}, 1e-14),  # 1e-16
    "heyoka, Lagrangians, quadruple precision": ({}, 1e-15),  # 0
}
ON_BODIES: Mapping[str, tuple[dict[str, Any], float]] = {
    "explicit Euler, matrices": ({"step": 1e-3}, 1e-2),  # 2e-3
    "SciPy RK45 (ode45), matrices": ({"tolerance": 1e-9}, 1e-7),  # 1e-9
    "SciPy DOP853, quaternions": (dict(TIGHT), 1e-13),  # 1e-15
}
TAKERS = {**ON_VECTORS, **ON_BODIES}
TAKERS_HERE = [name for name in TAKERS if not reference(name).missing]


@njit
def friction(q, v):
    """-DAMPING_RATE v, (d,)."""
    return -DAMPING_RATE * v


@njit
def braking_torque(R, w):
    """A torque -DAMPING_RATE J w, (3,)."""
    return -DAMPING_RATE * (INERTIA @ w)


def forced(problem: galvi.Problem, force: Any) -> galvi.Problem:
    """The same problem with an external force."""
    return replace(problem, system=replace(problem.system, force=force))


POINT_PROBLEMS = ("harmonic_oscillator", "planar_pendulum", "henon_heiles")
BODY_PROBLEMS = ("free_rigid_body", "pendulum_3d", "heavy_top")
FORCED_PROBLEMS = {  # problems that references recognise, with an external force
    **{name: forced(getattr(galvi.problems, name)(), friction) for name in POINT_PROBLEMS},
    **{name: forced(getattr(galvi.problems, name)(), braking_torque) for name in BODY_PROBLEMS},
    "kepler": forced(galvi.problems.kepler(0.3), friction),
}


def damped_spring(t: float) -> float:
    """q of q'' = -q - DAMPING_RATE q' from q = 1, q' = 0."""
    half = DAMPING_RATE / 2.0
    w = np.sqrt(1.0 - half**2)
    return float(np.exp(-half * t) * (np.cos(w * t) + half / w * np.sin(w * t)))


def damped_turn(t: float) -> Any:
    """R of p' = p x w - k p, k = DAMPING_RATE: the free motion at (1 - exp(-k t)) / k."""
    free_time = (1.0 - np.exp(-DAMPING_RATE * t)) / DAMPING_RATE
    return FREE_TOP.run(FREE_BODY, free_time, {"samples": 1}).q[-1]


def error(contender: Any) -> float:
    """Largest error of q at the end against the closed form, over the contender's tolerance."""
    setting, tolerance = TAKERS[contender.name]
    if contender.name in ON_VECTORS:
        problem, exact = forced(SPRING, friction), damped_spring(DURATION)
    else:
        problem, exact = forced(FREE_BODY, braking_torque), damped_turn(DURATION)
    run = contender.run(problem, DURATION, setting)
    assert run.success
    return float(np.abs(run.q[-1] - exact).max()) / tolerance


@pytest.mark.parametrize("contender", REFERENCES, ids=lambda contender: contender.name)
def test_only_references_that_are_listed_here_take_a_force_and_others_refuse_it(contender):
    takes = [name for name, problem in FORCED_PROBLEMS.items() if contender.supports(problem)]
    assert bool(takes) == (contender.name in TAKERS), takes
    for problem in () if takes else FORCED_PROBLEMS.values():
        with pytest.raises(ValueError, match="does not solve this kind of problem"):
            contender.run(problem, DURATION, {"step": DURATION})


@pytest.mark.slow_cases("explicit Euler")
@pytest.mark.parametrize("name", TAKERS_HERE)
def test_a_reference_that_takes_forces_finds_the_closed_form(name):
    assert error(reference(name)) <= 1.0


@dataclass(frozen=True)
class WithoutForce:
    """Deliberately broken: takes a problem with a force, and solves it without."""

    inner: Contender

    @property
    def name(self) -> str:
        return self.inner.name

    def run(self, problem, duration, setting):
        return self.inner.run(forced(problem, None), duration, setting)


@pytest.mark.parametrize("name", TAKERS_HERE)
def test_a_reference_that_leaves_the_force_out_is_caught(name):
    assert error(WithoutForce(reference(name))) > 10.0


@pytest.mark.slow(
    beside="test_a_force_of_galvis_own_runs_compiled_and_is_the_function_it_is_called_as"
)
def test_a_force_of_time_and_one_in_plain_python_act_at_their_time():
    def driven(q, v, t):
        return np.array([np.cos(2.0 * t) - 0.1 * v[0]])

    problems = [
        replace(SPRING, system=replace(SPRING.system, force=f, timed_force=True))
        for f in (driven, njit(driven))
    ]
    exact = DOP853.run(problems[0], DURATION, TIGHT).q[-1]
    for problem in problems:
        assert is_forced(problem)
        end = SEMI_IMPLICIT_EULER.run(problem, DURATION, {"step": 1e-4}).q[-1]
        assert np.abs(end - exact).max() < 1e-4  # 3e-5
    late = replace(problems[0], t0=1.0)
    assert np.abs(DOP853.run(late, DURATION, TIGHT).q[-1] - exact).max() > 0.01


def test_semi_implicit_euler_is_of_first_order_and_symplectic_euler_without_a_force():
    steps = (100, 200, 400, 800)
    problem = forced(SPRING, friction)
    errors = [
        abs(SEMI_IMPLICIT_EULER.run(problem, 1.0, {"step": 1.0 / n}).q[-1, 0] - damped_spring(1.0))
        for n in steps
    ]
    slopes = np.diff(np.log(errors)) / np.diff(np.log(steps))
    assert np.all(np.abs(slopes + 1.0) < 0.05)  # 0.004
    setting = {"step": 0.01}
    free = SEMI_IMPLICIT_EULER.run(SPRING, 1.0, setting)
    same = reference("symplectic Euler").run(SPRING, 1.0, setting)
    np.testing.assert_allclose(free.q, same.q, rtol=0, atol=1e-14)


def test_a_force_of_galvis_own_runs_compiled_and_is_the_function_it_is_called_as():
    problem = galvi.problems.brownout(100e-6)
    drag = problem.system.force
    plain = replace(problem.system, force=lambda q, v, t: drag(q, v, t))
    compiled, called = (
        SEMI_IMPLICIT_EULER.run(replace(problem, system=system), 0.5, {"step": 1e-3})
        for system in (problem.system, plain)
    )
    np.testing.assert_allclose(compiled.q, called.q, rtol=0, atol=1e-13)  # 2e-15
    assert external_force(problem).compiled
    assert not external_force(replace(problem, system=plain)).compiled


EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def test_galvi_finds_the_closed_form_of_a_braked_free_body():
    run = galvi.integrate(forced(FREE_BODY, braking_torque), EIGHT, 0.25, 4)
    assert np.abs(run.q[-1] - damped_turn(1.0)).max() < 1e-13  # 3e-16


def test_galvi_and_dop853_agree_about_a_body_that_its_weight_turns_and_a_torque_brakes():
    hanging = galvi.problems.pendulum_3d()
    run = galvi.integrate(forced(hanging, braking_torque), EIGHT, 0.25, 4)
    exact = reference("SciPy DOP853, quaternions").run(forced(hanging, braking_torque), 1.0, TIGHT)
    assert np.abs(run.q[-1] - exact.q[-1]).max() < 1e-12
    assert np.abs(galvi.integrate(hanging, EIGHT, 0.25, 4).q[-1] - exact.q[-1]).max() > 0.01

"""References evaluate forces by formulas of their own, which agree with galvi's potentials."""

from dataclasses import replace

import numpy as np
import pytest

import galvi
from galvi.systems.canonical_on_rn import CanonicalOnRn
from references import REFERENCES
from references.forces.force import derivative, gradient
from references.newton import (
    FORMULAS,
    acceleration,
    acceleration_jacobian,
    external_force,
    potential_force,
)

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


def shaken(potential, **fields):
    return galvi.Problem(galvi.Canonical(1.5, potential, **fields), Q, V)


def test_every_formula_is_tried_here():
    assert {type(potential) for potential in POTENTIALS} == set(FORMULAS)


@every_potential
def test_a_formula_is_minus_the_slope_of_its_potential(potential):
    force = potential_force(shaken(potential))
    assert force.compiled and force.formula is not None
    np.testing.assert_allclose(force(Q, V, T), -gradient(potential, Q), rtol=1e-11, atol=1e-12)


@pytest.mark.slow_cases("SpringChain")
@every_potential
def test_its_jacobian_is_exact(potential):
    problem = shaken(potential)
    exact = problem.system.acceleration_jacobian(Q, T)
    found = acceleration_jacobian(problem)(Q, T)
    np.testing.assert_allclose(found, exact, rtol=1e-14, atol=1e-15)
    own = shaken(lambda q: potential(q))
    np.testing.assert_allclose(acceleration_jacobian(own)(Q, T), exact, rtol=1e-6, atol=1e-7)


def test_gravity_is_newtons_law_and_its_jacobian_too():
    system, rest = BODIES.system, np.zeros(BODIES.q0.shape)
    energy = lambda x: float(system.potential_energy(x.reshape(3, 2), 0.0))  # noqa: E731
    exact = -gradient(energy, BODIES.q0.ravel()).reshape(3, 2) / system.masses[:, None]
    np.testing.assert_allclose(acceleration(BODIES)(BODIES.q0, rest, 0.0), exact, rtol=1e-9)
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
        found = external_force(problem)(np.array(q), V, T)
        stated = problem.system.force(np.array(q), V, T)
        np.testing.assert_allclose(found, stated, rtol=1e-12)


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

    made = [BODIES, galvi.problems.brownout(), galvi.problems.henon_heiles()]
    made += [galvi.problems.spherical_pendulum(), galvi.problems.double_pendulum()]
    made += [shaken(potential) for potential in POTENTIALS] + [shaken(lambda q: float(q @ q))]
    body = galvi.RigidBody([1.0, 2.0, 2.5], lambda R: float(R[2, 2]), force=lambda R, w: -0.1 * w)
    made += [
        galvi.Problem(replace(body, force=None), np.eye(3), V),
        galvi.Problem(body, np.eye(3), V),
    ]
    for system in (galvi.Canonical, galvi.NBody, galvi.RigidBody, CanonicalOnRn, *FORMULAS):
        for name in (
            "force_kernel", "lagrangian_kernel", "law", "acceleration", "acceleration_jacobian",
            "potential_gradient", "potential_hessian", "gradient", "hessian",
            "slope", "torque",
        ):  # fmt: skip
            if callable(getattr(system, name, None)):
                monkeypatch.setattr(system, name, refused)
    monkeypatch.setattr(galvi.RotorDrag, "__call__", refused)
    monkeypatch.setattr(galvi.RotorDrag, "compiled", refused)
    ran = set()
    for contender in REFERENCES:
        for problem in made:
            if not contender.missing and contender.supports(problem):
                settings = ({"step": 0.25}, {"samples": 1})
                tried = "step" if "save_every" in _keys(contender, problem) else "samples"
                contender.run(problem, 0.5, settings[tried == "samples"])
                ran.add(contender.name)
    assert {"semi-implicit Euler", "implicit Euler", "SciPy DOP853", "Stormer-Verlet"} <= ran
    assert "SciPy DOP853, quaternions" in ran and "explicit Euler, matrices" in ran


def _keys(contender, problem):
    with pytest.raises(ValueError) as refusal:
        contender.run(problem, 1.0, {"no such key": 1})
    return str(refusal.value)

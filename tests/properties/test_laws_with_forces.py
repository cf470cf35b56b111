"""Laws in lanes with an external force: their formulas, and where they end."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp

import galvi
from galvi.lanes import laws
from galvi.run.in_lanes.lagrangian import has_law
from tests.agreement.on_vector_spaces import SYMBOLIC

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))


@pytest.mark.slow(beside="tests/agreement/test_agreement.py::test_every_problem_agrees")
def test_a_million_steps_of_a_grain() -> None:
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(galvi.problems.brownout(), method, 0.01, 1_000_000, save_every=1_000_000)
    assert run.success and run.counts["linear_solves"] == 0


@pytest.mark.parametrize(
    "potential",
    [galvi.UniformField([0.3, -0.2, 1.0]), galvi.CentralForce(1.3), galvi.LinearSpring(0.7),
     galvi.CosinePotential(1.1), galvi.SpringChain(0.2, 0.3)],
    ids=lambda potential: type(potential).__name__,
)  # fmt: skip
def test_the_law_of_a_canonical_system_has_its_derivatives(potential: Any) -> None:
    random = np.random.default_rng(2)
    q, v = random.normal(size=(2, 3))
    root = random.normal(size=(3, 3))
    slopes = laws.listed(potential.slopes)
    for mass in (2.0, [1.0, 2.0, 3.0], root @ root.T + np.eye(3)):
        system = galvi.Canonical(mass, potential)
        full = system.momentum(np.eye(3))
        constants = np.append(full.ravel(), potential.constants)
        law = laws.canonical(slopes, 3, system.mass.ndim < 2)
        forces, momenta, rows = law(q, v, 0.0, constants)
        np.testing.assert_allclose(forces, -potential.gradient(q), rtol=1e-13)
        np.testing.assert_allclose(momenta, system.momentum(v), rtol=1e-13)
        np.testing.assert_array_equal([x for row in rows for x in row], full[np.tril_indices(3)])


def test_forces_without_a_form_in_lanes_are_left_to_the_general_kernel() -> None:
    L, (q, v), q0, v0 = SYMBOLIC["elastic pendulum"]
    steps = galvi.Lagrangian.from_sympy(L, q, v, force=[sp.Max(v[0], 0), 0])
    python = galvi.Lagrangian(steps.function, steps.group, force=lambda q, v: np.maximum(v, 0.0))
    for system in (steps, python):
        assert not has_law(galvi.Problem(system, q0, v0), FOUR)

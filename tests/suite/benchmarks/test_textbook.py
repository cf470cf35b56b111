"""The textbook's formulas and galvi's own agree, having been written apart."""

import numpy as np
import pytest

import galvi
from benchmarks.measures import independent_invariants
from references.textbook.nystrom import Nystrom

METHOD = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


@pytest.mark.parametrize(
    ("problem", "step"),
    [
        (galvi.problems.harmonic_oscillator(), 0.5),
        (galvi.problems.kepler(0.4), 0.2),
        (galvi.problems.solar_system(), 5.0),
        (galvi.problems.free_rigid_body(), 0.2),
        (galvi.problems.pendulum_3d(), 0.2),
    ],
    ids=lambda value: getattr(value, "name", None),
)
def test_invariants_are_those_of_galvi(problem, step):
    run = galvi.integrate(problem, METHOD, step, 20)
    v = problem.system.velocity(run.p)
    assert np.allclose(
        independent_invariants.energy(problem, run.q, v), galvi.energy(run), rtol=1e-13
    )
    if problem.q0.shape[-1] > 1:
        found = independent_invariants.angular_momentum(problem, run.q, v)
        exact = galvi.momentum_map(run)
        assert np.allclose(found, exact, rtol=1e-12, atol=1e-14 * np.abs(exact).max())


def test_the_energy_of_a_thrown_body_is_that_of_galvi():
    problem = galvi.problems.free_body_se3(g=(0.1, -0.2, -1.0))
    run = galvi.integrate(problem, METHOD, 0.2, 20)
    v = problem.system.velocity(run.p)
    assert np.allclose(
        independent_invariants.energy(problem, run.q, v), galvi.energy(run), rtol=1e-13
    )


def test_a_system_without_a_formula_is_refused():
    problem = galvi.problems.henon_heiles()
    with pytest.raises(TypeError, match="there is no textbook energy here"):
        independent_invariants.energy(problem, problem.q0[None], problem.v0[None])


@pytest.mark.parametrize(("stages", "velocity"), [((0.0,), 2.0), ((0.5,), 1.0)])
def test_a_tableau_that_is_inconsistent_or_implicit_is_refused(stages, velocity):
    with pytest.raises(ValueError, match="weights that sum to 1 and stages below the diagonal"):
        Nystrom("wrong", 1, (stages,), (0.0,), (0.5,), (velocity,))

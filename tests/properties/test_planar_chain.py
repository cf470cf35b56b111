"""Chains of links: their slopes against SymPy's, their motions against closed forms."""

import pickle

import numpy as np
import pytest
from scipy.special import ellipk

import galvi

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))


def positions_lagrangian(masses, lengths, gravity, rods):
    """Kinetic minus potential energy of points or of uniform rods, from positions in the plane."""
    sympy = pytest.importorskip("sympy")
    n = len(masses)
    t = sympy.Symbol("t")
    q = [sympy.Function(f"q{i}")(t) for i in range(n)]
    hinge, L = sympy.Matrix([0, 0]), 0
    for m, l, angle in zip(masses, lengths, q, strict=True):
        direction = sympy.Matrix([sympy.sin(angle), -sympy.cos(angle)])
        centre = hinge + l * direction / (2 if rods else 1)
        velocity = centre.diff(t)
        L += m * (velocity.dot(velocity) / 2 - gravity * centre[1])
        L += m * l**2 * angle.diff(t) ** 2 / 24 if rods else 0
        hinge = hinge + l * direction
    return galvi.Lagrangian.from_sympy(L, q)


MASSES, LENGTHS = (1.2, 0.7, 2.1), (0.8, 1.3, 0.6)
Q, V = np.array([0.4, -1.9, 2.7]), np.array([1.1, -0.3, 0.8])


@pytest.mark.slow_cases("points")
@pytest.mark.parametrize("rods", [False, True], ids=["points", "rods"])
def test_its_slopes_and_its_value_are_those_that_sympy_derives_from_places(rods):
    written = galvi.Lagrangian(galvi.PlanarChain(MASSES, LENGTHS, 9.5, rods), galvi.Rn(3))
    derived = positions_lagrangian(MASSES, LENGTHS, 9.5, rods)
    chain, sympy_function = written.function, derived.function
    assert chain(Q, V) == pytest.approx(sympy_function(Q, V), rel=1e-14)
    np.testing.assert_allclose(
        chain.slopes(Q, V), sympy_function.slopes(Q, V), rtol=0, atol=1e-13
    )  # 4e-15
    runs = [
        galvi.integrate(galvi.Problem(system, Q, V), EIGHT, 0.05, 10)
        for system in (written, derived)
    ]
    np.testing.assert_allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-13)  # 9e-16
    np.testing.assert_allclose(runs[0].p, runs[1].p, rtol=0, atol=1e-13)  # 3e-15


def test_a_rod_taken_for_a_point_would_be_seen():
    chain = galvi.PlanarChain(MASSES, LENGTHS, 9.5, rods=True)
    derived = positions_lagrangian(MASSES, LENGTHS, 9.5, rods=False).function
    assert np.max(np.abs(chain.slopes(Q, V) - derived.slopes(Q, V))) > 1.0


@pytest.mark.slow_cases("False-1.0")
@pytest.mark.parametrize(("rods", "reduced_length"), [(False, 1.0), (True, 2.0 / 3.0)])
def test_one_link_is_a_pendulum_with_the_period_of_its_reduced_length(rods, reduced_length):
    chain = galvi.PlanarChain([1.7], [0.9], 9.81, rods)
    period = 4.0 * np.sqrt(reduced_length * 0.9 / 9.81) * ellipk(np.sin(0.8) ** 2)
    problem = galvi.Problem(galvi.Lagrangian(chain, galvi.Rn(1)), [1.6], [0.0])
    run = galvi.integrate(problem, EIGHT, period / 16, 16)
    assert abs(run.q[-1, 0] - 1.6) < 1e-13 and abs(run.q[8, 0] + 1.6) < 1e-13  # 4e-16


def test_energy_is_kept_and_a_run_can_be_saved_without_its_problem(tmp_path):
    problem = galvi.problems.planar_chain()
    run = galvi.integrate(problem, EIGHT, 0.02, 60)
    assert run.success and np.ptp(galvi.energy(run)) < 1e-12  # 6e-14 of 66
    galvi.save(run, tmp_path / "run.npz")
    loaded = galvi.load(tmp_path / "run.npz")
    assert np.array_equal(galvi.resume(loaded, 5).q, galvi.resume(run, 5).q)
    assert isinstance(loaded.problem.system.function, galvi.PlanarChain)
    copy = pickle.loads(pickle.dumps(problem))
    assert np.array_equal(galvi.integrate(copy, EIGHT, 0.02, 60).q, run.q)


def test_without_gravity_a_chain_keeps_its_angular_momentum():
    problem = galvi.problems.double_pendulum((1.0, 2.0), (1.0, 0.7), 0.0, (0.5, 2.0), (1.0, -2.0))
    run = galvi.integrate(problem, EIGHT, 0.1, 50)
    assert np.ptp(np.sum(run.p, axis=1)) < 1e-13  # 2e-15: all angles shift together


def test_a_step_too_large_for_the_motion_is_said_so_though_it_is_solved():
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    ruined = galvi.integrate(galvi.problems.double_pendulum(), method, 0.3, 6)
    assert ruined.outcome.end is galvi.End.RUINED and ruined.counts["steps"] == 6
    assert np.all(np.isfinite(ruined.q))  # the energy changes by 500 times the potential's range
    resolved = galvi.integrate(galvi.problems.double_pendulum(), method, 0.02, 90)
    assert resolved.status == "Completed."


def test_a_force_may_change_the_energy_without_a_word():
    chain = galvi.problems.double_pendulum()
    braked = galvi.Lagrangian(
        chain.system.function, chain.system.group, force=lambda q, v: -4.0 * v
    )
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    run = galvi.integrate(galvi.Problem(braked, chain.q0, chain.v0), method, 0.05, 40)
    assert run.status == "Completed."

"""Runs: solvers, user functions, and failures."""

import numba
import numpy as np
import pytest

import galvi
from tests.properties.lagrangians import opaque

KEPLER = galvi.problems.kepler(0.6)
HENON = galvi.problems.henon_heiles()
CHAIN = galvi.problems.fermi_pasta_ulam_tsingou(masses=6, beta=0.3)
EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))


def same_states(left, right):
    return np.array_equal(left.q, right.q) and np.array_equal(left.p, right.p)


def with_python_functions(system):
    """The system with Python functions in place of compiled ones."""
    return galvi.Canonical(
        system.mass, system.potential.py_func, system.gradient.py_func, system.hessian.py_func
    )


def test_plain_python_functions_give_the_compiled_result_to_the_bit():
    problem = galvi.Problem(with_python_functions(HENON.system), HENON.q0, HENON.v0)
    for solver in ("auto", "newton"):
        runs = [galvi.integrate(p, FOUR, 0.3, 50, solver=solver) for p in (problem, HENON)]
        assert same_states(*runs)
        assert runs[0].counts == runs[1].counts


def test_counts_are_the_same_in_every_run():
    counts = [galvi.integrate(KEPLER, FOUR, 0.1, 200).counts for _ in range(3)]
    assert counts[0] == counts[1] == counts[2]
    assert counts[0]["force_evaluations"] == 4 * counts[0]["iterations"]


@numba.njit
def driving(q, t):
    return -np.cos(t) * np.ones_like(q)


@pytest.mark.parametrize("gradient", [driving, driving.py_func, None])
def test_an_explicit_time_dependence_is_seen_by_compiled_and_plain_functions(gradient):
    """q'' = cos t from rest at q = 0, so q = 1 - cos t."""
    system = galvi.Canonical(1.0, lambda q, t: -np.cos(t) * q[0], gradient, explicit_time=True)
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), EIGHT, 0.5, 20)
    assert np.allclose(run.q[:, 0], 1 - np.cos(run.t), atol=1e-12)


def test_a_full_mass_matrix_is_a_change_of_coordinates():
    mixing = np.array([[1.0, 0.3], [0.0, 0.8]])
    spring = galvi.LinearSpring(1.0)
    straight = galvi.Problem(galvi.Canonical(1.0, spring), mixing @ [1.0, 0.5], mixing @ [0.2, 0.1])
    potential = lambda y: spring(mixing @ y)  # noqa: E731
    gradient = lambda y: mixing.T @ (mixing @ y)  # noqa: E731
    mixed = galvi.Problem(
        galvi.Canonical(mixing.T @ mixing, potential, gradient), [1.0, 0.5], [0.2, 0.1]
    )
    for solver in ("fixed_point", "newton"):
        decoupled_run = galvi.integrate(straight, FOUR, 0.4, 30, solver=solver)
        mixed_run = galvi.integrate(mixed, FOUR, 0.4, 30, solver=solver)
        assert np.allclose(decoupled_run.q, mixed_run.q @ mixing.T, atol=1e-13)
    assert np.allclose(galvi.energy(decoupled_run), galvi.energy(mixed_run), atol=1e-13)


def falling_bodies():
    """Two bodies that meet head-on at t = 0.785 * sqrt(2)."""
    return galvi.Problem(galvi.NBody([0.5, 0.5]), [[-0.5, 0.0], [0.5, 0.0]], np.zeros((2, 2)))


@pytest.mark.parametrize("save_every", [1, 3])
def test_a_failing_run_says_where_and_shows_no_number_past_it(save_every):
    run = galvi.integrate(falling_bodies(), FOUR, 0.05, 60, save_every=save_every, curves=True)
    assert run.outcome.end is galvi.End.STEP_FAILED and 15 <= run.failed_step <= 30
    assert run.outcome.reason.startswith("bodies 0 and 1 collide. ")
    completed = (run.failed_step - 1) // save_every + 1
    assert np.all(np.isfinite(run.q[:completed]))
    assert np.all(np.isnan(run.q[completed:])) and np.all(np.isnan(run.p[completed:]))
    last = (run.failed_step - 1) * 0.05
    assert np.isfinite(run(last)).all() and np.isnan(run(last + 0.01)).all()
    assert run.counts["steps"] == run.failed_step - 1
    with pytest.raises(ValueError, match="a run that failed cannot be resumed"):
        galvi.resume(run, 3)


def gradient_right_of_0(q):
    return q if q[0] > 0.0 else q * np.nan


def hessian_right_of_0(q):
    return np.eye(1) if q[0] > 0.0 else np.full((1, 1), np.nan)


@pytest.mark.parametrize(
    ("functions", "solver"),
    [
        ((galvi.LinearSpring(), gradient_right_of_0), "auto"),
        (
            (opaque(lambda q: 0.5 * (q @ q)), opaque(lambda q: q), opaque(hessian_right_of_0)),
            "newton",
        ),
    ],
)
def test_nan_during_the_run_is_a_failure(functions, solver):
    problem = galvi.Problem(galvi.Canonical(1.0, *functions), [1.0], [0.0])
    run = galvi.integrate(problem, FOUR, 0.1, 100, solver=solver)
    assert run.outcome.end is galvi.End.STEP_FAILED
    assert run.failed_step == 16  # q = cos t crosses 0 within the step from 1.5 to 1.6
    assert "infinite or NaN" in run.status


@pytest.mark.parametrize("factor", [0.5, 1.3])
def test_a_hessian_that_is_off_costs_passes_and_no_accuracy(factor):
    def run(factor):
        hessian = opaque(lambda q: factor * np.eye(1))
        V, gradient = opaque(lambda q: 0.5 * (q @ q)), opaque(lambda q: 1.0 * q)
        system = galvi.Canonical(1.0, V, gradient, hessian, check=False)
        start = galvi.Problem(system, [1.0], [0.3])
        return galvi.integrate(start, FOUR, 1.0, 20, solver="newton")

    wrong_run, right_run = run(factor), run(1.0)
    assert wrong_run.counts["iterations"] > 3 * right_run.counts["iterations"]
    assert np.abs(wrong_run.q - right_run.q).max() < 5e-15  # 2e-16


def test_backwards_undoes_forwards():
    for problem in (KEPLER, HENON, CHAIN):
        assert galvi.round_trip_error(problem, FOUR, 0.2, 200) < 1e-10
    errors = [galvi.round_trip_error(CHAIN, FOUR, step, 3) for step in (1.0, np.uint64(1))]
    assert errors[0] == errors[1]
    back = galvi.integrate(KEPLER, FOUR, -0.2, duration=1.0)
    assert back.t[-1] == -1.0 and back.counts["steps"] == 5
    forward = galvi.integrate(KEPLER, FOUR, 0.2, 5)
    assert np.allclose(back.q * [1, -1], forward.q, atol=1e-14)  # the orbit's own symmetry


def test_progress_shows_on_standard_error(capsys):
    galvi.integrate(KEPLER, FOUR, 0.1, 100, progress=True)
    assert "100/100" in capsys.readouterr().err
    galvi.integrate(KEPLER, FOUR, 0.1, 100)
    assert capsys.readouterr().err == ""


@pytest.mark.slow_cases("37-1.0", "60-1.0")
@pytest.mark.parametrize("mu", [1.0, 0.999, 1.001])
@pytest.mark.parametrize("n", [16, 21, 37, 60])
def test_a_large_step_never_ends_on_another_branch(n, mu):
    """Kepler at a third of a period: 4 % of such runs once took a wrong root and said Completed."""
    system = galvi.Canonical(1.0, galvi.CentralForce(mu))
    problem = galvi.Problem(system, KEPLER.q0, KEPLER.v0)
    method = galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(2 * n))
    run = galvi.integrate(problem, method, 2.0, 100)
    assert run.success
    assert np.ptp(galvi.momentum_map(run)) < 1e-12

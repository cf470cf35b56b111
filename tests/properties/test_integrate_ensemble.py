"""Members of an ensemble are the runs of one by one, whatever law, method, step and parameters."""

import numpy as np
import pytest

import galvi
from galvi.ensembles.member_laws import law_of
from galvi.ensembles.parameters import Parameters
from galvi.systems.traces import traces
from tests.properties.ensemble_cases import CASES, farthest, starts

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
SIX = galvi.Galerkin(galvi.Polynomials(6), galvi.gauss(6))


def assert_equal_runs(result, runs, tolerance=2e-13):  # measured: 6e-15
    q, p = np.stack([run.q[-1] for run in runs]), np.stack([run.p[-1] for run in runs])
    for found, truth in zip(result.kept, (q, p), strict=True):
        size = max(np.abs(truth).max(), 1.0)
        assert np.abs(found - truth).max() <= tolerance * size


@pytest.mark.slow_cases(but=["brownout-1-method0", "polar-1-method1"])
@pytest.mark.parametrize(
    ("name", "unit", "method"),
    [("brownout", 1, FOUR), ("polar", 1, FOUR), ("free_body", 1, FOUR), ("pendulum_3d", 1, FOUR),
     ("pendulum_3d", 1, SIX), ("se2", 1, FOUR), ("free_body_se3", 1e-6, FOUR)],
)  # fmt: skip
def test_members_take_about_as_many_passes_as_single_runs(name, unit, method):
    """Where both iterate the same equations, to the same tolerance, from the same guesses, in any
    unit of length."""
    problem, step = CASES[name]
    q, v = starts(problem, 8)
    if unit != 1:
        q[:, :3, 3] /= unit
        v[:, 3:] /= unit
    passes = sum(galvi.integrate_ensemble(problem, q, v, method, step, 40).iterations)
    runs = [
        galvi.integrate(problem.with_initial_state(*state), method, step, 40)
        for state in zip(q, v, strict=True)
    ]
    assert -0.045 < passes / sum(run.counts["iterations"] for run in runs) - 1.0 < 0.03


@pytest.mark.slow(beside="test_members_take_about_as_many_passes_as_single_runs")
def test_changes_are_relative_to_the_place_far_from_the_origin():
    def L(g, v):
        return 0.5 * (v @ (v * [1.0, 1.3, 1.6])) - 0.4 * g[0, 0] - 0.3 * g[0, 2] + 0.2 * g[1, 2]

    problem = galvi.Problem(galvi.Lagrangian(L, galvi.SE2()), np.eye(3), [0.5, 0.3, 0.1])
    q, v = starts(problem, 8)
    q[:, 0, 2] += 1e6
    passes = sum(galvi.integrate_ensemble(problem, q, v, FOUR, 0.1, 40).iterations)
    starting = [problem.with_initial_state(*state) for state in zip(q, v, strict=True)]
    runs = galvi.integrate_many(starting, FOUR, 0.1, 40)
    assert 0.95 < passes / sum(run.counts["iterations"] for run in runs) < 1.05  # 0.984


@pytest.mark.slow(beside="test_a_step_that_needs_newton_is_done_by_itself")
def test_a_body_that_turns_beyond_its_chart_is_run_by_itself():
    problem = galvi.problems.free_rigid_body()
    v = np.stack([problem.v0, 40.0 * problem.v0])
    result = galvi.integrate_ensemble(problem, problem.q0, v, FOUR, 0.5, 3)
    alone = galvi.integrate(problem.with_initial_state(problem.q0, v[1]), FOUR, 0.5, 3)
    assert result.success[0] and result.success[1] == alone.success
    assert "by itself" in result.status[1]
    assert np.array_equal(result[0][1], alone.q[-1], equal_nan=True)


def test_parameters_of_systems_differ_between_members():
    kepler, step = CASES["kepler"]
    mu, mass = np.array([1.0, 1.1, 0.9]), np.array([1.0, 2.0, 0.5])
    result = galvi.integrate_ensemble(
        kepler, kepler.q0, kepler.v0, FOUR, step, 10, {"mu": mu, "mass": mass}
    )
    runs = [
        galvi.integrate(
            galvi.Problem(galvi.Canonical(m, galvi.CentralForce(k)), kepler.q0, kepler.v0),
            FOUR, step, 10,
        )
        for k, m in zip(mu, mass, strict=True)
    ]  # fmt: skip
    assert_equal_runs(result, runs)
    swinging, step = CASES["sympy"]
    result = galvi.integrate_ensemble(
        swinging, swinging.q0, swinging.v0, FOUR, step, 10, {"k": [40.0, 50.0], "c": [0.1, 0.0]}
    )
    one = galvi.integrate(swinging, FOUR, step, 10)
    assert np.allclose(result[0][0], one.q[-1], rtol=1e-13)
    assert np.abs(result[0][1] - one.q[-1]).max() > 1e-3
    bodies, step = CASES["three_bodies"]
    masses = np.array([[1.0, 1e-3, 0.0], [1.0, 0.0, 1e-3]])
    result = galvi.integrate_ensemble(
        bodies, bodies.q0, bodies.v0, FOUR, step, 10, {"masses": masses}
    )
    runs = [
        galvi.integrate(galvi.Problem(galvi.NBody(m), bodies.q0, bodies.v0), FOUR, step, 10)
        for m in masses
    ]
    assert_equal_runs(result, runs)


def test_a_member_that_fails_is_nan_with_a_status_and_the_others_go_on():
    problem = galvi.problems.kepler(0.3)
    q, v = starts(problem, 12, 1e-3)
    q[5], v[5] = [1e-3, 0.0], [0.0, 0.0]  # falls into the centre
    result = galvi.integrate_ensemble(problem, q, v, FOUR, 0.2, 20)
    alone = galvi.integrate(problem.with_initial_state(q[5], v[5]), FOUR, 0.2, 20)
    assert not alone.success
    assert np.flatnonzero(~result.success).tolist() == [5]
    assert alone.status in result.status[5] and "by itself" in result.status[5]
    assert np.array_equal(result[0][5], alone.q[-1], equal_nan=True)
    others = np.delete(np.arange(12), 5)
    without = galvi.integrate_ensemble(problem, q[others], v[others], FOUR, 0.2, 20)
    assert np.array_equal(result[0][others], without[0])


def test_a_step_that_needs_newton_is_done_by_itself():
    problem = galvi.problems.harmonic_oscillator()
    result = galvi.integrate_ensemble(problem, [[1.0], [1.0]], problem.v0, FOUR, [0.1, 8.0], 5)
    alone = galvi.integrate(problem, FOUR, 8.0, 5)
    assert alone.success and result.success.all()
    assert result.status[0] == "Completed." and "by itself" in result.status[1]
    assert np.array_equal(result[0][1], alone.q[-1])


def test_systems_without_a_law_run_one_by_one_and_say_so():
    def potential(q):
        return 0.5 * float(q @ q) if q[0] < 1e9 else 0.0  # it branches: it cannot be traced

    problem = galvi.Problem(galvi.Canonical(1.0, potential), [1.0], [0.0])
    assert law_of(problem.system, 1) is None
    result = galvi.integrate_ensemble(problem, [[1.0], [0.5]], problem.v0, FOUR, 0.1, 3)
    assert "no vector code" in result.status[0] and result.success.all()
    assert np.array_equal(result[0][0], galvi.integrate(problem, FOUR, 0.1, 3).q[-1])


def test_members_of_a_frame_or_of_degrees_that_lanes_do_not_take_say_why_they_run_one_by_one():
    outer = galvi.problems.outer_solar_system()
    framed = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4), galvi.KeplerFrame())
    result = galvi.integrate_ensemble(outer, outer.q0[None], outer.v0, framed, 100.0, 3)
    assert "methods in a frame" in result.status[0] and result.success.all()
    assert "no law" not in result.status[0]
    springs = galvi.Canonical([[2.0, 0.5], [0.5, 1.0]], lambda q: q[0] ** 2 + q[1] ** 2)
    coupled = galvi.Problem(springs, [1.0, 0.0], [0.0, 1.0])
    mixed = galvi.Galerkin(galvi.ComponentPolynomials((4, 2)), galvi.gauss(4))
    result = galvi.integrate_ensemble(coupled, [[1.0, 0.0]], coupled.v0, mixed, 0.1, 3)
    assert "weights or degrees" in result.status[0] and result.success.all()


def test_kept_values():
    problem, step = CASES["henon_heiles"]
    q, v = starts(problem, 10)
    times = problem.t0 + step * np.array([0, 3, 7])
    ensemble = lambda keep: galvi.integrate_ensemble(problem, q, v, FOUR, step, 7, keep=keep)  # noqa: E731
    runs = [
        galvi.integrate(problem.with_initial_state(*state), FOUR, step, 7)
        for state in zip(q, v, strict=True)
    ]
    whole = np.stack([run.q for run in runs])
    at = ensemble(galvi.StatesAt(times))
    assert np.allclose(at[0], whole[:, [0, 3, 7]], rtol=0, atol=1e-14)
    extrema = ensemble(galvi.Extrema())
    assert np.allclose(extrema[0], whole.min(axis=1), atol=1e-14)
    assert np.allclose(np.asarray(extrema)[:, 1], whole.max(axis=1), atol=1e-14)
    counts = ensemble(galvi.Histogram(lambda t, q, p: q[:, 0], [-1.0, 0.0, 1.0]))
    assert np.asarray(counts).sum(axis=1).tolist() == [8.0] * 10
    assert np.array_equal(np.asarray(counts)[:, 1], (whole[..., 0] >= 0.0).sum(axis=1))
    compiled, python = ensemble(farthest), ensemble(lambda run: np.abs(run.q).max())
    assert np.allclose(np.asarray(compiled)[:, 0], np.asarray(python), rtol=1e-13)
    assert np.array_equal(np.asarray(python), np.abs(whole).max(axis=(1, 2)))
    assert "Python function" in python.status[0] and compiled.status[0] == "Completed."


def test_the_system_of_a_member_that_runs_alone_is_traced_as_that_of_a_problem_is():
    problem = galvi.Problem(galvi.Canonical(2.0, lambda q: 0.5 * (q @ q) + q[0] ** 4), [1.0], [0.0])
    system = Parameters(problem, {"mass": np.array([1.0, 3.0])}, 2).system(1)
    assert system.mass == 3.0 and traces(system).found.keys() == {"dV/dq"}


def test_a_number_that_a_system_refuses_is_found_before_the_first_step(tmp_path):
    problem, members = galvi.problems.kepler(0.3), 200
    mu = np.ones(members)
    mu[-1] = -1.0
    with pytest.raises(ValueError, match="mu must be positive") as caught:
        galvi.integrate_ensemble(
            problem, problem.q0, problem.v0, FOUR, 0.1, 1, {"mu": mu}, folder=tmp_path
        )
    assert caught.value.__notes__ == ["This was member 199."] and not list(tmp_path.iterdir())


@pytest.mark.parametrize("keep", [galvi.FinalStates(), galvi.Extrema()])
def test_a_member_that_a_problem_refuses_fails_alone(keep):
    bodies, step = CASES["three_bodies"]
    q = np.stack([bodies.q0] * 10)
    q[3, 1] = q[3, 0]  # two bodies at one place
    result = galvi.integrate_ensemble(bodies, q, bodies.v0, FOUR, step, 3, keep=keep)
    with pytest.raises(ValueError) as refusal:
        galvi.integrate(bodies.with_initial_state(q[3], bodies.v0), FOUR, step, 3)
    assert np.flatnonzero(~result.success).tolist() == [3] and result.failed_step[3] == 1
    assert result.outcomes[3].reason == str(refusal.value).removesuffix(".")
    assert "vector code could not do step 1" in result.status[3]
    assert np.isnan(result[0][3]).all() and np.isfinite(np.delete(result[0], 3, axis=0)).all()


def test_energies_are_judged_of_no_member():
    system = galvi.Canonical(1.0, lambda q: 0.5 * (q @ q), lambda q: -q, check=False)
    problem = galvi.Problem(system, [1.0], [0.0])  # repelled, not attracted
    alone = galvi.integrate(problem, FOUR, 0.1, 30)
    assert not alone.success and np.isfinite(alone.q).all()  # ruined, but solved
    for keep in (galvi.FinalStates(), lambda run: run.q[-1]):
        result = galvi.integrate_ensemble(problem, problem.q0, problem.v0, FOUR, 0.1, 30, keep=keep)
        assert result.success.all() and np.isfinite(result[0]).all()

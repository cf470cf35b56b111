"""Cases that were once silently wrong, and input that once gave a stack trace."""

import copy
import pickle
from dataclasses import replace

import numpy as np
import pytest

import galvi

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.3)


@pytest.mark.parametrize("size", [1.0, 1e-3, 1e-10, 1e8])
def test_a_differenced_gradient_follows_the_length_scale(size):
    """A Kepler orbit of any size, V without gradient; times scale as size^(3/2)."""

    def potential(q):
        if q[0] == np.inf:
            return 0.0  # a branch, so that it is not traced
        return -1.0 / np.sqrt(q[0] ** 2 + q[1] ** 2)

    start = galvi.problems.kepler(0.9)
    bare = galvi.Problem(galvi.Canonical(1.0, potential), size * start.q0, start.v0 / np.sqrt(size))
    exact = replace(bare, system=start.system)
    runs = [galvi.integrate(problem, EIGHT, 0.01 * size**1.5, 20) for problem in (bare, exact)]
    assert np.allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-9 * size)


def test_a_differenced_gradient_sees_a_scale_much_below_the_coordinates():
    def potential(q):
        return 1.0 / (q[1] - q[0]) + (q[1] - q[0])

    system = galvi.Canonical(1.0, potential)
    q = np.array([100.0, 101.2])
    slope = 1.0 - 1.0 / 1.2**2
    assert np.allclose(system.potential_gradient(q, 0.0), [-slope, slope], atol=1e-9)


@pytest.mark.parametrize("force", [1.0, 1e-10, 1e-25])
def test_a_body_at_rest_in_the_origin_is_solved_to_round_off(force):
    """q'' = -q + force cos 2 t from rest in 0: q = force (cos t - cos 2 t) / 3."""
    system = galvi.Canonical(
        1.0,
        lambda q, t: 0.0,
        lambda q, t: q - force * np.cos(2 * t),
        explicit_time=True,
        check=False,
    )
    run = galvi.integrate(galvi.Problem(system, [0.0], [0.0]), EIGHT, 1.0, 3)
    exact = force * (np.cos(run.t) - np.cos(2 * run.t)) / 3
    assert np.allclose(run.q[:, 0], exact, rtol=0, atol=1e-9 * force)


def test_a_force_without_potential_is_seen_not_to_be_symplectic():
    turning = np.array([[0.0, 1.0], [-1.0, 0.0]])
    system = galvi.Canonical(1.0, galvi.LinearSpring(), lambda q: turning @ q, check=False)
    problem = galvi.Problem(system, [1.0, 0.0], [0.0, 1.0])
    assert galvi.symplecticity_defect(problem, EIGHT, 0.3) > 1e-3


def test_a_gradient_may_return_its_own_buffer():
    buffer = np.zeros(2)

    def gradient(q):
        buffer[:] = q / np.linalg.norm(q) ** 3
        return buffer

    system = galvi.Canonical(1.0, galvi.CentralForce(1.0), gradient)
    buffered = galvi.Problem(system, KEPLER.q0, KEPLER.v0)
    derivative, exact = (
        galvi.step_derivative(problem, EIGHT, 0.3) for problem in (buffered, KEPLER)
    )
    assert np.allclose(derivative, exact, atol=1e-8)


@pytest.mark.parametrize("step", [0.1, 0.03, 0.01])
def test_every_step_end_is_on_the_curve_also_far_from_t_0(step):
    late = galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, t0=2451544.5)
    for steps in (1, 7, 40):
        run = galvi.integrate(late, EIGHT, step, steps)
        assert np.allclose(run(run.t), run.q, rtol=0, atol=1e-14)
        assert np.array_equal(run(run.t[-1]), run(run.t)[-1])


def test_at_a_joint_the_velocity_is_the_later_curves():
    method = galvi.Galerkin(galvi.Polynomials(2), galvi.gauss(2))
    late = galvi.Problem(KEPLER.system, KEPLER.q0, KEPLER.v0, t0=1000.1)
    run = galvi.integrate(late, method, 0.3, 40)
    psi = method.space.derivative(np.zeros(1))[0, 1:]
    later = run.curves.coefficients @ psi / 0.3
    assert np.array_equal(run.velocity(run.t[:-1]), later)


def test_problems_and_runs_can_be_pickled_and_copied():
    run = galvi.integrate(galvi.problems.solar_system(), EIGHT, 10.0, 3)
    for copied in (pickle.loads(pickle.dumps(run)), copy.deepcopy(run)):
        assert np.array_equal(copied.q, run.q)
        assert copied.problem.parameters == run.problem.parameters
        assert np.array_equal(galvi.resume(copied, 2).q, galvi.resume(run, 2).q)


def test_parameters_are_saved_as_numbers_texts_and_lists(tmp_path):
    parameters = {
        "e": 0.3,
        "bodies": ("Sun", "Mars"),
        "count": 2,
        "closed": True,
        "note": None,
        "masses": np.array([1.0, 2.0]),
        "mu": np.float64(4.0),
    }
    problem = replace(KEPLER, parameters=parameters)
    galvi.save(galvi.integrate(problem, EIGHT, 0.1, 3), tmp_path / "run.npz")
    assert dict(galvi.load(tmp_path / "run.npz").problem.parameters) == parameters | {
        "bodies": ["Sun", "Mars"],
        "masses": [1.0, 2.0],
        "mu": 4.0,
    }


@pytest.mark.slow(beside="test_the_status_names_only_what_was_tried")
def test_a_step_without_solution_is_a_status_not_a_stack_trace():
    unstable = galvi.Canonical(1.0, lambda q: -0.5 * q @ q, lambda q: -q)
    midpoint = galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(1))
    run = galvi.integrate(galvi.Problem(unstable, [1.0], [0.0]), midpoint, 2.0, 3)
    assert not run.success and run.failed_step == 1
    run = galvi.integrate(
        galvi.Problem(galvi.NBody([1.0]), [[0.0, 0.0]], [[1e300, 0.0]]), EIGHT, 1e10, 3
    )
    assert not run.success


def test_the_status_names_only_what_was_tried():
    stiff = galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(1e6)), [1.0], [0.0])
    run = galvi.integrate(stiff, EIGHT, 1.0, 3, solver="fixed_point")
    assert "Newton" not in run.status and "or the solver auto" in run.status


@pytest.mark.slow_cases("2")
@pytest.mark.parametrize("bodies", [2, ("Sun",), "sun", None])
def test_a_failing_run_reads_no_more_than_names_from_the_parameters(bodies):
    system, zero = galvi.NBody([0.5, 0.5]), np.zeros((2, 2))
    problem = galvi.Problem(system, [[-0.5, 0.0], [0.5, 0.0]], zero, parameters={"bodies": bodies})
    assert "bodies 0 and 1 collide" in galvi.integrate(problem, EIGHT, 0.1, 60).status


def test_a_saved_run_is_not_loaded_with_another_system(tmp_path):
    galvi.save(galvi.integrate(KEPLER, EIGHT, 0.1, 3), tmp_path / "run.npz")
    another_system = galvi.Canonical(5.0, galvi.CentralForce(9.0))
    with pytest.raises(ValueError, match="must have the system of the run"):
        galvi.load(tmp_path / "run.npz", galvi.Problem(another_system, KEPLER.q0, KEPLER.v0))
    with pytest.raises(TypeError, match=r"problem must be a galvi\.Problem; received 5"):
        galvi.load(tmp_path / "run.npz", 5)


def test_damaged_files_are_refused_in_one_sentence(tmp_path):
    path = tmp_path / "run.npz"
    galvi.save(galvi.integrate(KEPLER, EIGHT, 0.1, 3), path)
    content = path.read_bytes()
    unclosed = content.replace(b"), }", b"(, }")  # in the headers of arrays
    assert unclosed != content
    first = content.index(b"PK\x01\x02") + 10  # in the archive's directory
    compressed = content[:first] + b"\x63\x00" + content[first + 2 :]
    for damaged in (content[: len(content) // 2], b"", b"PK", unclosed, compressed):
        path.write_bytes(damaged)
        with pytest.raises(ValueError, match=r"must be a run written by galvi\.save"):
            galvi.load(path)
    np.save(tmp_path / "array.npy", np.zeros(3))
    with pytest.raises(ValueError, match=r"must be a run written by galvi\.save"):
        galvi.load(tmp_path / "array.npy")


def test_a_momentum_that_overflows_is_a_status():
    start = galvi.problems.free_rigid_body()
    fast = start.with_initial_state(start.q0, np.full(start.v0.shape, 1e308))
    run = galvi.integrate(fast, EIGHT, 0.1, 1)
    assert not run.success and "not a finite number of radians, or above 1e100" in run.status


@pytest.mark.parametrize("name", ["kepler", "outer_solar_system", "free_rigid_body", "heavy_top"])
def test_at_no_times_there_is_no_energy(name):
    run = galvi.integrate(getattr(galvi.problems, name)(), EIGHT, 0.01, 2)
    assert galvi.energy(run, []).shape == (0,) and run([]).shape == (0, *run.q.shape[1:])


def test_a_rule_of_many_points_costs_no_more_than_its_points():
    sun = galvi.problems.solar_system()
    runs = [
        galvi.integrate(sun, galvi.Galerkin(galvi.Polynomials(8), rule), 5.0, 3)
        for rule in (galvi.composite(galvi.gauss(10), 15), galvi.gauss(40))
    ]
    assert np.allclose(runs[0].q, runs[1].q, rtol=0, atol=1e-12)


def test_a_run_that_went_wrong_without_failing_says_so():
    """e = 0.99 in 101 steps a period: solved, finite, and off by 25 semi-major axes."""
    problem = galvi.problems.kepler(0.99)
    method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    wrong = galvi.integrate(problem, method, 2 * np.pi / 101, 101)
    assert wrong.success and "the energy changed by " in wrong.outcome.reason
    right = galvi.integrate(problem, method, 2 * np.pi / 10001, 10001, save_every=10001)
    assert wrong.outcome.end is galvi.End.DOUBTFUL and right.outcome.end is galvi.End.COMPLETED
    pair = galvi.NBody([1.0, 1e-3])
    passage = galvi.Problem(pair, [[0.0, 0.0], [0.01, 0.0]], [[0.0, 0.0], [0.0, 14.1]])
    assert "energy changed" in galvi.integrate(passage, method, 2 * np.pi / 101, 101).status


def test_whole_numbers_beyond_64_bits_are_an_array():
    assert galvi.Problem(KEPLER.system, [10**30, 1], [0, 1]).q0.tolist() == [1e30, 1.0]

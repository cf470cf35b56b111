"""Runs on groups: orders, the two kernels, conserved quantities, curves, statuses, bad input."""

import time
from dataclasses import replace

import numba
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import solve_ivp
from scipy.spatial.transform import Rotation

import galvi
from galvi import group_calls
from galvi.charts import CHARTS
from galvi.systems.differences import WEIGHTS
from references.free_top import FREE_TOP
from tests.galvi.group_matrices import cross_matrix, element, title

CAYLEY, EXPONENTIAL = CHARTS
FREE, PENDULUM = galvi.problems.free_rigid_body(), galvi.problems.pendulum_3d()
FLYING = galvi.problems.free_body_se3(g=(0.0, 0.5, -9.81))


def collocation(degree, chart=CAYLEY):
    return galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree), chart)


def hall(n, chart=CAYLEY):
    """H's method with n control points."""
    return galvi.Galerkin(galvi.Polynomials(n - 1), galvi.gauss(n), chart)


MASSES = np.array([[1.0, 0.3, 0, 0], [0.3, 1.2, 0, 0], [0, 0, 1.5, 0], [0, 0, 0, 2.0]])


def coupled_function(q, v):
    """A pendulum on SO(2) and a body on SO(3), coupled in both energies; q has 4 + 9 entries."""
    return 0.5 * np.sum(v * (MASSES @ v)) + 0.5 * q[2] + q[0] * q[8] - 0.5 * q[12] ** 2


def coupled_slopes(q, v):
    out = np.zeros(17)
    out[:4] = MASSES @ v
    out[4], out[4 + 2], out[4 + 8], out[4 + 12] = q[8], 0.5, q[0], -q[12]
    return out


PAIR = galvi.Product((galvi.SO2(), galvi.SO3()))
COUPLED = galvi.Problem(
    galvi.Lagrangian(coupled_function, PAIR, numba.njit(coupled_slopes)),
    element(PAIR, [0.4, 0.1, -0.7, 0.3]),
    [1.0, 0.3, -0.5, 0.2],
    name="pendulum and body",
)
ALL = [FREE, PENDULUM, galvi.problems.heavy_top(), FLYING, COUPLED]
each_chart = pytest.mark.parametrize("chart", CHARTS, ids=title)


def same(one, two):
    return np.array_equal(one.q, two.q) and np.array_equal(one.p, two.p)


def right_side(problem):
    """R' = R hat(v), p' = p x v + torque."""
    system = problem.system
    inverse, gravity = np.linalg.inv(system.inertia), system.potential

    def right(t, y):
        R, p = y[:9].reshape(3, 3), y[9:]
        v = inverse @ p
        torque = (
            0.0 if gravity is None else gravity.mass * np.cross(gravity.centre, R.T @ gravity.g)
        )
        return np.concatenate([(R @ cross_matrix(v)).ravel(), np.cross(p, v) + torque])

    return right


def by_scipy(problem, length):
    """R and p at the end."""
    start = np.concatenate([problem.q0.ravel(), problem.p0])
    y = solve_ivp(right_side(problem), (0, length), start, "DOP853", rtol=3e-14, atol=1e-15).y[
        :, -1
    ]
    return y[:9].reshape(3, 3), y[9:]


LENGTH = 4.0
SWUNG = by_scipy(PENDULUM, LENGTH)
CLOSED = FREE_TOP.run(FREE, LENGTH, {"samples": 1})
TURNED = CLOSED.q[-1], CLOSED.p[-1]


def error(run, truth):
    R, p = truth
    return max(np.abs(run.q[-1] - R).max(), np.abs(run.p[-1] - p).max() / np.abs(p).max())


def slope(problem, truth, method, lowest, highest):
    """Least-squares slope of the end-point error over the step."""
    counts = np.unique(np.geomspace(lowest, highest, 6).round().astype(int))
    errors = []
    for steps in counts.tolist():
        run = galvi.integrate(problem, method, LENGTH / steps, steps, save_every=steps)
        assert run.success, run.status
        errors.append(error(run, truth))
    return np.polyfit(np.log(LENGTH / counts), np.log(errors), 1)[0]


# Steps in LENGTH between which errors are asymptotic and far above rounding.
WINDOWS = {2: (32, 128), 3: (24, 64), 4: (17, 32), 5: (12, 18)}


@each_chart
@pytest.mark.parametrize("degree", WINDOWS)
@pytest.mark.parametrize("more", [0, 1], ids=["packed", "H's"])
def test_the_order_is_twice_the_degree_no_less_and_no_more(degree, more, chart):
    """n = degree + 1 of H is 3 to 6; against scipy, on the pendulum."""
    rule = galvi.gauss(degree + more)
    method = galvi.Galerkin(galvi.Polynomials(degree), rule, chart)
    assert method.order == 2 * degree
    measured = slope(PENDULUM, SWUNG, method, *WINDOWS[degree])
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured  # off by 0.4 at most, at 10


@pytest.mark.parametrize(
    ("degree", "chart", "window"),
    [
        (2, CAYLEY, (48, 200)), (3, CAYLEY, (24, 64)), (4, CAYLEY, (36, 56)), (5, CAYLEY, (20, 28)),
        (2, EXPONENTIAL, (48, 200)), (3, EXPONENTIAL, (32, 64)), (4, EXPONENTIAL, (18, 26)),
    ],
)  # fmt: skip
def test_the_order_is_so_too_against_the_closed_form_of_the_free_body(degree, chart, window):
    measured = slope(FREE, TURNED, collocation(degree, chart), *window)
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured


def test_halls_method_at_half_a_unit_reaches_1e_12():
    """n = 12, h = 0.5, T = 5 (H fig. 3.1; claim L2)."""
    truth = FREE_TOP.run(FREE, 5.0, {"samples": 1})
    found = {n: error(galvi.integrate(FREE, hall(n), 0.5, 10), (truth.q[-1], truth.p[-1]))
             for n in (6, 8, 10, 12)}  # fmt: skip
    assert found[12] < 1e-12  # 6e-14
    assert found[10] < 1e-10 and found[8] < 1e-7 and found[6] > 1e-6  # 3e-11, 2e-8, 2e-5


@each_chart
@pytest.mark.parametrize("problem", [FREE, PENDULUM], ids=title)
@pytest.mark.parametrize("stages", range(1, 25))
def test_the_packed_kernel_is_the_general_one_to_round_off(problem, chart, stages):
    method, step = collocation(stages, chart), min(0.2, 0.08 * stages**0.5)
    packed = galvi.integrate(problem, method, step, 12)
    general = galvi.integrate(problem, method, step, 12, solver="newton")
    assert packed.counts["linear_solves"] == 0 < general.counts["linear_solves"]
    size, close = np.abs(packed.p).max(), 1e-14  # 2e-15
    assert np.allclose(packed.q, general.q, rtol=0.0, atol=close)
    assert np.allclose(packed.p, general.p, rtol=0.0, atol=close * size)
    t = np.linspace(0.0, 11.99 * step, 50)
    assert np.allclose(packed(t), general(t), rtol=0.0, atol=close)
    assert np.allclose(packed.velocity(t), general.velocity(t), rtol=0.0, atol=1e-13 * size)
    every = galvi.integrate(problem, method, step, 12, save_every=5, curves=True)
    assert same_rows(every, packed, [0, 5, 10, 12])
    assert np.array_equal(every(t), packed(t))


@each_chart
@pytest.mark.parametrize("momentum", [0.0, 1e-30, 1e-12, -1e-3])
def test_a_body_at_rest_begins_to_fall_in_both_kernels(momentum, chart):
    leaning = Rotation.from_rotvec([0.3, -0.8, 0.5]).as_matrix()
    for problem in (PENDULUM, FREE):
        resting = problem.starting_at(leaning, [momentum, 0.0, 0.0])
        for stages in (1, 2, 5, 8):
            method = collocation(stages, chart)
            packed = galvi.integrate(resting, method, 0.1, 8)
            general = galvi.integrate(resting, method, 0.1, 8, solver="newton")
            size = np.abs(general.p).max()
            assert np.allclose(packed.q, general.q, rtol=0.0, atol=1e-14)
            assert np.allclose(packed.p, general.p, rtol=0.0, atol=1e-13 * size)
            assert packed.counts["linear_solves"] == 0
            assert (np.abs(packed.p[1]).max() > 0.1) == (problem is PENDULUM)


def same_rows(thin, full, rows):
    return np.array_equal(thin.q, full.q[rows]) and np.array_equal(thin.p, full.p[rows])


@pytest.mark.parametrize("problem", ALL, ids=title)
@pytest.mark.parametrize("method", [collocation(4), hall(5, EXPONENTIAL)], ids=["square", "H's"])
def test_a_run_in_parts_and_from_a_file_is_one_long_run_to_the_bit(problem, method, tmp_path):
    whole = galvi.integrate(problem, method, 0.11, 40)
    part = galvi.integrate(problem, method, 0.11, 23, save_every=4)
    rest = galvi.resume(part, 17)
    assert np.array_equal(rest.q, whole.q[23:]) and np.array_equal(rest.p, whole.p[23:])
    assert np.array_equal(rest.t, whole.t[23:])
    assert np.allclose(rest(rest.t[3] + 0.05), whole(rest.t[3] + 0.05), rtol=0.0, atol=1e-13)
    galvi.save(galvi.integrate(problem, method, 0.11, 23), tmp_path / "run.npz")
    given_again = {"problem": problem} if isinstance(problem.system, galvi.Lagrangian) else {}
    loaded = galvi.load(tmp_path / "run.npz", **given_again)
    assert loaded.method == method
    assert np.array_equal(galvi.resume(loaded, 17).q, whole.q[23:])
    assert np.array_equal(loaded(1.234), whole(1.234))
    assert np.array_equal(loaded.velocity(1.234), whole.velocity(1.234))


def test_a_saved_lagrangian_asks_for_its_problem(tmp_path):
    galvi.save(galvi.integrate(COUPLED, collocation(3), 0.1, 3), tmp_path / "run.npz")
    with pytest.raises(ValueError, match=r"needs its problem, because .* use galvi.load\(path, pr"):
        galvi.load(tmp_path / "run.npz")


@pytest.mark.parametrize("problem", ALL, ids=title)
def test_backwards_undoes_forwards_for_degree_one_in_the_exponential_chart(problem):
    """exp(-x) exp((1 - tau) x) = exp(-tau x): the same curve from its other end."""
    for method in (collocation(1, EXPONENTIAL), hall(2, EXPONENTIAL)):
        assert galvi.round_trip_error(problem, method, 0.02, 100) < 2e-13  # 6e-14, while falling
    back = galvi.integrate(problem, method, -0.02, 10)
    assert back.success and back.t[-1] == -0.2


@each_chart
@pytest.mark.parametrize("more", [0, 1], ids=["packed", "H's"])
@pytest.mark.parametrize("problem", [PENDULUM, galvi.problems.heavy_top(), FLYING], ids=title)
def test_backwards_undoes_forwards_to_one_order_more_than_that_of_the_method(problem, more, chart):
    for degree, counts in ((2, (64, 128)), (3, (45, 64))):
        method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + more), chart)
        errors = [galvi.round_trip_error(problem, method, LENGTH / n, n) for n in counts]
        measured = np.log(errors[0] / errors[1]) / np.log(counts[1] / counts[0])
        assert 2 * degree + 0.5 < measured < 2 * degree + 1.5, measured


@pytest.mark.parametrize("problem", ALL, ids=title)
@pytest.mark.parametrize(
    "method", [collocation(1), collocation(3, EXPONENTIAL), hall(4)], ids=["1", "3", "H's"]
)
def test_every_step_is_symplectic_in_left_trivialisation(problem, method):
    assert galvi.symplecticity_defect(problem, method, 0.1) < 2e-11


@each_chart
@pytest.mark.parametrize("method", [collocation, hall])
@given(turn=st.lists(st.floats(-3.0, 3.0), min_size=3, max_size=3))
def test_a_body_that_starts_turned_moves_turned(method, chart, turn):
    Q = Rotation.from_rotvec(turn).as_matrix()
    gravity = PENDULUM.system.potential
    field = galvi.UniformGravity(gravity.mass, gravity.centre, Q @ gravity.g)
    heavy = galvi.Problem(
        galvi.RigidBody(PENDULUM.system.inertia, field), Q @ PENDULUM.q0, PENDULUM.v0
    )
    for problem, turned in ((FREE, FREE.starting_at(Q @ FREE.q0, FREE.v0)), (PENDULUM, heavy)):
        one, two = (galvi.integrate(p, method(5, chart), 0.2, 12) for p in (problem, turned))
        assert np.allclose(two.q, Q @ one.q, rtol=0.0, atol=2e-14)
        assert np.allclose(two.p, one.p, rtol=0.0, atol=2e-13)


@each_chart
@pytest.mark.parametrize("method", [collocation, hall])
def test_momentum_energy_and_the_rotation_stay(method, chart):
    steps = 200_000 if method is collocation else 3000
    run = galvi.integrate(FREE, method(6, chart), 0.2, steps, save_every=steps // 100)
    spatial, energy = galvi.momentum_map(run), galvi.energy(run)
    size = np.linalg.norm(spatial[0])
    assert np.abs(spatial - spatial[0]).max() < 1e-13 * size  # 6e-16 packed, 1.5e-14 with Newton
    assert galvi.orthogonality_defect(run).max() < 2e-15
    off = energy / energy[0] - 1.0
    drift = np.polyfit(np.arange(101) * (steps // 100), off, 1)[0]
    # What rounding leaves in a step is not quite random: 1.0e-17 a step, packed, Cayley.
    assert abs(drift) < (3e-17 if method is collocation else 3e-16)
    assert np.abs(off).max() < 1e-11


@each_chart
def test_the_energy_of_a_swinging_body_has_an_error_that_does_not_grow(chart):
    run = galvi.integrate(PENDULUM, collocation(4, chart), 0.25, 20_000)
    off = np.abs(galvi.energy(run) / galvi.energy(run)[0] - 1.0)
    first, last = off[:2000].max(), off[-2000:].max()
    assert 1e-12 < first < 1e-6 and last < 2.0 * first  # 6e-8 and 1e-11 or so


@pytest.mark.slow
def test_a_million_steps_leave_the_momentum_and_the_rotation_at_round_off():
    run = galvi.integrate(FREE, collocation(10), 0.2, 1_000_000, save_every=1000)
    spatial = galvi.momentum_map(run)
    off = np.linalg.norm(spatial - spatial[0], axis=1) / np.linalg.norm(spatial[0])
    assert off.max() < 1e-13 and galvi.orthogonality_defect(run).max() < 1e-13
    assert off[-100:].max() < 10.0 * np.sqrt(10.0) * off[50:150].max()


@pytest.mark.parametrize("problem", ALL, ids=title)
@each_chart
def test_the_curve_goes_through_the_steps_without_a_gap(problem, chart):
    run = galvi.integrate(problem, collocation(5, chart), 0.1, 20)
    size = np.abs(run.q).max()
    assert np.allclose(run(run.t), run.q, rtol=0.0, atol=1e-14 * size)
    before = np.nextafter(run.t[1:], 0.0)
    assert np.allclose(run(before), run.q[1:], rtol=0.0, atol=3e-14 * size)
    t = np.linspace(0.0, 2.0, 33)
    group = problem.system.group
    for g in run(t):
        group.check("g", g)
    assert run(t).shape == (33, *group.shape) and run.velocity(t).shape == (33, group.dimension)
    assert run(0.3).shape == group.shape and run.velocity(0.3).shape == (group.dimension,)


@pytest.mark.parametrize("problem", [PENDULUM, FLYING], ids=title)
@each_chart
@given(where=st.floats(0.15, 0.85), step=st.integers(0, 9))
def test_the_velocity_is_the_slope_of_the_curve(problem, chart, where, step):
    run = galvi.integrate(problem, collocation(6, chart), 0.2, 10)
    t, nudge = 0.2 * (step + where), 0.2 * 2.0**-5
    slope = sum(
        weight / nudge * (run(t + k * nudge) - run(t - k * nudge))
        for k, weight in enumerate(WEIGHTS, start=1)
    )
    body = np.linalg.inv(run(t)) @ slope
    v = run.velocity(t)
    assert np.allclose(body[:3, :3], cross_matrix(v[:3]), rtol=0.0, atol=1e-8)
    assert np.allclose(body[:3, 3:].ravel(), v[3:], rtol=0.0, atol=1e-7)


@pytest.mark.parametrize("method", [collocation(6), hall(7)], ids=["packed", "H's"])
def test_a_step_that_leaves_the_chart_says_by_how_much_and_what_would_do(method):
    """The free body is 3.486 radians away from its start before it comes nearer again."""
    run = galvi.integrate(FREE, method, 1.2, 5)
    assert not run.success and run.failed_step == 1 and run.counts["steps"] == 0
    assert run.status == (
        "Stopped at step 1 of 5, from t = 0: the step turns by 3.486 radians, and the chart Cayley "
        "ends at 3.142. Use a step of at most 0.54, or chart=galvi.Exponential(), which ends at 2 "
        "pi."
    )
    assert np.array_equal(run.q[0], FREE.q0)
    assert np.isnan(run.q[1:]).all() and np.isnan(run.p[1:]).all() and np.isnan(run(0.1)).all()
    with pytest.raises(ValueError, match="a run that failed cannot be resumed"):
        galvi.resume(run, 3)
    with pytest.raises(ValueError, match="the run failed, and its states past the failure are NaN"):
        galvi.rotations(run)
    assert galvi.integrate(FREE, method, 0.54, 5).success
    other = galvi.integrate(FREE, galvi.Galerkin(method.space, method.rule, EXPONENTIAL), 1.2, 5)
    truth = FREE_TOP.run(FREE, 6.0, {"samples": 1})
    assert other.success and error(other, (truth.q[-1], truth.p[-1])) < 1e-2


def test_a_run_may_leave_the_chart_later_and_keeps_what_was_computed():
    """Upside down, the pendulum starts slowly and comes down fast."""
    problem = galvi.problems.pendulum_3d(weight=25.0, inverted=True)
    run = galvi.integrate(problem, collocation(8), 0.6, 60)
    assert not run.success and run.failed_step > 2
    assert run.status.startswith(f"Stopped at step {run.failed_step} of 60, from t = ")
    assert "radians" in run.status
    done = run.failed_step
    assert np.isfinite(run.q[:done]).all() and np.isnan(run.q[done:]).all()
    assert np.isfinite(run(0.6 * (done - 1))).all() and np.isnan(run(0.6 * done - 0.1)).all()
    assert np.isfinite(galvi.energy(run)[:done]).all() and np.isnan(galvi.energy(run)[done:]).all()
    assert np.isnan(galvi.orthogonality_defect(run)[done:]).all()


@each_chart
@pytest.mark.parametrize("problem", ALL, ids=title)
def test_huge_steps_end_at_once_in_a_status(problem, chart):
    clock = time.perf_counter()
    for step in (1e2, 1e10, 1e100, -1e300):
        run = galvi.integrate(problem, collocation(4, chart), step, 1000)
        assert not run.success and run.status.endswith(".")
        assert run.failed_step is not None and np.isnan(run.q[run.failed_step :]).all()
    assert time.perf_counter() - clock < 10.0  # 0.1 s


def test_counts_are_the_same_in_every_run():
    for problem in ALL:
        runs = [galvi.integrate(problem, collocation(4), 0.1, 50) for _ in range(2)]
        assert runs[0].counts == runs[1].counts and same(*runs)
        assert runs[0].counts["steps"] == 50
        assert runs[0].counts["force_evaluations"] >= 4 * runs[0].counts["iterations"]


@given(steps=st.integers(1, 20), save_every=st.integers(1, 25))
def test_what_is_kept_is_every_kth_step_and_the_last(steps, save_every):
    for problem, method in ((PENDULUM, collocation(3)), (FREE, hall(3))):
        full = galvi.integrate(problem, method, 0.1, steps)
        thin = galvi.integrate(problem, method, 0.1, steps, save_every=save_every)
        kept = sorted({*range(0, steps, save_every), steps})
        assert same_rows(thin, full, kept) and np.array_equal(thin.t, full.t[kept])
        assert (thin.curves is None) == (save_every > 1)


def test_many_at_once_are_those_of_one_by_one():
    rng = np.random.default_rng(3)
    problems = [FREE.starting_at(FREE.q0, v) for v in rng.normal(size=(8, 3))]
    problems += [PENDULUM, FLYING, COUPLED]
    for threads in (1, 3):
        many = galvi.integrate_many(problems, collocation(4), 0.1, 60, threads=threads)
        for problem, run in zip(problems, many, strict=True):
            assert same(run, galvi.integrate(problem, collocation(4), 0.1, 60))


@each_chart
@pytest.mark.parametrize("problem", [FREE, PENDULUM], ids=title)
def test_fixed_point_iteration_alone_is_what_its_name_says(problem, chart):
    runs = [galvi.integrate(problem, collocation(6, chart), 0.2, 30, solver=solver)
            for solver in ("auto", "fixed_point")]  # fmt: skip
    assert same(*runs) and runs[0].counts == runs[1].counts
    run = galvi.integrate(problem, collocation(6, chart), 1.05, 30)
    alone = galvi.integrate(problem, collocation(6, chart), 1.05, 30, solver="fixed_point")
    assert alone.counts["linear_solves"] == 0
    if not alone.success and run.success:
        assert "Newton" not in alone.status
        ends = "or chart=galvi.Exponential(), which ends at 2 pi."
        assert alone.status.endswith(ends if chart is CAYLEY else "or the solver auto.")
    assert (problem is FREE) == (not alone.success)


@pytest.mark.parametrize(
    ("problem", "method"),
    [
        (FLYING, collocation(4)),
        (COUPLED, collocation(4)),
        (FREE, hall(4)),
        (FREE.starting_at(FREE.q0, FREE.v0), hall(4, EXPONENTIAL)),
        (galvi.Problem(galvi.RigidBody((1, 1, 1), lambda R: 0.0), np.eye(3), np.ones(3)),
         collocation(4)),
    ],
)  # fmt: skip
def test_fixed_point_iteration_is_refused_where_there_is_none(problem, method):
    for call in (
        galvi.integrate,
        lambda p, *rest, **more: galvi.integrate_many([p], *rest, **more),
    ):
        with pytest.raises(ValueError, match=r"the solver fixed_point is for a RigidBo"):
            call(problem, method, 0.1, 3, solver="fixed_point")


def test_attitudes_come_as_scipys_rotations():
    run = galvi.integrate(PENDULUM, collocation(6), 0.2, 10)
    turns = galvi.rotations(run)
    assert np.allclose(turns.as_matrix(), run.q, rtol=0.0, atol=1e-15)
    assert galvi.rotations(run, 0.33).as_quat().shape == (4,)
    assert np.allclose(galvi.rotations(run, [0.3]).as_matrix()[0], run(0.3), rtol=0.0, atol=1e-15)
    assert np.all(galvi.orthogonality_defect(run, np.linspace(0.0, 2.0, 30)) < 4e-15)
    assert galvi.orthogonality_defect(run).shape == (11,)
    flown = galvi.integrate(FLYING, collocation(6), 0.1, 10)
    assert np.allclose(galvi.rotations(flown).as_matrix(), flown.q[:, :3, :3], atol=1e-15)
    assert galvi.orthogonality_defect(flown).max() < 1e-15


@pytest.mark.parametrize("ask", [galvi.rotations, galvi.orthogonality_defect])
def test_attitudes_of_what_has_none_are_refused(ask):
    for problem in (galvi.problems.kepler(0.1), COUPLED):
        run = galvi.integrate(problem, collocation(3), 0.1, 3)
        with pytest.raises(
            ValueError, match=r"attitudes need a run on SO\(3\) or SE\(3\), such as"
        ):
            ask(run)
    thin = galvi.integrate(FREE, collocation(3), 0.1, 9, save_every=3)
    with pytest.raises(ValueError, match="no curves to evaluate"):
        ask(thin, 0.2)


def test_momenta_are_those_of_the_definition():
    run = galvi.integrate(FREE, collocation(6), 0.2, 10)
    by_hand = np.array([R @ p for R, p in zip(run.q, run.p, strict=True)])
    assert np.allclose(galvi.momentum_map(run), by_hand, rtol=0.0, atol=1e-14)
    t = [0.1, 1.7]
    v = run.velocity(t)
    energy = 0.5 * np.sum(v * (v @ FREE.system.inertia), axis=1)
    assert np.allclose(galvi.energy(run, t), energy, rtol=1e-14)
    flown = galvi.integrate(FLYING, collocation(6), 0.1, 10)
    assert galvi.linear_momentum(flown).shape == (11, 3)
    for refused, message in ((galvi.linear_momentum, run), (galvi.momentum_map, None)):
        other = message or galvi.integrate(COUPLED, collocation(3), 0.1, 3)
        with pytest.raises(ValueError, match="moment"):
            refused(other)


def test_a_recommendation_for_a_pendulum_is_kept():
    found = galvi.recommend(PENDULUM, 1e-8, 4.0, degrees=(4, 6), by="evaluations", budget=2e5)
    assert found.reached, found.status
    run = galvi.integrate(PENDULUM, found.method, found.step, found.steps)
    assert np.linalg.norm(run.q[-1] - SWUNG[0], axis=-1).max() < 1e-8


def spoiled(method, **changes):
    """The same method with some arrays of its table multiplied."""
    # another name for the rule makes another key for what is kept of tables
    rule = replace(method.rule, name=f"{method.rule.name} {changes}")
    wrong = galvi.Galerkin(method.space, rule, method.chart)
    arrays = {name: getattr(wrong.table, name) * factor for name, factor in changes.items()}
    vars(wrong)["table"] = replace(wrong.table, **arrays)
    return wrong


def test_a_spoiled_table_is_caught_by_the_order():
    good, bent = hall(4), spoiled(hall(4), slope=1.0 + 1e-6 * np.arange(3))
    assert slope(PENDULUM, SWUNG, good, *WINDOWS[3]) > 5.5
    assert slope(PENDULUM, SWUNG, bent, *WINDOWS[3]) < 5.0
    square = spoiled(collocation(3), integral=1.0 + 1e-6 * np.arange(9).reshape(3, 3))
    assert slope(PENDULUM, SWUNG, square, *WINDOWS[3]) < 5.0


def test_forces_that_do_not_belong_to_the_moves_are_caught_by_symplecticity(monkeypatch):
    """Any table makes a variational method; one without B_jk = b_k - A_kj b_k / b_j does not."""
    sound = group_calls.collocation_tables

    def mismatched(table, step):
        moves, turns, *others = sound(table, step)
        return (moves, turns * (1.0 + 1e-5 * np.arange(turns.shape[1])), *others)

    assert galvi.symplecticity_defect(PENDULUM, collocation(3), 0.2) < 2e-12  # 4e-15
    monkeypatch.setattr(group_calls, "collocation_tables", mismatched)
    assert galvi.symplecticity_defect(PENDULUM, collocation(3), 0.2) > 1e-9


def test_a_wrong_torque_is_caught_by_the_truth_and_by_the_energy():
    weight = -PENDULUM.system.potential.numbers[2]
    gradient = np.zeros((3, 3))
    gradient[2, 2] = weight
    for factor in (1.0, 1.0 + 1e-6):
        system = galvi.RigidBody(
            PENDULUM.system.inertia, PENDULUM.system.potential, lambda R, f=factor: f * gradient
        )
        problem = galvi.Problem(system, PENDULUM.q0, PENDULUM.v0)
        run = galvi.integrate(problem, collocation(8), 0.2, 20)
        sound = factor == 1.0
        assert (error(run, SWUNG) < 1e-12) == sound
        assert (np.ptp(galvi.energy(run)) < 1e-11) == sound

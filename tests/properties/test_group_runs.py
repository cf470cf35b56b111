"""Runs on groups: curves, saved states, attitudes, momenta, failures and orders."""

import time
from itertools import cycle

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

import galvi
from benchmarks.measures.matrix_group import MatrixGroup
from galvi.charts import CHARTS
from galvi.run.in_lanes import lagrangian as law_stepper
from galvi.systems.finite_differences import WEIGHTS
from references.closed_forms.top_motion import FREE_TOP
from tests.properties.group_matrices import title
from tests.properties.group_motions import (
    ALL,
    CAYLEY,
    COUPLED,
    EXPONENTIAL,
    FLYING,
    FREE,
    PENDULUM,
    RODRIGUES,
    WINDOWS,
    collocation,
    each_chart,
    end_error,
    free_body_end,
    hall,
    measured_order,
    pendulum_end,
    same,
    same_rows,
    with_scaled_table,
)

KEPLER = galvi.problems.kepler(0.6)
EXPONENTIAL_REMEDY = "chart=galvi.Exponential(), which ends at 2 pi"


@pytest.mark.parametrize("problem", [PENDULUM, FLYING], ids=title)
@each_chart
def test_the_velocity_is_the_slope_of_the_curve(problem, chart):
    run = galvi.integrate(problem, collocation(6, chart), 0.2, 10)
    t, nudge = 0.2 * (np.arange(10) + np.linspace(0.15, 0.85, 10)), 0.2 * 2.0**-5
    derivative = sum(
        weight / nudge * (run(t + k * nudge) - run(t - k * nudge))
        for k, weight in enumerate(WEIGHTS, start=1)
    )
    body = np.linalg.solve(run(t), derivative)
    expected = MatrixGroup(problem.system.group).hat(run.velocity(t))
    assert np.allclose(body[:, :, :3], expected[:, :, :3], rtol=0.0, atol=1e-8)
    assert np.allclose(body[:, :, 3:], expected[:, :, 3:], rtol=0.0, atol=1e-7)


@given(steps=st.integers(1, 20), save_every=st.integers(1, 25))
def test_what_is_kept_is_every_kth_step_and_the_last(steps, save_every):
    for problem, method in ((PENDULUM, collocation(3)), (FREE, hall(3)), (KEPLER, collocation(4))):
        full = galvi.integrate(problem, method, 0.1, steps)
        thin = galvi.integrate(problem, method, 0.1, steps, save_every=save_every)
        saved = sorted({*range(0, steps, save_every), steps})
        assert same_rows(thin, full, saved) and np.array_equal(thin.t, full.t[saved])
        assert (thin.curves is None) == (save_every > 1)


def test_attitudes_come_as_scipys_rotations():
    run = galvi.integrate(PENDULUM, collocation(6), 0.2, 10)
    assert np.allclose(galvi.rotations(run).as_matrix(), run.q, rtol=0.0, atol=1e-15)
    assert galvi.rotations(run, 0.33).as_quat().shape == (4,)
    assert np.allclose(galvi.rotations(run, [0.3]).as_matrix()[0], run(0.3), rtol=0.0, atol=1e-15)
    assert np.all(galvi.orthogonality_defect(run, np.linspace(0.0, 2.0, 30)) < 4e-15)
    flown = galvi.integrate(FLYING, collocation(6), 0.1, 10)
    assert np.allclose(galvi.rotations(flown).as_matrix(), flown.q[:, :3, :3], atol=1e-15)
    thin = galvi.integrate(PENDULUM, collocation(6), 0.2, 10, save_every=3)
    for diagnostic in (galvi.rotations, galvi.orthogonality_defect):  # between the kept steps too
        assert repr(diagnostic(thin, 0.3)) == repr(diagnostic(run, 0.3))


def test_the_remedy_of_refused_attitudes_works():
    run = galvi.integrate(COUPLED, collocation(3), 0.1, 3)
    plane, space = run.problem.system.group.parts(run.q)
    assert np.allclose(Rotation.from_matrix(space).as_matrix(), space, rtol=0.0, atol=1e-14)
    assert np.arctan2(plane[0, 1, 0], plane[0, 0, 0]) == pytest.approx(0.4)
    assert galvi.orthogonality_defect(run).max() < 1e-15


def test_momenta_and_energy_are_those_of_the_definition():
    run = galvi.integrate(FREE, collocation(6), 0.2, 10)
    by_hand = np.array([R @ p for R, p in zip(run.q, run.p, strict=True)])
    assert np.allclose(galvi.momentum_map(run), by_hand, rtol=0.0, atol=1e-14)
    v = run.velocity([0.1, 1.7])
    energy = 0.5 * np.sum(v * (v @ FREE.system.inertia), axis=1)
    assert np.allclose(galvi.energy(run, [0.1, 1.7]), energy, rtol=1e-14)


@pytest.mark.parametrize("method", [collocation(6), hall(7)], ids=["packed", "H's"])
def test_a_step_that_leaves_the_chart_says_by_how_much_and_what_would_do(method):
    """The attitude of the free body differs from that at the start by up to 3.486 radians."""
    run = galvi.integrate(FREE, method, 1.2, 5)
    assert run.outcome.end is galvi.End.STEP_FAILED and run.failed_step == 1
    assert run.counts["steps"] == 0 and "turns by 3.486 radians" in run.outcome.reason
    assert "at most 0.54" in run.status and EXPONENTIAL_REMEDY in run.status
    assert np.array_equal(run.q[0], FREE.q0)
    assert np.isnan(run.q[1:]).all() and np.isnan(run.p[1:]).all() and np.isnan(run(0.1)).all()
    with pytest.raises(ValueError, match="a run that failed cannot be resumed"):
        galvi.resume(run, 3)
    with pytest.raises(ValueError, match="the run failed, and its states past the failure are NaN"):
        galvi.rotations(run)
    assert galvi.integrate(FREE, method, 0.54, 5).success
    exponential = galvi.integrate(
        FREE, galvi.Galerkin(method.space, method.rule, EXPONENTIAL), 1.2, 5
    )
    truth = FREE_TOP.run(FREE, 6.0, {"samples": 1})
    assert exponential.success and end_error(exponential, (truth.q[-1], truth.p[-1])) < 1e-2


def test_a_run_may_leave_the_chart_later_and_keeps_what_was_computed():
    """Upside down, the pendulum starts slowly and comes down fast."""
    problem = galvi.problems.pendulum_3d(weight=25.0, inverted=True)
    run = galvi.integrate(problem, collocation(8), 0.6, 60)
    first_failed = run.failed_step
    assert run.outcome.end is galvi.End.STEP_FAILED and first_failed > 2
    assert "radians" in run.outcome.reason
    assert np.isfinite(run.q[:first_failed]).all() and np.isnan(run.q[first_failed:]).all()
    assert (
        np.isfinite(run(0.6 * (first_failed - 1))).all()
        and np.isnan(run(0.6 * first_failed - 0.1)).all()
    )
    assert (
        np.isfinite(galvi.energy(run)[:first_failed]).all()
        and np.isnan(galvi.energy(run)[first_failed:]).all()
    )
    assert np.isnan(galvi.orthogonality_defect(run)[first_failed:]).all()


@pytest.mark.slow_cases("pendulum and body-Exponential")
@pytest.mark.parametrize(
    ("problem", "chart"), list(zip(ALL, cycle(CHARTS), strict=False)), ids=title
)
def test_huge_steps_end_at_once(problem, chart):
    start_seconds = time.process_time()
    for step in (1e2, 1e10, 1e100, -1e300):
        run = galvi.integrate(problem, collocation(4, chart), step, 1000)
        assert run.outcome.end is galvi.End.STEP_FAILED
        assert np.isnan(run.q[run.failed_step :]).all()
    assert time.process_time() - start_seconds < 10.0  # 0.1 s


@each_chart
@pytest.mark.parametrize("problem", [FREE, PENDULUM], ids=title)
def test_fixed_point_iteration_alone_is_what_its_name_says(problem, chart):
    runs = [
        galvi.integrate(problem, collocation(6, chart), 0.2, 30, solver=solver)
        for solver in ("auto", "fixed_point")
    ]
    assert same(*runs) and runs[0].counts == runs[1].counts
    run = galvi.integrate(problem, collocation(6, chart), 1.05, 30)
    fixed_point = galvi.integrate(problem, collocation(6, chart), 1.05, 30, solver="fixed_point")
    assert fixed_point.counts["linear_solves"] == 0
    if not fixed_point.success and run.success:
        assert "Newton" not in fixed_point.status
        assert (EXPONENTIAL_REMEDY if chart == CAYLEY else "the solver auto") in fixed_point.status
    assert (problem is FREE and chart != RODRIGUES) == (not fixed_point.success)


# ---------------------------------------------------------------- orders


@each_chart
@pytest.mark.parametrize("degree", WINDOWS)
def test_the_order_is_twice_the_degree_no_less_and_no_more(degree, chart):
    """With as many points as the degree, or one more as in H for n = 3 to 6, against scipy."""
    extra_points = (degree + CHARTS.index(chart)) % 2
    method = galvi.Galerkin(galvi.Polynomials(degree), galvi.gauss(degree + extra_points), chart)
    assert method.order == 2 * degree
    measured = measured_order(PENDULUM, pendulum_end(), method, *WINDOWS[degree])
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured  # off by 0.4 at most, at 10


@pytest.mark.parametrize(
    ("degree", "chart", "step_counts"),
    [
        (2, RODRIGUES, (48, 200)),
        (3, CAYLEY, (24, 64)),
        (4, EXPONENTIAL, (18, 26)),
        (5, CAYLEY, (20, 28)),
    ],
)
def test_the_order_is_so_too_against_the_closed_form_of_the_free_body(degree, chart, step_counts):
    measured = measured_order(FREE, free_body_end(), collocation(degree, chart), *step_counts)
    assert 2 * degree - 0.5 < measured < 2 * degree + 0.5, measured


@pytest.mark.slow(beside="test_the_order_is_so_too_against_the_closed_form_of_the_free_body")
def test_halls_method_at_half_a_unit_reaches_1e_12():
    """n = 12, h = 0.5, T = 5 (H fig. 3.1; claim L2)."""
    truth = FREE_TOP.run(FREE, 5.0, {"samples": 1})
    errors = {
        n: end_error(galvi.integrate(FREE, hall(n), 0.5, 10), (truth.q[-1], truth.p[-1]))
        for n in (6, 8, 10, 12)
    }
    assert errors[12] < 1e-12  # 6e-14
    assert errors[10] < 1e-10 and errors[8] < 1e-7 and errors[6] > 1e-6  # 3e-11, 2e-8, 2e-5


def test_a_spoiled_table_is_caught_by_the_order():
    good, hall_spoiled = (
        hall(4),
        with_scaled_table(hall(4), integral=1.0 + 1e-6 * np.arange(16).reshape(4, 4)),
    )
    assert measured_order(PENDULUM, pendulum_end(), good, *WINDOWS[3]) > 5.5
    assert measured_order(PENDULUM, pendulum_end(), hall_spoiled, *WINDOWS[3]) < 5.0
    collocation_spoiled = with_scaled_table(
        collocation(3), integral=1.0 + 1e-6 * np.arange(9).reshape(3, 3)
    )
    assert measured_order(PENDULUM, pendulum_end(), collocation_spoiled, *WINDOWS[3]) < 5.0


def test_forces_that_do_not_belong_to_the_moves_are_caught_by_symplecticity(monkeypatch):
    """Any table makes a variational method; one without B_jk = b_k - A_kj b_k / b_j does not."""
    tables_on_group = law_stepper.tables_on_group

    def mismatched(table, form):
        arrays, tables = tables_on_group(table, form), tables_on_group(table, form).tables.copy()
        P = tables.shape[1]
        tables[2 * P : 3 * P] *= 1.0 + 1e-5 * np.arange(P)
        return arrays._replace(tables=tables)

    assert galvi.symplecticity_defect(PENDULUM, collocation(3), 0.2) < 2e-12  # 4e-15
    monkeypatch.setattr(law_stepper, "tables_on_group", mismatched)
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
        unchanged = factor == 1.0
        assert (end_error(run, pendulum_end()) < 1e-12) == unchanged
        assert (np.ptp(galvi.energy(run)) < 1e-11) == unchanged

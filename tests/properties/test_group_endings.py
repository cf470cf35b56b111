"""How runs on groups end, and which iteration solves them."""

import time

import numpy as np
import pytest

import galvi
from references.closed_forms.top_motion import FREE_TOP
from tests.properties.group_matrices import title
from tests.properties.group_motions import (
    ALL,
    CAYLEY,
    EXPONENTIAL,
    FREE,
    PENDULUM,
    RODRIGUES,
    collocation,
    each_chart,
    error,
    hall,
    same,
)
from tests.properties.lagrangians import opaque


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


@pytest.mark.slow_cases("free rigid body-ModifiedRodrigues", "pendulum and body-ModifiedRodrigues")
@each_chart
@pytest.mark.parametrize("problem", ALL, ids=title)
def test_huge_steps_end_at_once_in_a_status(problem, chart):
    clock = time.process_time()
    for step in (1e2, 1e10, 1e100, -1e300):
        run = galvi.integrate(problem, collocation(4, chart), step, 1000)
        assert not run.success and run.status.endswith(".")
        assert run.failed_step is not None and np.isnan(run.q[run.failed_step :]).all()
    assert time.process_time() - clock < 10.0  # 0.1 s


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
        assert alone.status.endswith(ends if chart == CAYLEY else "or the solver auto.")
    assert (problem is FREE and chart != RODRIGUES) == (not alone.success)


def called(system):
    return galvi.Problem(system, np.eye(3), np.ones(3))


@pytest.mark.parametrize(
    ("problem", "method"),
    [
        (called(galvi.RigidBody((1, 1, 1), opaque(lambda R: 0.0))), collocation(4)),
        (called(galvi.RigidBody((1, 1, 1), force=opaque(lambda R, v: 0.0 * v))),
         hall(4, EXPONENTIAL)),
        (called(galvi.Lagrangian(opaque(lambda R, v: 0.5 * v @ v), galvi.SO3())), collocation(4)),
    ],
)  # fmt: skip
def test_fixed_point_iteration_is_refused_where_there_is_none(problem, method):
    for call in (
        galvi.integrate,
        lambda p, *rest, **more: galvi.integrate_many([p], *rest, **more),
    ):
        with pytest.raises(ValueError, match=r"solver fixed_point needs functions"):
            call(problem, method, 0.1, 3, solver="fixed_point")

"""Settings, and contenders in fixed steps."""

import numpy as np
import pytest

import galvi
from references.closed_forms.kepler import KEPLER
from references.setting import fixed_steps, sample_times
from references.textbook.euler import EXPLICIT_EULER, STORMER_VERLET, SYMPLECTIC_EULER
from references.textbook.fourth_order import FOREST_RUTH, RK4
from references.textbook.implicit_euler import IMPLICIT_EULER

REFUSED = [
    *((fixed_steps, {"step": step}, r"step must divide.*Choose step = duration / \d+")
      for step in (0.3, 0.1 * (1 + 5e-9), 2.0, -0.1)),
    *((fixed_steps, {"step": step}, r"step must .*received")
      for step in (0.0, float("nan"), float("inf"), "fast")),
    (fixed_steps, {}, "needs a 'step'"),
    (fixed_steps, {"step": 0.1, "save_every": 0}, "save_every must be a whole number"),
    (lambda duration, setting: sample_times(0.0, duration, setting), {"samples": 1.5},
     "samples must be a whole number"),
]  # fmt: skip


@pytest.mark.parametrize(("read", "setting", "words"), REFUSED)
def test_a_setting_that_makes_no_sense_is_refused(read, setting, words):
    with pytest.raises(ValueError, match=words):
        read(1.0, setting)


@pytest.mark.parametrize(("every", "saved"), [(4, [0, 4, 8, 10]), (5, [0, 5, 10]), (99, [0, 10])])
def test_saved_steps_hold_the_first_every_kth_and_the_last(every, saved):
    steps = fixed_steps(1.0, {"step": 0.1 * (1 + 5e-10), "save_every": every})
    assert steps.count == 10 and steps.saved.tolist() == saved


def test_times_are_those_of_the_steps_and_not_a_running_sum_and_samples_end_at_the_end():
    steps = fixed_steps(1e4, {"step": 0.1})
    assert np.array_equal(steps.times(3.0), 3.0 + np.arange(100_001) * 0.1)
    assert sample_times(1.0, -3.0, {"samples": 3}).tolist() == [1.0, 0.0, -1.0, -2.0]
    assert sample_times(0.0, 0.1, {}).tolist() == [0.0, 0.1]


METHODS = (EXPLICIT_EULER, SYMPLECTIC_EULER, IMPLICIT_EULER, STORMER_VERLET, RK4, FOREST_RUTH)
NAMES = [method.name for method in METHODS]
ORBIT = galvi.problems.kepler(0.3)


@pytest.mark.slow_cases("implicit Euler")
@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_the_order_is_what_is_claimed_and_no_more(method):
    truth = KEPLER.run(ORBIT, 1.0, {})
    steps = 1.0 / np.array([400, 800, 1600, 3200] if method.order < 3 else [20, 40, 80, 160])
    errors = [np.abs(method.run(ORBIT, 1.0, {"step": h}).q[-1] - truth.q[-1]).max() for h in steps]
    slope = np.polyfit(np.log(steps), np.log(errors), 1)[0]
    assert abs(slope - method.order) < 0.05


def test_one_step_is_the_textbook_formula():
    q, v, h = ORBIT.q0, ORBIT.v0, 0.1
    a = lambda q: ORBIT.system.acceleration(q, 0.0)  # noqa: E731
    kicked = v + h * a(q)
    drifted = q + h * v + h**2 / 2 * a(q)
    for method, q1, v1 in (
        (EXPLICIT_EULER, q + h * v, kicked),
        (SYMPLECTIC_EULER, q + h * kicked, kicked),
        (STORMER_VERLET, drifted, v + h / 2 * (a(q) + a(drifted))),
    ):
        run = method.run(ORBIT, h, {"step": h})
        np.testing.assert_allclose(run.q[-1], q1, rtol=1e-15, atol=1e-16)
        np.testing.assert_allclose(run.p[-1], v1, rtol=1e-15, atol=1e-16)
    run = IMPLICIT_EULER.run(ORBIT, h, {"step": h})
    np.testing.assert_allclose(run.q[-1], q + h * run.p[-1], rtol=1e-15)
    np.testing.assert_allclose(run.p[-1], v + h * a(run.q[-1]), rtol=1e-14)


@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_keeping_fewer_states_does_not_change_them(method):
    every = method.run(ORBIT, 1.0, {"step": 0.01})
    seventh = method.run(ORBIT, 1.0, {"step": 0.01, "save_every": 7})
    kept = [*range(0, 100, 7), 100]
    assert np.array_equal(seventh.q, every.q[kept]) and np.array_equal(seventh.t, every.t[kept])


def test_a_long_run_is_the_same_whether_or_not_it_is_cut_into_calls(monkeypatch):
    whole = STORMER_VERLET.run(ORBIT, 1.0, {"step": 0.001})
    monkeypatch.setattr("references.textbook.nystrom.CHUNK", 7)
    assert np.array_equal(STORMER_VERLET.run(ORBIT, 1.0, {"step": 0.001}).q, whole.q)


def raises(q):
    if q[0] < 0.9:
        raise ZeroDivisionError("no force here")
    return q


def ends(q):
    return q if q[0] > 0.9 else q * np.nan


def pulled(gradient):
    """A spring with this force."""
    system = galvi.Canonical(1.0, lambda q: 0.0, gradient, lambda q: np.eye(1), check=False)
    return galvi.Problem(system, [1.0], [0.0])


@pytest.mark.parametrize("method", METHODS, ids=NAMES)
def test_a_force_that_raises_stops_the_run_and_one_that_turns_nan_ends_it(method):
    setting = {"step": 0.01, "save_every": 3}
    with pytest.raises(ZeroDivisionError, match="no force here"):
        method.run(pulled(raises), 2.0, setting)
    run = method.run(pulled(ends), 2.0, setting)
    first = run.failed_step
    assert not run.success and 40 < first < 50 and f"tep {first}," in run.status
    assert run.counts["steps"] == first - 1
    done = np.append(np.arange(0, 200, 3), 200) < first
    for states in (run.q, run.p):
        assert np.all(np.isfinite(states[done])) and np.all(np.isnan(states[~done]))


def test_bodies_that_meet_end_the_run():
    apart = galvi.Problem(galvi.NBody([1.0, 1.0]), [[-0.5, 0.0], [0.5, 0.0]], [[1.0, 0], [-1.0, 0]])
    run = EXPLICIT_EULER.run(apart, 2.0, {"step": 0.5})
    assert not run.success and run.failed_step == 2 and "bodies met" in run.status
    assert np.all(np.isnan(run.q[2:])) and np.all(np.isfinite(run.q[:2]))


def test_implicit_euler_passes_through_zero_without_a_stall():
    run = IMPLICIT_EULER.run(
        galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(1.0)), [1.0], [-10.0 - 1e-10]),
        0.2,
        {"step": 0.1},
    )
    assert run.success and run.counts["iterations"] <= 4


@pytest.mark.slow(beside="test_implicit_euler_passes_through_zero_without_a_stall")
def test_implicit_euler_says_when_its_equations_have_no_solution_left():
    problem, step = galvi.problems.solar_system(), 0.005 * 365.25
    run = IMPLICIT_EULER.run(problem, 100 * step, {"step": step})
    assert not run.success and run.failed_step == 18 and "stopped converging" in run.status
    sunward = np.linalg.norm(run.q[:18, 1] - run.q[:18, 0], axis=1)
    assert np.all(np.diff(sunward) < 0.0) and sunward[-1] < 0.17
    blind = IMPLICIT_EULER.run(
        problem, 1000 * step, {"step": step, "save_every": 1000, "accept_unconverged": True}
    )
    assert blind.success and "not states of implicit Euler" in blind.status
    assert blind.counts["unconverged_steps"] > 0
    assert np.linalg.norm(blind.q[-1, 1] - blind.q[-1, 0]) > 10.0

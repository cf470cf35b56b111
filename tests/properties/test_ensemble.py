"""Many initial conditions at once: the runs are those of one by one, whatever becomes of some."""

import os
import signal
import threading
import time

import numpy as np
import pytest

import galvi

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.3)


def near(problem, members, size=1e-3):
    """Starts around the problem's own."""
    off = np.random.default_rng(7).standard_normal((members, 2, *problem.q0.shape))
    return [
        problem.with_initial_state(problem.q0 * (1 + size * q), problem.v0 * (1 + size * v))
        for q, v in off
    ]


def assert_same(one, other):
    for name in ("t", "q", "p"):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
    assert one.counts == other.counts and one.status == other.status
    assert np.array_equal(one.checkpoint.state, other.checkpoint.state)


@pytest.mark.parametrize("threads", [1, 2, 3, None])
@pytest.mark.parametrize(
    ("problem", "step", "solver"),
    [
        (galvi.problems.outer_solar_system(), 400.0, "auto"),
        (KEPLER, 0.4, "auto"),
        (galvi.problems.henon_heiles(), 0.5, "newton"),
        (galvi.problems.solar_system(), 100.0, "auto"),
    ],
)
def test_runs_are_those_of_one_by_one_to_the_bit(problem, step, solver, threads):
    starts = near(problem, 7, 1e-6)
    many = galvi.integrate_many(iter(starts), EIGHT, step, 30, solver=solver, threads=threads)
    assert isinstance(many, tuple) and len(many) == 7
    for start, run in zip(starts, many, strict=True):
        assert run.problem is start
        assert_same(run, galvi.integrate(start, EIGHT, step, 30, solver=solver))


def test_the_comparison_to_the_bit_sees_one_bit():
    one, other = (galvi.integrate(start, EIGHT, 0.1, 5) for start in near(KEPLER, 2, 1e-16))
    with pytest.raises(AssertionError):
        assert_same(one, other)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_that_fails_is_a_value_and_the_others_go_on(threads):
    pair = galvi.NBody([0.5, 0.5])
    apart = galvi.Problem(pair, [[-0.5, 0.0], [0.5, 0.0]], [[0.0, -0.5], [0.0, 0.5]])
    falling = apart.with_initial_state(apart.q0, np.zeros((2, 2)))
    runs = galvi.integrate_many([apart, falling, apart], EIGHT, 0.1, 60, threads=threads)
    assert [run.success for run in runs] == [True, False, True]
    assert "collide" in runs[1].status and np.isnan(runs[1].q[-1]).all()
    assert_same(runs[0], runs[2])


@pytest.mark.parametrize("threads", [1, 2])
def test_curves_saving_duration_and_tolerance_are_those_of_one_run(threads):
    settings = {"duration": 12.0, "save_every": 5, "curves": True, "tolerance": 1e-9}
    (run,) = galvi.integrate_many([KEPLER], EIGHT, 0.4, threads=threads, **settings)
    alone = galvi.integrate(KEPLER, EIGHT, 0.4, **settings)
    assert_same(run, alone)
    assert np.array_equal(run(3.21), alone(3.21))


def test_plain_python_functions_are_never_called_by_two_threads():
    """They may keep what they like in a place of their own, as this gradient does."""
    buffer, inside, callers = np.zeros(2), threading.Lock(), set()

    def gradient(q):
        assert inside.acquire(blocking=False)
        try:
            callers.add(threading.get_ident())
            buffer[:] = q / np.linalg.norm(q) ** 3  # of numbers only, so that it is not traced
            time.sleep(0)
        finally:
            inside.release()
        return buffer

    system = galvi.Canonical(1.0, lambda q: -1.0 / np.linalg.norm(q), gradient)
    starts = near(galvi.Problem(system, KEPLER.q0, KEPLER.v0), 4)
    runs = galvi.integrate_many(starts, EIGHT, 0.4, 10, threads=4)
    assert callers == {threading.get_ident()}
    for start, run in zip(starts, runs, strict=True):
        assert_same(run, galvi.integrate(start, EIGHT, 0.4, 10))


def test_no_problems_are_no_runs():
    assert galvi.integrate_many([], EIGHT, 0.1, 3) == ()


@pytest.mark.slow_cases("2")
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_stops_all_and_each_can_be_resumed(threads):
    starts = near(KEPLER, 4)
    galvi.integrate_many(starts, EIGHT, 0.4, 3, save_every=3, threads=threads)  # compiles
    pressed = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    pressed.start()
    steps = 10**8
    runs = galvi.integrate_many(starts, EIGHT, 0.4, steps, save_every=steps, threads=threads)
    pressed.join()
    assert all(run.interrupted and "what was computed is kept" in run.status for run in runs)
    assert [run.failed_step > 1 for run in runs].count(True) >= threads
    assert runs[-1].failed_step == 1  # not begun, as there were more than threads
    assert_same(
        galvi.resume(runs[-1], 5, save_every=1),
        galvi.integrate(starts[-1], EIGHT, 0.4, 5),
    )
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_another_start_keeps_all_else():
    problem = galvi.problems.outer_solar_system()
    other = problem.with_initial_state(2.0 * problem.q0, problem.v0)
    assert np.array_equal(other.q0, 2.0 * problem.q0) and other.system is problem.system
    assert (other.t0, other.name, other.units) == (problem.t0, problem.name, problem.units)
    assert other.parameters == problem.parameters

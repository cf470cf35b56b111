"""Many problems at once: each run is the single run, in threads too, whether or not others fail;
errors name the problem, and memory is counted before the first step."""

import os
import signal
import threading
import time
import tracemalloc

import numba
import numpy as np
import psutil
import pytest

import galvi
from galvi.kernels.nystrom import advance
from galvi.lanes import nbody as packed
from galvi.run import batches, ensemble, request
from galvi.run.request import RunRequest, check_memory

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.3)
CENTRE = KEPLER.with_initial_state([0.0, 0.0], [0.0, 1.0])


def neighbours(problem, members, size=1e-3):
    """Problems whose starts differ from the problem's by relative amounts of about ``size``."""
    relative_changes = np.random.default_rng(7).standard_normal((members, 2, *problem.q0.shape))
    return [
        problem.with_initial_state(problem.q0 * (1 + size * q), problem.v0 * (1 + size * v))
        for q, v in relative_changes
    ]


def assert_same(left, right):
    for name in ("t", "q", "p"):
        assert np.array_equal(getattr(left, name), getattr(right, name), equal_nan=True)
    assert left.counts == right.counts and left.status == right.status
    assert np.array_equal(left.checkpoint.state, right.checkpoint.state)


@pytest.mark.parametrize(
    ("problem", "step", "threads", "options"),
    [
        (galvi.problems.outer_solar_system(), 400.0, 3, {"steps": 30}),
        (galvi.problems.henon_heiles(), 0.5, 1, {"steps": 30, "solver": "newton"}),
        (KEPLER, 0.4, None, {"duration": 12.0, "save_every": 5, "curves": True, "tolerance": 1e-9}),
    ],
)
def test_runs_are_those_of_one_by_one_to_the_bit(problem, step, threads, options):
    starts = neighbours(problem, 7, 1e-6)
    many = galvi.integrate_many(iter(starts), EIGHT, step, threads=threads, **options)
    assert isinstance(many, tuple) and len(many) == 7
    for start, run in zip(starts, many, strict=True):
        single = galvi.integrate(start, EIGHT, step, **options)
        assert run.problem is start and np.array_equal(run(3.21), single(3.21))
        assert_same(run, single)


def test_the_comparison_to_the_bit_sees_one_bit():
    first, second = (
        galvi.integrate(start, EIGHT, 0.1, 5) for start in neighbours(KEPLER, 2, 1e-16)
    )
    with pytest.raises(AssertionError):
        assert_same(first, second)


def test_no_problems_are_no_runs():
    assert galvi.integrate_many([], EIGHT, 0.1, 3) == ()


def test_a_run_that_fails_is_a_value_and_the_others_go_on():
    pair = galvi.NBody([0.5, 0.5])
    orbiting = galvi.Problem(pair, [[-0.5, 0.0], [0.5, 0.0]], [[0.0, -0.5], [0.0, 0.5]])
    falling = orbiting.with_initial_state(orbiting.q0, np.zeros((2, 2)))
    runs = galvi.integrate_many([orbiting, falling, orbiting], EIGHT, 0.1, 60, threads=2)
    assert [run.success for run in runs] == [True, False, True]
    assert "collide" in runs[1].status and np.isnan(runs[1].q[-1]).all()
    assert_same(runs[0], runs[2])


def test_another_start_keeps_all_else():
    problem = galvi.problems.outer_solar_system()
    moved = problem.with_initial_state(2.0 * problem.q0, problem.v0)
    assert np.array_equal(moved.q0, 2.0 * problem.q0) and moved.system is problem.system
    for name in ("t0", "name", "units", "parameters"):
        assert getattr(moved, name) == getattr(problem, name)


# ---------------------------------------------------------------- threads


def test_plain_python_functions_are_never_called_by_two_threads():
    """They may keep a buffer, as this gradient does."""
    buffer, call_lock, callers = np.zeros(2), threading.Lock(), set()

    def gradient(q):
        assert call_lock.acquire(blocking=False)
        try:
            callers.add(threading.get_ident())
            buffer[:] = q / np.linalg.norm(q) ** 3  # of numbers only, so that it is not traced
            time.sleep(0)
        finally:
            call_lock.release()
        return buffer

    system = galvi.Canonical(1.0, lambda q: -1.0 / np.linalg.norm(q), gradient)
    starts = neighbours(galvi.Problem(system, KEPLER.q0, KEPLER.v0), 4)
    runs = galvi.integrate_many(starts, EIGHT, 0.4, 10, threads=4)
    assert callers == {threading.get_ident()}
    for start, run in zip(starts, runs, strict=True):
        assert_same(run, galvi.integrate(start, EIGHT, 0.4, 10))


@pytest.mark.slow_cases("2")
@pytest.mark.usefixtures("interruptible")
@pytest.mark.parametrize("threads", [1, 2])
def test_ctrl_c_stops_all_and_each_can_be_resumed(threads):
    starts = neighbours(KEPLER, 4)
    galvi.integrate_many(starts, EIGHT, 0.4, 3, save_every=3, threads=threads)  # compiles
    timer = threading.Timer(0.5, os.kill, (os.getpid(), signal.SIGINT))
    timer.start()
    steps = 10**8
    runs = galvi.integrate_many(starts, EIGHT, 0.4, steps, save_every=steps, threads=threads)
    timer.join()
    assert all(run.interrupted and run.outcome.end is galvi.End.INTERRUPTED for run in runs)
    assert [run.failed_step > 1 for run in runs].count(True) >= threads
    assert runs[-1].failed_step == 1  # not begun, as there were more than threads
    assert_same(
        galvi.resume(runs[-1], 5, save_every=1),
        galvi.integrate(starts[-1], EIGHT, 0.4, 5),
    )
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_a_kernel_leaves_the_other_threads_alone():
    for dispatcher in (advance.compiled_advance(), packed.compiled_advance(3)):
        assert dispatcher.targetoptions["nogil"]


def test_short_runs_go_on_beside_a_long_one():
    finished = threading.Semaphore(0)

    def long(interrupted):
        for _ in range(500):
            assert finished.acquire(timeout=60)

    def quick(interrupted):
        finished.release()

    ensemble._run_all([long] + [quick] * 500, 2, None)


@pytest.mark.parametrize("threads", [1, 3])
def test_what_ends_a_thread_ends_the_ensemble(threads):
    def short(interrupted):
        pass

    def exit_thread(interrupted):
        raise SystemExit

    with pytest.raises(SystemExit):
        ensemble._run_all([short] * 100 + [exit_thread] + [short] * 100, threads, None)


def test_of_several_that_raise_the_first_in_order_is_told_and_the_later_ones_stop():
    quick_raised = threading.Event()

    def slow(interrupted):
        quick_raised.wait(20)
        raise ValueError("slow")

    def quick(interrupted):
        quick_raised.set()
        raise ValueError("quick")

    def long(interrupted):
        deadline = time.monotonic() + 20
        while not interrupted():
            assert time.monotonic() < deadline
            time.sleep(0.001)

    with pytest.raises(ValueError, match="slow"):
        ensemble._run_all([slow, quick, long], 3, None)


# ---------------------------------------------------------------- what is refused


@numba.njit
def raising(q):
    if q[1] > 5.0:
        raise ValueError("out of the table")
    return q


@pytest.mark.parametrize(("gradient", "threads"), [(raising.py_func, 1), (raising, 2)])
def test_what_a_function_raises_tells_which_problem_it_was(gradient, threads):
    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient)
    calm = galvi.Problem(system, [1.0, 0.0], [0.0, 1.0])
    starts = [calm, calm, calm.with_initial_state([1.0, 0.0], [0.0, 9.0]), calm]
    with pytest.raises(ValueError, match="out of the table") as caught:
        galvi.integrate_many(starts, EIGHT, 0.1, 100, threads=threads)
    assert caught.value.__notes__ == ["This was problems[2]."]


def test_a_bad_problem_is_told_apart():
    with pytest.raises(ValueError, match="potential must be finite at the start") as caught:
        galvi.integrate_many([KEPLER, CENTRE], EIGHT, 0.1, 3)
    assert caught.value.__notes__ == ["This was problems[1]."]


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
def test_numbers_that_fill_the_counters_are_whole_numbers_too(problem):
    assert galvi.integrate(problem, EIGHT, 0.01, 3, save_every=2**62).t.size == 2


def test_memory_is_counted_for_each_problem_by_its_own_size(monkeypatch):
    """One of 100 bodies among 999 small ones: 2,298 components, not 300 for each of 1,000."""
    state = np.random.default_rng(3).standard_normal((2, 100, 3))
    large = galvi.Problem(galvi.NBody(np.full(100, 1e-3)), *state)
    monkeypatch.setattr(request, "free_memory", lambda: float(2**30))
    big, small = (
        RunRequest.checked(problem, EIGHT, 0.1, 10_000, curves=False) for problem in (large, KEPLER)
    )
    check_memory([big] + [small] * 999)
    with pytest.raises(ValueError, match=r"1000 runs of 10000 steps would keep 67\.1 GiB in all"):
        check_memory([big] * 1000)
    with pytest.raises(ValueError, match="2 runs of 300000 steps would keep") as caught:
        galvi.integrate_many([large, KEPLER], EIGHT, 0.1, 300_000, curves=False)
    assert not hasattr(caught.value, "__notes__")  # no single problem is at fault


@pytest.mark.parametrize("curves", [True, False])
def test_the_memory_counted_is_what_a_run_takes(curves, monkeypatch):
    problem = galvi.problems.outer_solar_system()
    galvi.integrate(problem, EIGHT, 10.0, 2)
    run = RunRequest.checked(problem, EIGHT, 10.0, 4000, curves=curves)
    tracemalloc.start()
    galvi.integrate(problem, EIGHT, 10.0, 4000, curves=curves)
    _, peak = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    monkeypatch.setattr(request, "ALWAYS_FREE", 0.0)
    monkeypatch.setattr(request, "free_memory", lambda: 1.1 * peak)
    check_memory([run])
    for free, message in ((0.9 * peak, "^4000 steps would .* are free"), (2.0**20, "0.000977 GiB")):
        monkeypatch.setattr(request, "free_memory", lambda free=free: free)
        with pytest.raises(ValueError, match=message):
            check_memory([run])


def test_the_free_memory_is_a_part_of_all():
    total = psutil.virtual_memory().total
    assert 1e-3 * total < request.free_memory() <= total


# ---------------------------------------------------------------- batches of steps


class Steps:
    """A stepper that only counts its steps, at most ``steps_per_call`` in a call."""

    def __init__(self, steps_per_call: int = 10**9) -> None:
        self.steps_done, self.at_a_time, self.asked = 0, steps_per_call, list[int]()

    def advance(self, n: int) -> int:
        self.asked.append(n)
        self.steps_done += min(n, self.at_a_time)
        return 0


def unchanged_code(code: int) -> int:
    return code


@pytest.mark.parametrize("steps_per_call", [1, 10**9])
def test_a_kernel_that_hands_over_every_step_is_not_asked_for_ever_more(
    steps_per_call: int,
) -> None:
    """Newton's steps come one a call: 500 of them must not make the next call endless."""
    steps, total = Steps(steps_per_call), 500 if steps_per_call == 1 else 10**6
    assert batches.step_in_batches(steps, unchanged_code, total, None) == 0
    assert steps.steps_done == total
    assert max(steps.asked) <= batches.BATCH_GROWTH * min(steps_per_call, total)


def test_a_note_is_made_after_every_so_many_steps_but_the_last() -> None:
    steps, notes = Steps(), list[int]()
    batches.step_in_batches(
        steps, unchanged_code, 35, None, note_every=7, note=lambda: notes.append(steps.steps_done)
    )
    assert notes == [7, 14, 21, 28]


def test_a_run_without_progress_makes_no_bar_whose_semaphore_a_killed_process_would_leave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr(batches, "tqdm")
    steps = Steps()
    assert batches.step_in_batches(steps, unchanged_code, 3, None) == 0
    with pytest.raises(NameError):
        batches.step_in_batches(steps, unchanged_code, 4, True)

"""Many initial conditions at once: the same runs, in the same order, whatever becomes of some."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections import Counter

import numba
import numpy as np
import pytest

import galvi
from galvi import ensemble
from galvi.kernels import advance, packed
from galvi.workspace import check_room

EIGHT = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
KEPLER = galvi.problems.kepler(0.3)


def near(problem, members, size=1e-3):
    """Starts around the problem's own."""
    off = np.random.default_rng(7).standard_normal((members, 2, *problem.q0.shape))
    return [
        problem.starting_at(problem.q0 * (1 + size * q), problem.v0 * (1 + size * v))
        for q, v in off
    ]


def assert_same(one, other):
    for name in ("t", "q", "p"):
        assert np.array_equal(getattr(one, name), getattr(other, name), equal_nan=True)
    assert one.counts == other.counts and one.status == other.status
    assert np.array_equal(one.continuation.state, other.continuation.state)


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


def test_several_threads_take_part(monkeypatch):
    seen = set()
    met = threading.Barrier(2, timeout=20)

    def run(interrupted):
        seen.add(threading.get_ident())
        met.wait()

    assert ensemble._all_of([run] * 2, 2, None) == (None, None)
    assert len(seen) == 2


def test_a_kernel_leaves_the_other_threads_alone():
    for dispatcher in (advance.compiled_advance(), packed.compiled_advance(3)):
        assert dispatcher.targetoptions["nogil"]


def short(interrupted):
    time.sleep(0.0005)  # enough for every thread to take part


def test_threads_leave_short_runs_to_one_of_them(monkeypatch):
    monkeypatch.setattr(ensemble, "SHORT", 60.0)
    monkeypatch.setattr(ensemble, "NAP", 60.0)
    seen = []

    def run(interrupted):
        seen.append(threading.get_ident())
        short(interrupted)

    clock = time.monotonic()
    ensemble._all_of([run] * 300, 2, None)
    most = max(Counter(seen).values())
    assert len(seen) == 300 and 300 - most <= ensemble.PATIENCE
    assert time.monotonic() - clock < 30.0  # nobody is left at rest


@pytest.mark.parametrize("shortest", [60.0, ensemble.SHORT])
def test_threads_come_back_for_long_runs_after_short_ones(monkeypatch, shortest):
    """The long ones wait for each other: one thread alone would wait in vain."""
    monkeypatch.setattr(ensemble, "SHORT", shortest)
    met = threading.Barrier(3, timeout=20)

    def long(interrupted):
        met.wait()

    assert ensemble._all_of([short] * 60 + [long] * 9, 3, None) == (None,) * 69


def test_threads_come_back_for_runs_of_middle_length():
    seen = set()

    def middle(interrupted):
        seen.add(threading.get_ident())
        time.sleep(5 * ensemble.SHORT)

    ensemble._all_of([short] * 60 + [middle] * 60, 3, None)
    assert len(seen) == 3


def test_short_runs_go_on_beside_a_long_one():
    rest = threading.Semaphore(0)

    def long(interrupted):
        for _ in range(500):
            assert rest.acquire(timeout=60)

    def quick(interrupted):
        rest.release()

    ensemble._all_of([long] + [quick] * 500, 2, None)


@pytest.mark.parametrize("threads", [1, 3])
def test_a_thread_that_is_ended_by_what_a_run_raises_leaves_none_at_rest(threads):
    def leaves(interrupted):
        raise SystemExit

    with pytest.raises(SystemExit):
        ensemble._all_of([short] * 100 + [leaves], threads, None)


@pytest.mark.parametrize("threads", [1, 2])
def test_a_run_that_fails_is_a_value_and_the_others_go_on(threads):
    pair = galvi.NBody([0.5, 0.5])
    apart = galvi.Problem(pair, [[-0.5, 0.0], [0.5, 0.0]], [[0.0, -0.5], [0.0, 0.5]])
    falling = apart.starting_at(apart.q0, np.zeros((2, 2)))
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
        callers.add(threading.get_ident())
        buffer[:] = q / np.linalg.norm(q) ** 3
        time.sleep(0)
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


@pytest.mark.parametrize("where", [0, 2, 3])
def test_what_a_function_raises_tells_which_problem_it_was(where):
    def gradient(q):
        if q[1] > 5.0:
            raise RuntimeError("out of the table")
        return q

    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, gradient)
    calm = galvi.Problem(system, [1.0, 0.0], [0.0, 1.0])
    starts = [calm] * 4
    starts[where] = calm.starting_at([1.0, 0.0], [0.0, 9.0])
    with pytest.raises(RuntimeError, match="out of the table") as caught:
        galvi.integrate_many(starts, EIGHT, 0.1, 100)
    assert caught.value.__notes__ == [f"This was problems[{where}]."]


def test_of_several_that_raise_the_first_in_order_is_told():
    late = threading.Event()

    def slow(interrupted):
        late.wait(20)
        raise ValueError("slow")

    def quick(interrupted):
        late.set()
        raise ValueError("quick")

    with pytest.raises(ValueError, match="slow") as caught:
        ensemble._all_of([slow, quick], 2, None)
    assert caught.value.__notes__ == ["This was problems[0]."]


def test_after_one_that_raises_the_later_ones_stop():
    def raises(interrupted):
        raise ValueError("first")

    def long(interrupted):
        give_up = time.monotonic() + 20
        while not interrupted():
            assert time.monotonic() < give_up
            time.sleep(0.001)

    with pytest.raises(ValueError, match="first"):
        ensemble._all_of([raises, long], 2, None)


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
        galvi.resume(runs[-1], 5),
        galvi.integrate(starts[-1], EIGHT, 0.4, 5),
    )
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@numba.njit
def raising(q):
    if q[0] < 0.0:
        raise ValueError("no such place")
    return q


def test_a_jitted_function_that_raises_in_a_thread_is_told_too():
    system = galvi.Canonical(1.0, lambda q: 0.5 * q @ q, raising)
    start = galvi.Problem(system, [1.0], [0.0])
    with pytest.raises(ValueError, match="no such place") as caught:
        galvi.integrate_many([start] * 3, EIGHT, 0.5, 20, threads=2)
    assert caught.value.__notes__ == ["This was problems[0]."]


@pytest.mark.parametrize(
    ("call", "error", "sentence"),
    [
        (lambda: galvi.integrate_many(KEPLER, EIGHT, 0.1, 3), TypeError, "For one, call"),
        (lambda: galvi.integrate_many(5, EIGHT, 0.1, 3), TypeError, "problems must be several"),
        (
            lambda: galvi.integrate_many([KEPLER, 5], EIGHT, 0.1, 3),
            TypeError,
            r"problem must be a galvi\.Problem; received 5",
        ),
        (
            lambda: galvi.integrate_many([KEPLER], EIGHT, 0.1, 3, threads=0),
            ValueError,
            "threads must be a whole number of at least 1; received 0",
        ),
        (lambda: galvi.integrate_many([KEPLER], EIGHT, 0.0, 3), ValueError, "must not be zero"),
        (
            lambda: galvi.integrate_many([KEPLER] * 1000, EIGHT, 0.1, 10**8),
            ValueError,
            "1000 runs of 100000000 steps would keep",
        ),
        (
            lambda: KEPLER.starting_at([1.0], [0.0, 1.0]),
            ValueError,
            "v0 must have shape",
        ),
    ],
)
def test_bad_input_is_refused_before_any_work(call, error, sentence):
    with pytest.raises(error, match=sentence):
        call()


def test_memory_is_counted_for_each_problem_by_its_own_size(monkeypatch):
    """One of 100 bodies among 999 small ones: 2,298 components, not 300 for each of 1,000."""
    places = np.random.default_rng(3).standard_normal((2, 100, 3))
    large = galvi.Problem(galvi.NBody(np.full(100, 1e-3)), *places)
    machine = {"SC_PAGE_SIZE": 1, "SC_PHYS_PAGES": 2**30}
    monkeypatch.setattr(os, "sysconf", machine.__getitem__)
    settings = (EIGHT, 10_000, 1, False)
    check_room([large] + [KEPLER] * 999, *settings)
    with pytest.raises(ValueError, match=r"1000 runs of 10000 steps would keep 44\.7 GiB in all"):
        check_room([large] * 1000, *settings)
    with pytest.raises(ValueError, match="2 runs of 300000 steps would keep") as caught:
        galvi.integrate_many([large, KEPLER], EIGHT, 0.1, 300_000, curves=False)
    assert not hasattr(caught.value, "__notes__")  # no single problem is at fault


@pytest.mark.parametrize("problem", [KEPLER, galvi.problems.heavy_top()])
def test_numbers_that_fill_the_counters_are_whole_numbers_too(problem):
    assert galvi.integrate(problem, EIGHT, 0.01, 3, save_every=2**62).t.size == 2


@pytest.mark.parametrize(
    ("settings", "sentence"),
    [
        ({"steps": 10, "save_every": 10**20}, f"save_every must be .* from 1 to {2**62}; received"),
        (
            {"steps": 10**25, "save_every": 10**25},
            f"steps must be a whole number from 1 to {2**62}",
        ),
        ({"steps": 1e300}, r"from 1 to .*; received 1e\+300"),
        ({"steps": np.inf}, "from 1 to .*; received inf"),
        ({"steps": 10**5000}, "from 1 to .*; received a number of 16610 bits"),
        ({"steps": -(10**25)}, "of at least 1; received -1"),
        ({"duration": 1e300}, "duration over step must be .* from 1 to"),
        ({"duration": 1e25}, "duration over step must be .* from 1 to"),
    ],
)
@pytest.mark.parametrize("many", [False, True])
def test_numbers_beyond_the_counters_are_refused(settings, sentence, many):
    with pytest.raises(ValueError, match=sentence):
        if many:
            galvi.integrate_many([KEPLER], EIGHT, 1e-10, **settings)
        else:
            galvi.integrate(KEPLER, EIGHT, 1e-10, **settings)


def test_a_bad_problem_is_told_apart():
    centre = KEPLER.starting_at([0.0, 0.0], [0.0, 1.0])
    with pytest.raises(ValueError, match="force must be finite at the start") as caught:
        galvi.integrate_many([KEPLER, centre], EIGHT, 0.1, 3)
    assert caught.value.__notes__ == ["This was problems[1]."]


def test_another_start_keeps_all_else():
    problem = galvi.problems.outer_solar_system()
    other = problem.starting_at(2.0 * problem.q0, problem.v0)
    assert np.array_equal(other.q0, 2.0 * problem.q0) and other.system is problem.system
    assert (other.t0, other.name, other.units) == (problem.t0, problem.name, problem.units)
    assert other.parameters == problem.parameters

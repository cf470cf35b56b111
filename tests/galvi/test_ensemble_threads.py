"""Threads of an ensemble: which take part, and none is left at rest."""

from __future__ import annotations

import threading
import time
from collections import Counter

import pytest

from galvi.kernels.lanes import nbody as packed
from galvi.kernels.nystrom import advance
from galvi.run import ensemble


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

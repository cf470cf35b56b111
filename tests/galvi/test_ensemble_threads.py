"""Threads of an ensemble: several take part, and an exception ends it."""

from __future__ import annotations

import threading
import time

import pytest

from galvi.fast.lanes import nbody as packed
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


def test_short_runs_go_on_beside_a_long_one():
    rest = threading.Semaphore(0)

    def long(interrupted):
        for _ in range(500):
            assert rest.acquire(timeout=60)

    def quick(interrupted):
        rest.release()

    ensemble._all_of([long] + [quick] * 500, 2, None)


@pytest.mark.parametrize("threads", [1, 3])
def test_what_ends_a_thread_ends_the_ensemble(threads):
    def short(interrupted):
        pass

    def leaves(interrupted):
        raise SystemExit

    with pytest.raises(SystemExit):
        ensemble._all_of([short] * 100 + [leaves] + [short] * 100, threads, None)


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

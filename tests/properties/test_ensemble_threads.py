"""Ensembles in chunks and threads."""

from __future__ import annotations

import threading
import time

import pytest

from galvi.kernels.nystrom import advance
from galvi.lanes import nbody as packed
from galvi.run import batches, ensemble


class Steps:
    """A stepper of which only the number of steps done is real."""

    def __init__(self, at_a_time: int = 10**9) -> None:
        self.done, self.at_a_time, self.asked = 0, at_a_time, list[int]()

    def advance(self, n: int) -> int:
        self.asked.append(n)
        self.done += min(n, self.at_a_time)
        return 0


def same(code: int) -> int:
    return code


@pytest.mark.parametrize("at_a_time", [1, 10**9])
def test_a_kernel_that_hands_over_every_step_is_not_asked_for_ever_more(at_a_time: int) -> None:
    """Newton's steps come one a call: 500 of them must not make the next call endless."""
    steps, total = Steps(at_a_time), 500 if at_a_time == 1 else 10**6
    assert batches.step_in_batches(steps, same, total, None) == 0
    assert steps.done == total
    assert max(steps.asked) <= batches.BATCH_GROWTH * min(at_a_time, total)


def test_a_note_is_made_after_every_so_many_steps_but_the_last() -> None:
    steps, notes = Steps(), list[int]()
    batches.step_in_batches(steps, same, 35, None, apart=7, note=lambda: notes.append(steps.done))
    assert notes == [7, 14, 21, 28]


def test_a_run_without_progress_makes_no_bar_whose_semaphore_a_killed_process_would_leave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr(batches, "tqdm")
    steps = Steps()
    assert batches.step_in_batches(steps, same, 3, None) == 0
    with pytest.raises(NameError):
        batches.step_in_batches(steps, same, 4, True)


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

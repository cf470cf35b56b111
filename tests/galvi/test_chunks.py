"""The loop around a kernel asks for not many more steps than the last call did."""

from __future__ import annotations

import pytest

from galvi.run import loop


class Steps:
    """What a run writes into, here only a number."""

    done = 0


@pytest.mark.parametrize("at_a_time", [1, 10**9])
def test_a_kernel_that_hands_over_every_step_is_not_asked_for_ever_more(at_a_time: int) -> None:
    """Newton's steps come one a call: 500 of them must not make the next call endless."""
    work, asked = Steps(), []

    def call(todo: int) -> int:
        asked.append(todo)
        work.done += min(todo, at_a_time)
        return 0

    total = 500 if at_a_time == 1 else 10**6
    assert loop.step_in_batches(call, lambda code: code, work, total, None) == 0
    assert work.done == total
    assert max(asked) <= loop.GROWTH * min(at_a_time, total)


def test_a_note_is_made_after_every_so_many_steps_but_the_last() -> None:
    work, notes = Steps(), []

    def call(todo: int) -> int:
        work.done += todo
        return 0

    arguments = (call, lambda code: code, work, 35, None)
    loop.step_in_batches(*arguments, apart=7, note=lambda: notes.append(work.done))
    assert notes == [7, 14, 21, 28]


def test_a_run_without_progress_makes_no_bar_whose_semaphore_a_killed_process_would_leave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    monkeypatch.delattr(loop, "tqdm")
    work = Steps()

    def call(todo: int) -> int:
        work.done += todo
        return 0

    assert loop.step_in_batches(call, lambda code: code, work, 3, None) == 0
    with pytest.raises(NameError):
        loop.step_in_batches(call, lambda code: code, work, 4, True)

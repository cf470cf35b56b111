"""The loop around a compiled kernel: a bounded number of steps a call, with progress and Ctrl-C."""

from __future__ import annotations

import time
from collections.abc import Callable
from typing import Protocol

from tqdm import tqdm

from galvi.run.interruption import defer_interrupts

CALL_SECONDS = 0.1
GROWTH = 64.0  # of the steps in a call from one to the next, at most


class Progress(Protocol):
    """What a run writes into, as far as this loop cares."""

    @property
    def done(self) -> int:
        """Steps done so far."""


def step_in_batches(
    call: Callable[[int], int],
    recover: Callable[[int], int],
    work: Progress,
    steps: int,
    progress: bool | None,
    interrupted: Callable[[], bool] | None = None,
) -> int:
    """Do ``steps`` steps; returns the code of the last call, 0 when it was interrupted or is done.

    call         does so many steps and returns 0, or the code of the step that failed
    recover      (code) tries that step in another way, and returns its code
    interrupted  says whether to stop; None means that Ctrl-C stops it

    Raises KeyboardInterrupt only when all steps were done all the same.
    """
    code, chunk = 0, 1
    with defer_interrupts() as pressed, tqdm(total=steps, disable=not progress, unit="step") as bar:
        stopped = interrupted or pressed
        while code == 0 and work.done < steps and not stopped():
            before, clock = work.done, time.perf_counter()
            code = call(min(chunk, steps - before))
            if code:
                code = recover(code)
            bar.update(work.done - before)
            more = 0.5 * CALL_SECONDS / max(time.perf_counter() - clock, 1e-9)
            chunk = max(1, int((work.done - before) * min(max(more, 0.5), GROWTH)))
        if pressed() and work.done == steps:
            raise KeyboardInterrupt
    return code

"""The loop around a compiled kernel: about 0.1 s of steps per call, so that it can be stopped."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext
from typing import Protocol

from tqdm import tqdm

CALL_SECONDS = 0.1
GROWTH = 64.0  # largest ratio of the number of steps in a call to that in the call before


class Progress(Protocol):
    """The arrays that a run writes to, as far as this loop needs them."""

    @property
    def done(self) -> int:
        """Steps done so far."""


def step_in_batches(
    call: Callable[[int], int],
    recover: Callable[[int], int],
    work: Progress,
    steps: int,
    progress: bool | None,
    stopped: Callable[[], bool] = lambda: False,
    apart: int = 0,
    note: Callable[[], None] = lambda: None,
) -> int:
    """Do ``steps`` steps; returns the code of the last call, 0 if all are done or it was stopped.

    call     (n) does n steps and returns 0, or the code of the step that failed
    recover  (code) retries that step in another way and returns its code
    stopped  returns whether to stop
    note     is called after every ``apart`` steps but the last, if that is not 0
    """
    code, chunk = 0, 1
    # A bar makes a multiprocessing semaphore, which a killed process would leave behind.
    with tqdm(total=steps, unit="step") if progress else nullcontext() as bar:
        while code == 0 and work.done < steps and not stopped():
            before, clock = work.done, time.perf_counter()
            ahead = apart - before % apart if apart else steps
            code = call(min(chunk, ahead, steps - before))
            if code:
                code = recover(code)
            if apart and work.done % apart == 0 and before < work.done < steps:
                note()
            if bar is not None:
                bar.update(work.done - before)
            more = 0.5 * CALL_SECONDS / max(time.perf_counter() - clock, 1e-9)
            chunk = max(1, int((work.done - before) * min(max(more, 0.5), GROWTH)))
    return code

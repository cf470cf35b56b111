"""Batches of steps, between which Ctrl-C can end a run and a bar shows how far it is."""

from __future__ import annotations

import time
from collections.abc import Callable
from contextlib import nullcontext
from typing import Protocol

from tqdm import tqdm

BATCH_SECONDS = 0.05  # intended seconds of a call of ``advance``
STEPS_BETWEEN_STATES = 1024  # least steps between checkpoints, from which curves are computed again
BATCH_GROWTH = 64.0  # largest ratio of the number of steps in a call to that in the call before


class Steps(Protocol):
    """The part of a stepper that `step_in_batches` uses."""

    @property
    def steps_done(self) -> int:
        """Number of completed steps."""

    def advance(self, n: int) -> int:
        """Does up to n more steps; returns 0, or the code of a step that failed."""


def step_in_batches(
    stepper: Steps,
    recover: Callable[[int], int],
    steps: int,
    progress: bool | None,
    stopped: Callable[[], bool] = lambda: False,
    note_every: int = 0,
    note: Callable[[], None] = lambda: None,
) -> int:
    """Advance a stepper to ``steps`` completed steps, in calls of about BATCH_SECONDS.

    Parameters
    ----------
    recover
        (code) -> the code of the failed step after a retry
    stopped
        () -> whether to stop before the next call
    note
        called where the number of completed steps is a multiple of ``note_every``, other than
        ``steps``; never for 0

    Returns
    -------
    int
        The code of a step that failed; 0 if all steps are done or the loop was stopped.
    """
    code, chunk, steps_done = 0, 1, stepper.steps_done
    # A bar makes a multiprocessing semaphore, which a killed process would leave behind.
    with tqdm(total=steps, unit="step") if progress else nullcontext() as bar:
        while code == 0 and steps_done < steps and not stopped():
            steps_before, begin_seconds = steps_done, time.perf_counter()
            steps_to_note = note_every - steps_before % note_every if note_every else steps
            code = stepper.advance(min(chunk, steps_to_note, steps - steps_before))
            if code:
                code = recover(code)
            steps_done = stepper.steps_done
            if note_every and steps_done % note_every == 0 and steps_before < steps_done < steps:
                note()
            if bar is not None:
                bar.update(steps_done - steps_before)
            growth = BATCH_SECONDS / max(time.perf_counter() - begin_seconds, 1e-9)
            chunk = max(1, int((steps_done - steps_before) * min(max(growth, 0.5), BATCH_GROWTH)))
    return code

"""Run studies without timings in two parallel processes."""

from __future__ import annotations

import os
import signal
import threading
import time
from collections.abc import Callable, Generator, Mapping
from concurrent.futures import ProcessPoolExecutor, as_completed
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait

import pandas as pd

from galvi.run.ensemble import processors

WORKERS = 2
FEWEST = 4  # fewer studies do not repay the start of the processes


def study_in_workers(
    studies: Mapping[str, Callable[[bool], pd.DataFrame]], quick: bool
) -> Generator[tuple[str, pd.DataFrame, float], None, None]:
    """Yield (name, frame, seconds) of each study as it finishes; studies that raise are omitted.

    Yields nothing for fewer than FEWEST studies or on a single processor. The worker processes end
    with the iterator, and with this process.
    """
    if len(studies) < FEWEST or processors() < WORKERS:
        return
    others = active_children()
    with ProcessPoolExecutor(WORKERS, get_context("spawn"), _begin) as executor:
        try:
            futures = {executor.submit(_timed, one, quick): name for name, one in studies.items()}
            for future in as_completed(futures):
                result = None if future.exception() else future.result()
                if result is not None:
                    yield futures[future], *result
        except BaseException:  # the iterator is closed, or the build is interrupted
            for process in active_children():
                if process not in others:
                    process.kill()
            raise


def _timed(study: Callable[[bool], pd.DataFrame], quick: bool) -> tuple[pd.DataFrame, float] | None:
    """The frame and its run time in seconds; None when it raised (the build then reruns it)."""
    start = time.perf_counter()
    try:
        return study(quick), time.perf_counter() - start
    except Exception:
        return None


def _begin() -> None:
    """Initialise a worker: ignore interrupts, print nothing, and end with the build."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    nothing = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nothing, stream)
    threading.Thread(target=_end_with_the_build, daemon=True).start()


def _end_with_the_build() -> None:
    build = parent_process()
    assert build is not None
    wait([build.sentinel])
    os._exit(1)

"""Studies without timings, and figures, in two processes beside this one."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures.process import BrokenProcessPool
from typing import Any

import pandas as pd
import psutil
from joblib import Parallel, delayed

from galvi.run.ensemble import processors

WORKERS = 2
FEWEST_STUDIES, FEWEST_FIGURES = 4, 16  # fewer do not repay the start of the processes


def study_in_workers(
    studies: Mapping[str, Callable[[bool], pd.DataFrame]], quick: bool
) -> Generator[tuple[str, pd.DataFrame, float], None, None]:
    """Yield (name, frame, seconds) of each study as it finishes; studies that raise are omitted,
    and those that are left when a worker dies.

    Yields nothing for fewer than FEWEST_STUDIES or on a single processor. A worker ends with this
    process, and where the iterator is closed before its end.
    """
    if len(studies) < FEWEST_STUDIES or processors() < WORKERS:
        return
    # Neighbours need the same kernels, and would wait for each other where these are not compiled.
    from_both_ends = dict.fromkeys(
        name for pair in zip(studies, reversed([*studies]), strict=True) for name in pair
    )
    results = parallel(WORKERS, return_as="generator_unordered", batch_size=1)(
        delayed(_timed)(name, studies[name], quick) for name in from_both_ends
    )
    try:
        yield from (result for result in results if result is not None)
    except BrokenProcessPool:
        return
    finally:
        with warnings.catch_warnings(action="ignore"):  # joblib says that it cancels studies
            results.close()


def map_in_workers(function: Callable[[Any], Any], jobs: Sequence[Any]) -> list[Any]:
    """``list(map(function, jobs))``, in two processes where there are enough jobs."""
    if len(jobs) < FEWEST_FIGURES or processors() < WORKERS:
        return list(map(function, jobs))
    return parallel(WORKERS)(delayed(function)(job) for job in jobs)


def parallel(processes: int, **options: Any) -> Parallel:
    """Processes of one thread each that print nothing, get their arguments by value, and end with
    this one."""
    return Parallel(
        processes, backend="loky", max_nbytes=None, inner_max_num_threads=1, initializer=_begin,
        **options,
    )  # fmt: skip


def _timed(
    name: str, study: Callable[[bool], pd.DataFrame], quick: bool
) -> tuple[str, pd.DataFrame, float] | None:
    """None where the study raised: the build runs it again, and shows why."""
    start = time.perf_counter()
    try:
        return name, study(quick), time.perf_counter() - start
    except Exception:
        return None


def _begin() -> None:
    """Initialise a worker: ignore interrupts, print nothing, and end with the build."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    nowhere = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(nowhere, stream)
    threading.Thread(target=_end_with, args=(psutil.Process().parent(),), daemon=True).start()


def _end_with(build: psutil.Process) -> None:
    build.wait()
    os._exit(1)

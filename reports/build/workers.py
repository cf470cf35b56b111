"""Run studies without timings, and draw figures, in two worker processes."""

from __future__ import annotations

import os
import signal
import threading
import time
import warnings
from collections.abc import Callable, Generator, Sequence
from concurrent.futures.process import BrokenProcessPool
from contextlib import suppress
from typing import Any

import pandas as pd
import psutil
from joblib import Parallel, delayed

from benchmarks.checks.claim import Report
from galvi.run.ensemble import processors
from reports.results.cache import BuildCache, Study

WORKER_COUNT = 2
MIN_STUDIES, MIN_FIGURES = 4, 16  # fewer do not repay the start of the processes


def study_in_workers(
    studies: Sequence[Study], cache: BuildCache
) -> Generator[tuple[Study, float], None, None]:
    """Measure and store the untimed studies that the cache lacks, and yield each finished one with
    its time in seconds.

    A study that raises is skipped; when a worker dies, so are the remaining ones. Nothing is
    measured for fewer than MIN_STUDIES missing studies, or on fewer than WORKER_COUNT processors.
    The workers end with this process, and when the iterator is closed.
    """
    missing = {
        study.name: study for study in studies if not (study.timed or study.name in cache.entries)
    }
    if len(missing) < MIN_STUDIES or processors() < WORKER_COUNT:
        return
    # Neighbouring studies need the same kernels; started together, one would wait for the other to
    # compile them.
    from_both_ends = dict.fromkeys(
        name for pair in zip(missing, reversed(missing), strict=True) for name in pair
    )
    measurements = parallel(WORKER_COUNT, return_as="generator_unordered", batch_size=1)(
        delayed(_measure_timed)(name, missing[name].measure) for name in from_both_ends
    )
    try:
        for name, table, seconds in filter(None, measurements):
            cache.keep(name, table, seconds)
            yield missing[name], seconds
    except BrokenProcessPool:
        return
    finally:
        with warnings.catch_warnings(action="ignore"):  # joblib warns of the studies it cancels
            measurements.close()


def map_in_workers(function: Callable[[Any], Any], jobs: Sequence[Any]) -> list[Any]:
    """``list(map(function, jobs))``, in two processes where there are enough jobs."""
    if len(jobs) < MIN_FIGURES or processors() < WORKER_COUNT:
        return list(map(function, jobs))
    return parallel(WORKER_COUNT)(delayed(function)(job) for job in jobs)


def parallel(processes: int, **options: Any) -> Parallel:
    """A joblib pool of single-threaded processes, which print nothing and end with this process.

    Arguments are passed by value, never as memory maps.
    """
    warnings.filterwarnings("ignore", "A worker stopped while some jobs")  # loky starts another
    return Parallel(
        processes,
        backend="loky",
        max_nbytes=None,
        inner_max_num_threads=1,
        initializer=_initialise_worker,
        initargs=(os.getpid(),),
        **options,
    )


def _measure_timed(
    name: str, measure: Callable[[Report], pd.DataFrame]
) -> tuple[str, pd.DataFrame, float] | None:
    """(name, table, seconds) of a study; None if it raised: the build repeats it and shows why."""
    start = time.perf_counter()
    try:
        return name, measure(lambda sentence: None), time.perf_counter() - start
    except Exception:
        return None


def _initialise_worker(build_pid: int) -> None:
    """Initialise a worker: ignore interrupts, print nothing, and end with the build."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    null_device = os.open(os.devnull, os.O_WRONLY)
    for stream in (1, 2):
        os.dup2(null_device, stream)
    threading.Thread(target=_exit_with, args=(build_pid,), daemon=True).start()


def _exit_with(build_pid: int) -> None:
    """Exit this process as soon as the process `build_pid` has ended."""
    with suppress(psutil.NoSuchProcess):  # it ended before this one had begun
        psutil.Process(build_pid).wait()
    os._exit(1)

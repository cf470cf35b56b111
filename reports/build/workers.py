"""Results measured in two processes, from both ends."""

from __future__ import annotations

import os
import pickle
import signal
import threading
import time
from collections import Counter, deque
from collections.abc import Callable, Generator, Iterator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, ProcessPoolExecutor
from concurrent.futures import wait as first_of
from concurrent.futures.process import BrokenProcessPool
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import replace
from functools import cache, partial
from multiprocessing import active_children, get_context, parent_process
from multiprocessing.connection import wait
from typing import Any

import pandas as pd
import typer

from benchmarks.store.provenance import cpu
from benchmarks.store.result_cache import digest_of_sources
from galvi.command import unpickled_call
from galvi.run.ensemble import processors
from reports.results.claim_results import Finished
from reports.results.suite import Suite

PATIENCE = "10s"  # for the scheduler's answer


@contextmanager
def on_scheduler(suite: Suite, address: str) -> Iterator[Suite]:
    """The suite whose studies without timings run there; the suite itself for "".

    The provenance names the workers' processors. Raises typer.BadParameter where nothing answers,
    there are no workers, or they have other sources or versions than this process.
    """
    if not address:
        yield suite
        return
    try:
        from distributed import Client
        from distributed.comm import resolve_address
    except ImportError:
        raise typer.BadParameter("--scheduler needs Dask: pip install 'galvi[cluster]'.") from None
    try:
        resolve_address(address)  # else the client lingers and ends in a traceback
        client = Client(address, timeout=PATIENCE, set_as_default=False)
    except (OSError, ValueError) as error:
        said = " ".join(str(error).split())
        raise typer.BadParameter(f"--scheduler: no answer of a scheduler ({said}).") from None
    with client:
        here = _sources()
        try:
            workers = client.run(unpickled_call, pickle.dumps(_identity))
        except Exception as error:
            raise typer.BadParameter(
                f"--scheduler: its workers cannot import the suite ({error}); give them the "
                "environment of this command."
            ) from None
        if not workers:
            raise typer.BadParameter(f"--scheduler {address} has no workers; start some.")
        if others := [name for name, (sources, _) in workers.items() if sources != here]:
            raise typer.BadParameter(
                f"--scheduler: the sources or versions at {', '.join(others)} are not those of "
                "this process; start the workers anew, in its environment."
            )
        counts = Counter(model for _, model in workers.values())
        words = ", ".join(f"{count} on {model}" for model, count in counts.items())
        yield replace(
            suite,
            runner=partial(study_on, client),
            provenance=lambda command: {**suite.provenance(command), "workers": words},
        )


def study_on(
    client: Any, studies: Mapping[str, Callable[[bool], pd.DataFrame]], quick: bool
) -> Generator[Finished, None, None]:
    """As `reports.build.workers.study_in_workers`, on the workers of this client's scheduler."""
    from distributed import as_completed

    here = _sources()
    futures = {
        client.submit(
            unpickled_call, pickle.dumps(partial(_study, study, quick, here)), pure=False
        ): name
        for name, study in studies.items()
    }
    try:
        for future in as_completed(futures, loop=client.loop):
            result = None if future.exception() is not None else future.result()
            if result is not None:  # else it is studied in this process, where it may raise again
                yield futures[future], *result
    finally:
        client.cancel(list(futures))


def _study(
    study: Callable[[bool], pd.DataFrame], quick: bool, sources: str
) -> tuple[pd.DataFrame, float] | None:
    """None also where the worker, which came later, has other sources or versions."""
    return timed(study, quick) if _sources() == sources else None


def _identity() -> tuple[str, str]:
    return _sources(), cpu()


@cache  # what this process has imported, not what was written since
def _sources() -> str:
    return digest_of_sources(("reports",), machine=False)


# Run studies without timings, and draw figures, in two parallel processes.
#
# Of the studies, one takes them from the front and the other from the back: neighbours need the
# same kernels, and where these are not compiled yet a process would wait for the other one.

WORKERS = 2
THREADS = "OPENBLAS_NUM_THREADS"
FEWEST = 4  # fewer studies do not repay the start of the processes
MANY = 16  # and fewer figures


def study_in_workers(
    studies: Mapping[str, Callable[[bool], pd.DataFrame]], quick: bool
) -> Generator[tuple[str, pd.DataFrame, float], None, None]:
    """Yield (name, frame, seconds) of each study as it finishes; studies that raise are omitted.

    Yields nothing for fewer than FEWEST studies or on a single processor. The worker processes end
    with the iterator, and with this process.
    """
    if len(studies) < FEWEST or processors() < WORKERS:
        return
    others, left = active_children(), deque(studies)
    running: dict[Future[tuple[pd.DataFrame, float] | None], tuple[str, ProcessPoolExecutor]] = {}
    with ExitStack() as stack:
        front, back = (
            stack.enter_context(ProcessPoolExecutor(1, get_context("spawn"), _begin))
            for _ in range(WORKERS)
        )

        def begin(worker: ProcessPoolExecutor) -> None:
            """Its next study, if there is one; after its death the rest is left out, or the
            other's."""
            if left:
                name = left.popleft() if worker is front else left.pop()
                with suppress(BrokenProcessPool):
                    running[worker.submit(timed, studies[name], quick)] = name, worker

        try:
            with _one_thread_each():
                begin(front)
                begin(back)
            while running:
                for future in first_of(running, return_when=FIRST_COMPLETED).done:
                    name, worker = running.pop(future)
                    begin(worker)
                    result = None if future.exception() else future.result()
                    if result is not None:
                        yield name, *result
        except BaseException:  # the iterator is closed, or the build is interrupted
            for process in active_children():
                if process not in others:
                    process.kill()
            raise


def map_in_workers(function: Callable[[Any], Any], jobs: Sequence[Any]) -> list[Any]:
    """``list(map(function, jobs))``, in two processes where there are enough jobs that can be
    pickled, in this one otherwise."""
    if len(jobs) < MANY or processors() < WORKERS or not _sent(jobs):
        return list(map(function, jobs))
    pool = ProcessPoolExecutor(WORKERS, get_context("spawn"), _begin)
    try:
        with _one_thread_each():
            return list(pool.map(function, jobs))
    finally:
        pool.shutdown(cancel_futures=True)


def _sent(jobs: Sequence[Any]) -> bool:
    try:
        return bool(pickle.dumps(jobs))
    except (pickle.PicklingError, AttributeError, TypeError):  # as of a lambda
        return False


@contextmanager
def _one_thread_each() -> Iterator[None]:
    """OpenBLAS in processes that begin in this context has one thread: both have a processor."""
    before = os.environ.get(THREADS)
    os.environ[THREADS] = "1"
    try:
        yield
    finally:
        del os.environ[THREADS]
        if before is not None:
            os.environ[THREADS] = before


def timed(study: Callable[[bool], pd.DataFrame], quick: bool) -> tuple[pd.DataFrame, float] | None:
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
    wait([parent_process().sentinel])
    os._exit(1)

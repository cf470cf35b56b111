"""Which members are run together, and by whom: threads, or an executor of the caller."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from typing import Any

from galvi.ensembles.chunk import Chunk, Kept, run_chunk
from galvi.fast.lanes.vectors import LANES
from galvi.input_checks import shown

PROBE = 8 * LANES  # members of the first chunk, which is measured
SECONDS = 1.0  # of a chunk
SHARES = 4  # chunks for each worker, so that none waits long for the last,
LEAST = 2e-3  # unless they take fewer seconds than this
LARGEST = 2**26  # bytes that a chunk's arrays may have
AHEAD = 2  # chunks that wait, for each worker


def members_of_a_chunk(seconds: float, size: float, members: int, workers: int) -> int:
    """How many members make a chunk.

    seconds  that one member takes
    size     bytes that one member needs
    """
    shares = min(SHARES, max(1, int(seconds * members / (LEAST * workers))))
    most = min(SECONDS / max(seconds, 1e-12), LARGEST / size, members / (shares * workers))
    return max(PROBE, LANES * math.ceil(most / LANES))


def results(chunks: Iterator[Chunk], executor: Any, workers: int) -> Iterator[tuple[Chunk, Kept]]:
    """Each chunk with what it leaves, in order; chunks are made as they are needed.

    executor  something with ``submit``, such as that of concurrent.futures or Dask's client; None:
              threads of this process
    """
    if executor is not None:
        yield from _in_order(chunks, lambda chunk: executor.submit(run_chunk, chunk), workers)
        return
    over = False
    with ThreadPoolExecutor(workers) as pool:
        try:
            yield from _in_order(
                chunks, lambda chunk: pool.submit(run_chunk, chunk, lambda: over), workers
            )
        finally:
            over = True  # the pool waits for its threads


def _in_order(
    chunks: Iterator[Chunk], submit: Callable[[Chunk], Any], workers: int
) -> Iterator[tuple[Chunk, Kept]]:
    waiting: deque[tuple[Chunk, Any]] = deque()
    try:
        for chunk in chunks:
            waiting.append((chunk, submit(chunk)))
            while len(waiting) >= AHEAD * workers:
                one, future = waiting.popleft()
                yield one, future.result()
        while waiting:
            one, future = waiting.popleft()
            yield one, future.result()
    finally:
        for _, future in waiting:
            future.cancel()


def workers_of(executor: Any, own: int) -> int:
    """How many chunks run at the same time; ``own`` is the number of this process's threads."""
    if executor is None:
        return own
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor must have a method submit, as those of concurrent.futures and Dask's Client "
            f"do; received {shown(executor)}."
        )
    threads = getattr(executor, "nthreads", None)  # of Dask: worker -> threads
    if callable(threads):
        return max(1, sum(threads().values()))
    return int(getattr(executor, "_max_workers", own))

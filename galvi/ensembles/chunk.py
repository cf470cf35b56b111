"""Chunks of an ensemble: consecutive members that one thread of this process, or a task of the
caller's executor, runs together."""

from __future__ import annotations

import math
import time
from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.ensembles.keep import Keep, TimeGrid
from galvi.ensembles.member_laws import Law, LawNumbers, kernel_of
from galvi.input_checks import shown
from galvi.kernels.compile.function_pointers import addresses
from galvi.lanes.loops import STEP_OF_LAW, compiled_advance_members
from galvi.lanes.vectors import LANES
from galvi.method import Galerkin
from galvi.run.in_lanes.law_kernel import words_of
from galvi.run.in_lanes.tables import aligned


class Batch:
    """n members of one law and their states, which `advance` changes.

    Parameters
    ----------
    law, numbers
        the law, and its numbers for each member
    method
        the method of all members
    step : array, shape (n,)
        step size of each member
    t0
        time of the start
    q, v, p
        starts (n, r), (n, d), (n, d); p are the momenta of the law
    tolerance
        relative change at which an iteration stops

    Notes
    -----
    The numbers of a member do not depend on the other members.
    """

    def __init__(
        self,
        law: Law,
        numbers: LawNumbers,
        method: Galerkin,
        step: Array,
        t0: float,
        q: Array,
        v: Array,
        p: Array,
        tolerance: float,
    ) -> None:
        self.count, self.law, self.numbers = len(q), law, numbers
        s, constants, kernel = method.stages, numbers.constants, kernel_of(law, method)
        self.fields, self.kernel = kernel.fields, kernel
        self.blocks = -(-self.count // LANES)
        rows, c = self.fields.rows(s), max(constants.shape[1], 1)
        self.records, self.constants = aligned((self.blocks, rows, LANES), (self.blocks, c, LANES))
        self.constants[:, : constants.shape[1]] = self._in_lanes(constants)
        fields_at_start = {
            "q": q,
            "p": p,
            "step": step[:, None],
            "start": np.full((1, 1), t0),
            "alive": np.ones((1, 1)),
            **kernel.memory(q, p),
        }
        for name, values in fields_at_start.items():
            first = self.fields.first[name]
            self.records[:, first : first + values.shape[1]] = self._in_lanes(values)
        if not kernel.positions_only:
            self.records[:, self.fields.velocities :] = np.repeat(self._in_lanes(v), s, axis=1)
        self.reals = np.append(kernel.tables.growth, tolerance)
        (self.work,) = aligned((kernel.rows, s, LANES))
        self.words = words_of(self.records, self.constants, self.work, kernel.tables, self.reals, s)
        self.law_address = int(addresses((kernel.function, STEP_OF_LAW))[0])
        self.advance_all, self.steps_done = compiled_advance_members(), 0

    def advance(self, steps: int) -> None:
        """Do ``steps`` more steps of all members that have not failed."""
        self.advance_all(
            self.law_address,
            self.words.ctypes.data,
            self.words,
            self.records,
            self.constants,
            self.work,
            self.kernel.velocities,
            self.fields.velocities,
            self.steps_done,
            steps,
        )
        self.steps_done += steps

    def field(self, name: str, size: int = 1) -> Array:
        """A field of the records, (n, size)."""
        first = self.fields.first[name]
        rows = self.records[:, first : first + size]
        return np.ascontiguousarray(rows.transpose(0, 2, 1)).reshape(-1, size)[: self.count]

    def states(self) -> tuple[Array, Array]:
        """The current configurations (n, r) and conjugate momenta (n, d); NaN for a member that
        failed."""
        q, p = self.field("q", self.law.entries), self.field("p", self.law.dimension)
        p = self.numbers.momenta(p)
        failed = self.failed > 0
        q[failed], p[failed] = np.nan, np.nan
        return q, p

    @property
    def failed(self) -> Any:
        """The step (n,) at which each member failed; 0 for none."""
        return self.field("failed")[:, 0].astype(np.int64)

    @property
    def passes(self) -> Any:
        """The number (n,) of passes in all steps of each member."""
        return self.field("passes")[:, 0].astype(np.int64)

    def _in_lanes(self, values: Array) -> Array:
        """Values (1 or n, k) as (blocks, k, 8); the last one is repeated in spare lanes."""
        index = np.minimum(np.arange(self.blocks * LANES), len(values) - 1)
        return values[index].reshape(self.blocks, LANES, -1).transpose(0, 2, 1)


INTERRUPT_SECONDS = 0.1  # intended seconds of a call of the kernel, between two checks for Ctrl-C


@dataclass(frozen=True, eq=False)
class Chunk:
    """Starts, numbers and plan of n members, which can be pickled.

    Attributes
    ----------
    first
        number of the first member
    q, v : array, shape (n, ...)
        starts
    """

    law: Law
    numbers: LawNumbers
    method: Galerkin
    plan: TimeGrid
    tolerance: float
    keep: Keep
    first: int
    q: Array
    v: Array


class ChunkRun(NamedTuple):
    """The results of a chunk.

    Attributes
    ----------
    values
        kept arrays, with the members in front
    failed : array, shape (n,)
        the first step that lanes could not solve; 0 for none
    passes : array, shape (n,)
        numbers of passes in all steps
    seconds
        duration of the steps
    """

    values: tuple[Array, ...]
    failed: Any
    passes: Any
    seconds: float


class Stopped(Exception):
    """The ``stopped`` of `run_chunk` returned True."""


def run_chunk(chunk: Chunk, stopped: Callable[[], bool] | None = None) -> ChunkRun:
    """Run the members of a chunk.

    Parameters
    ----------
    stopped
        () -> whether to raise `Stopped`; None: never
    """
    plan, law = chunk.plan, chunk.law
    n, d = len(chunk.q), law.dimension
    q, v = chunk.q.reshape(n, law.entries), chunk.v.reshape(n, d)
    momenta = v if law.in_velocity else law.momenta(q, v, plan.t0, chunk.numbers.constants)
    batch = Batch(
        law, chunk.numbers, chunk.method, plan.step, plan.t0, q, v, momenta, chunk.tolerance
    )
    batch.advance(0)  # compiles the kernel, or loads it, before the time is taken
    record, steps_at_once = chunk.keep.begin(plan), 1
    begin = time.perf_counter()
    for k in chunk.keep.steps(plan):
        while batch.steps_done < k:
            if stopped is not None and stopped():
                raise Stopped
            steps_now, begin_seconds = min(steps_at_once, k - batch.steps_done), time.perf_counter()
            batch.advance(steps_now)
            seconds_per_step = (time.perf_counter() - begin_seconds) / steps_now
            steps_at_once = max(
                1, min(2 * steps_at_once, int(INTERRUPT_SECONDS / max(seconds_per_step, 1e-9)))
            )
        states = batch.states()
        record.see(
            k,
            plan.t0 + k * plan.step,
            states[0].reshape(n, *plan.q_shape),
            states[1].reshape(n, *plan.p_shape),
        )
    seconds = time.perf_counter() - begin
    return ChunkRun(record.result(), batch.failed, batch.passes, seconds)


PROBE = 8 * LANES  # members of the first chunk, whose time is measured
CHUNK_SECONDS = 1.0  # largest intended seconds of a chunk
CHUNKS_PER_WORKER = 4  # least number of chunks for each worker, so that all end about together
LEAST_CHUNK_SECONDS = 2e-3  # seconds of a chunk, below which there are fewer chunks
CHUNK_BYTES = 2**26  # largest number of bytes in a chunk's arrays
CHUNKS_AHEAD = 2  # submitted chunks for each worker


def members_of_a_chunk(seconds: float, size: float, members: int, workers: int) -> int:
    """The number of members of a chunk.

    Parameters
    ----------
    seconds
        seconds of one member
    size
        bytes of one member
    """
    chunks_per_worker = min(
        CHUNKS_PER_WORKER, max(1, int(seconds * members / (LEAST_CHUNK_SECONDS * workers)))
    )
    limit = min(
        CHUNK_SECONDS / max(seconds, 1e-12),
        CHUNK_BYTES / size,
        members / (chunks_per_worker * workers),
    )
    return max(PROBE, LANES * math.ceil(limit / LANES))


def run_chunks(
    chunks: Iterator[Chunk], executor: Any, workers: int
) -> Iterator[tuple[Chunk, ChunkRun]]:
    """Each chunk with its run, in order; chunks are made as they are needed.

    Parameters
    ----------
    executor
        an object with ``submit``, such as an executor of concurrent.futures or Dask's client; None:
        threads of this process
    """
    if executor is not None:
        yield from _in_order(chunks, lambda chunk: executor.submit(run_chunk, chunk), workers)
        return
    is_over = False
    with ThreadPoolExecutor(workers) as pool:
        try:
            yield from _in_order(
                chunks, lambda chunk: pool.submit(run_chunk, chunk, lambda: is_over), workers
            )
        finally:
            is_over = True  # the pool waits for its threads


def _in_order(
    chunks: Iterator[Chunk], submit: Callable[[Chunk], Any], workers: int
) -> Iterator[tuple[Chunk, ChunkRun]]:
    waiting: deque[tuple[Chunk, Any]] = deque()
    try:
        for chunk in chunks:
            waiting.append((chunk, submit(chunk)))
            while len(waiting) >= CHUNKS_AHEAD * workers:
                oldest, future = waiting.popleft()
                yield oldest, future.result()
        while waiting:
            oldest, future = waiting.popleft()
            yield oldest, future.result()
    finally:
        for _, future in waiting:
            future.cancel()


def workers_of(executor: Any, local_threads: int) -> int:
    """The number of chunks that run at the same time; ``local_threads`` without an executor, or
    where it does not state a number. TypeError for an executor without ``submit``."""
    if executor is None:
        return local_threads
    if not callable(getattr(executor, "submit", None)):
        raise TypeError(
            f"executor must have a method submit, as those of concurrent.futures and Dask's Client "
            f"do; received {shown(executor)}."
        )
    threads = getattr(executor, "nthreads", None)  # of Dask: worker -> threads
    if callable(threads):
        return max(1, sum(threads().values()))
    return int(getattr(executor, "_max_workers", local_threads))

"""A few members of an ensemble, run by one thread: the unit of work that travels."""

from __future__ import annotations

import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, NamedTuple

from galvi.arrays import Array
from galvi.ensembles.batch import Batch
from galvi.ensembles.keep import Keep, TimeGrid
from galvi.ensembles.laws import Law, LawNumbers
from galvi.method import Galerkin

CALL_SECONDS = 0.1  # of a call of the kernel, after which Ctrl-C is looked at


@dataclass(frozen=True, eq=False)
class Chunk:
    """Starts, numbers and plan of n members; nothing in it is a compiled function.

    first  number of the first member
    q, v   (n, ...) starts
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


class Kept(NamedTuple):
    """What a chunk leaves.

    values   arrays with the members in front
    failed   (n,) the step at which lanes could not solve a member's step, 0 for none
    passes   (n,) passes of the iterations
    seconds  that the steps took
    """

    values: tuple[Array, ...]
    failed: Any
    passes: Any
    seconds: float


class Stopped(Exception):
    """A chunk was not finished, since ``stopped`` said so."""


def run_chunk(chunk: Chunk, stopped: Callable[[], bool] | None = None) -> Kept:
    """Run the members of a chunk.

    stopped  says whether to end at once, by `Stopped`
    """
    plan, law = chunk.plan, chunk.law
    n, d = len(chunk.q), law.dimension
    q, v = chunk.q.reshape(n, law.entries), chunk.v.reshape(n, d)
    momenta = v if law.in_velocity else law.momenta(q, v, plan.t0, chunk.numbers.constants)
    batch = Batch(
        law, chunk.numbers, chunk.method, plan.step, plan.t0, q, v, momenta, chunk.tolerance
    )
    batch.advance(0)  # compiles, or loads what was compiled
    record, at_once = chunk.keep.begin(plan), 1
    begin = time.perf_counter()
    for k in chunk.keep.steps(plan):
        while batch.done < k:
            if stopped is not None and stopped():
                raise Stopped
            todo, clock = min(at_once, k - batch.done), time.perf_counter()
            batch.advance(todo)
            pace = (time.perf_counter() - clock) / todo
            at_once = max(1, min(2 * at_once, int(CALL_SECONDS / max(pace, 1e-9))))
        states = batch.states()
        record.see(
            k, plan.t0 + k * plan.step, states[0].reshape(n, *plan.q_shape),
            states[1].reshape(n, *plan.p_shape),
        )  # fmt: skip
    seconds = time.perf_counter() - begin
    return Kept(record.result(), batch.failed, batch.passes, seconds)

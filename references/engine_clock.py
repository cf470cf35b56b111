"""The seconds that an engine itself takes in a run, without conversions and checks of ours.

References call their engine inside ``with engine_time:``; who times a run does it inside
``with heard() as spent:`` and reads ``spent.seconds``, 0 for a contender that does not say.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType


class Spent:
    """Seconds that engines took so far."""

    def __init__(self) -> None:
        self.seconds = 0.0


class EngineTime:
    """Adds the time of its block, in which no other of its kind begins, to what is heard."""

    def __init__(self) -> None:
        self.listening: list[Spent] = []
        self.begun = 0.0

    def __enter__(self) -> None:
        self.begun = time.perf_counter()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        seconds = time.perf_counter() - self.begun
        for spent in self.listening:
            spent.seconds += seconds


engine_time = EngineTime()


@contextmanager
def heard() -> Iterator[Spent]:
    """What engines take inside the block."""
    spent = Spent()
    engine_time.listening.append(spent)
    try:
        yield spent
    finally:
        engine_time.listening.remove(spent)

"""The seconds spent inside an engine during a run, without the conversions and checks around it.

References call their engine inside ``with engine_time:``. To time a run, wrap it in ``with heard()
as spent:`` and read ``spent.seconds``, which is 0 for a contender without `engine_time`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType


class Spent:
    """Seconds spent in engines."""

    def __init__(self) -> None:
        self.seconds = 0.0


class EngineTime:
    """Adds the duration of its block to every open `heard`; blocks must not nest."""

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
    """Yields the `Spent` that adds up the time in engines inside the block."""
    spent = Spent()
    engine_time.listening.append(spent)
    try:
        yield spent
    finally:
        engine_time.listening.remove(spent)

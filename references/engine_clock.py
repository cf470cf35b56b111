"""The seconds spent inside an engine during a run, without the conversions and checks around it.

References call their engine inside ``with engine_time:``. To time a run, wrap it in ``with
timed_engines() as elapsed:`` and read ``elapsed.seconds``, which is 0 for a contender without
`engine_time`.
"""

from __future__ import annotations

import time
from collections.abc import Iterator
from contextlib import contextmanager
from types import TracebackType


class EngineSeconds:
    """Seconds spent in engines."""

    def __init__(self) -> None:
        self.seconds = 0.0


class EngineTime:
    """Adds the duration of its block to every open `timed_engines`; blocks must not nest."""

    def __init__(self) -> None:
        self.open_timers: list[EngineSeconds] = []
        self.started_at = 0.0

    def __enter__(self) -> None:
        self.started_at = time.perf_counter()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        seconds = time.perf_counter() - self.started_at
        for spent in self.open_timers:
            spent.seconds += seconds


engine_time = EngineTime()


@contextmanager
def timed_engines() -> Iterator[EngineSeconds]:
    """Yields the `EngineSeconds` that sum up the time in engines inside the block."""
    spent = EngineSeconds()
    engine_time.open_timers.append(spent)
    try:
        yield spent
    finally:
        engine_time.open_timers.remove(spent)

"""Time a run of three planets with its transits found, and IAS15 with bisection beside it."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.studies.transits import PARTICIPANTS, YEAR, three_planets
from benchmarks.timings.annotate import TIMER, annotate, timed

YEARS = 20.0
FOUND = {"galvi degree 8, Gauss 8": PARTICIPANTS[1], "REBOUND IAS15": PARTICIPANTS[3]}


@pytest.mark.quick
@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize("name", FOUND)
def test_transits(benchmark: Any, name: str) -> None:
    contender, settings, times, missing = FOUND[name]
    assert contender == name
    if missing():
        pytest.skip(missing())
    found = timed(benchmark, lambda: times(YEARS * YEAR))
    counts = {"transits": sum(map(len, found))}
    assert counts["transits"] == 69
    annotate(
        benchmark,
        problem=three_planets().name,
        error=None,
        counts=counts,
        status="",
        settings={"contender": name, "settings": settings, "years": YEARS},
        kind="reference",
    )

"""Time runs with forces: of the outer planets by galvi and with REBOUNDx, of an arm's actuators."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.timings.annotate import TIMER, annotate, timed
from benchmarks.timings.forced_runs import calls

CALLS = {
    f"{group}: {name}": (group, name, *members[name])
    for group, members in calls().items()
    for name in members
}
QUICK = "galvi, outer planets: J2"


@pytest.mark.benchmark(timer=TIMER)
@pytest.mark.parametrize(
    "which", [pytest.param(one, marks=[pytest.mark.quick] * (one == QUICK)) for one in CALLS]
)
def test_a_run_with_a_force(benchmark: Any, which: str) -> None:
    group, name, call, steps = CALLS[which]
    found = timed(benchmark, call)
    ours = group.startswith("galvi")
    assert not ours or found.success, found.status
    annotate(
        benchmark,
        problem=group,
        error=None,
        counts=dict(found.counts) if ours else {"steps": steps},
        status=found.status if ours else "",
        settings={"force": name, "steps": steps},
        kind="trajectory" if ours else "reference",
    )

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
    "which", [pytest.param(case, marks=[pytest.mark.quick] * (case == QUICK)) for case in CALLS]
)
def test_a_run_with_a_force(benchmark: Any, which: str) -> None:
    group, name, call, steps = CALLS[which]
    run = timed(benchmark, call)
    is_galvi = group.startswith("galvi")
    assert not is_galvi or run.success, run.status
    annotate(
        benchmark,
        problem=group,
        error=None,
        counts=dict(run.counts) if is_galvi else {"steps": steps},
        status=run.status if is_galvi else "",
        settings={"force": name, "steps": steps},
        kind="trajectory" if is_galvi else "reference",
    )

"""The runs with forces that are timed move as their names say, by the engine that is meant."""

from __future__ import annotations

import numpy as np
import pytest

from benchmarks.timings import forced_runs


@pytest.mark.slow(
    beside="tests/properties/test_celestial_forces.py::test_the_energy_with_the_forces_is_kept_and_without_them_is_not"
)
def test_runs_with_forces_are_timed_with_what_they_name(monkeypatch) -> None:
    for name in ("STEPS", "ARM_STEPS", "SLOW_STEPS"):
        monkeypatch.setattr(forced_runs, name, 2)
    groups = forced_runs.calls()
    in_lanes = {name: call() for name, (call, _) in groups["galvi, outer planets"].items()}
    assert {run.engine for run in in_lanes.values()} == {"lanes"}
    framed, clocked = (
        {name: call() for name, (call, _) in groups[f"galvi, {engine}"].items()}
        for engine in forced_runs.OTHER_COORDINATES
    )
    assert {run.engine for run in framed.values()} == {"frame"}
    assert {run.engine for run in clocked.values()} == {"clock"}
    arms = {name: call() for name, (call, _) in groups["galvi, arm of three hinges"].items()}
    for runs in (in_lanes, framed, clocked, arms):
        plain = runs.pop(forced_runs.NONE)
        assert all(np.any(run.q[-1] != plain.q[-1]) for run in runs.values())

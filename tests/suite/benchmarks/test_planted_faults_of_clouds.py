"""The claim about the brownout cloud tells what it could not compare, and what its bound says."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.applications.brownout import cloud as model
from benchmarks.applications.brownout.cloud import BY_REYNOLDS, DIAMETERS
from benchmarks.applications.brownout.flights import FAILED, Flights
from benchmarks.applications.brownout.step_errors import COMPARED, UNSOLVED
from benchmarks.checks.bounds import CONTRADICTED, NOT_RUN
from benchmarks.claims.vector_spaces import v25_brownout_cloud as v25
from benchmarks.measures.refinement import collocation
from tests.suite.benchmarks.planted_tables import CLAIM, rows
from tests.suite.benchmarks.quick_studies import quick

FOLLOW = model.follow
V25 = CLAIM["V25"]


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_a_grain_that_was_not_solved_is_counted_and_its_run_not_compared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    def one_fails(*given: Any, **how: Any) -> Flights:
        run = FOLLOW(*given, **how)
        if round(6.0 / given[6]) != 192:
            return run
        status, q = run.status.copy(), run.q.copy()
        status[3], q[3] = FAILED, np.nan
        return replace(run, status=status, q=q)

    monkeypatch.setattr(v25, "QUICK_SAMPLED", 100)
    monkeypatch.setattr(model, "follow", one_fails)
    for name in ("paths", "balances", "places"):
        monkeypatch.setattr(v25, name, lambda *given: [])
    found = rows(V25)
    counted = next(row for row in found if row.quantity == f"{UNSOLVED}, all runs compared")
    of_runs = sum(192 in several for several in COMPARED.values())
    assert counted.verdict == CONTRADICTED
    assert counted.measured is not None and counted.measured >= of_runs * len(DIAMETERS)
    limit = next(row for row in found if "upper limit" in row.quantity)
    assert limit.verdict == NOT_RUN


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_without_a_rising_wind_no_grain_gets_above_the_bound() -> None:
    """Thrown upwards in still air: what the row on the highest place rules out."""
    still = "def wind(q, decay):\n    return 0.0, 0.0, 0.0\n"
    cloud = model.Cloud(DIAMETERS[-1], BY_REYNOLDS, np.arange(500))
    q, v, t = cloud.starts()
    law, rates = cloud.rates
    run = FOLLOW(
        collocation(galvi.Galerkin, 2), q, v, t, np.tile(rates, (500, 1)), law, 1 / 64, 6.0,
        gravity=9.80665, saves=24, wind=still,
    )  # fmt: skip
    assert np.nanmax(run.places[:, :, 2]) < v25.thrown()
    table = quick(V25)
    table.loc[table["quantity"] == v25.HIGHEST, "value"] = np.nanmax(run.places[:, :, 2])
    rows = V25.judge(table)
    assert next(row for row in rows if row.quantity == v25.HIGHEST).verdict == CONTRADICTED

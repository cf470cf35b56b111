"""The claim about the brownout cloud catches wrong flights, lost grains and missing impulses."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from benchmarks.applications.brownout import cloud as model
from benchmarks.applications.brownout.cloud import BY_REYNOLDS, DIAMETERS
from benchmarks.applications.brownout.flights import FAILED, WAITING, Flights
from benchmarks.applications.brownout.step_errors import COMPARED, UNSOLVED
from benchmarks.checks.bounds import CONTRADICTED, FINDING, NOT_RUN
from benchmarks.claims.vector_spaces import v25_brownout_cloud as v25
from benchmarks.claims.vector_spaces.v25_brownout_cloud import ALONE, HIGHEST, LOST, PUSHED, V25
from references.textbook.grain_flights import landings
from tests.benchmarks.planted_tables import contradicted, rows
from tests.benchmarks.quick_studies import quick

FOLLOW = model.follow
KNOWN: dict[Any, Any] = {}


def truth(problem: Any, *given: Any, **how: Any) -> Any:
    """The reference's landings, computed once."""
    key = problem.name, len(given[0]), *how.items(), *problem.parameters
    if key not in KNOWN:
        KNOWN[key] = landings(problem, *given, **how)
    return KNOWN[key]


@pytest.mark.slow(beside="test_a_wrong_flight_is_caught_by_the_truth")
def test_the_verdicts_are_those_expected() -> None:
    verdicts = {row.quantity: row.verdict for row in V25.judge(quick(V25))}
    assert set(verdicts.values()) == {FINDING}, verdicts


def drag_too_strong(*given: Any, **how: Any) -> Flights:
    """By a thousandth."""
    given = (*given[:4], given[4] * np.array([1.001, *np.ones(given[4].shape[1] - 1)]), *given[5:])
    return FOLLOW(*given, **how)


def late_grains(*given: Any, **how: Any) -> Flights:
    """They start a thousandth of a second late."""
    return FOLLOW(*given[:3], given[3] + 1e-3, *given[4:], **how)


def contacts_by_the_curve(*given: Any, **how: Any) -> Flights:
    """The moment of a contact is the root of the curve of the whole step."""
    return FOLLOW(*given, **{**how, "ground": replace(how["ground"], exact=False)})


@pytest.mark.parametrize("wrong", [drag_too_strong, late_grains, contacts_by_the_curve])
def test_a_wrong_flight_is_caught_by_the_truth(
    wrong: Callable[..., Flights], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(model, "follow", wrong)
    found = contradicted(_only_paths(monkeypatch))
    assert any("N = 2, 400 micrometres" in quantity for quantity in found)


def _only_paths(monkeypatch: pytest.MonkeyPatch) -> Any:
    """The claim without balances, pictures and statistics, of grains that are not too stiff."""
    monkeypatch.setattr(v25, "DIAMETERS", (200e-6, 400e-6))
    monkeypatch.setattr(v25, "landings", truth)
    for name in ("_balances", "step_errors", "_places"):
        monkeypatch.setattr(v25, name, lambda *given: [])
    return V25


def lost(run: Flights) -> Flights:
    """One grain has gone."""
    status = run.status.copy()
    status[0] = WAITING
    return replace(run, status=status)


def unpushed(run: Flights) -> Flights:
    """The ground pushes no grain."""
    return replace(run, contact=0.0 * run.contact)


def unrecorded(run: Flights) -> Flights:
    """The drag of one grain is not counted."""
    drag = run.drag.copy()
    drag[0] = 0.0
    return replace(run, drag=drag)


@pytest.mark.parametrize(
    ("change", "quantity"), [(lost, LOST), (unpushed, PUSHED), (unrecorded, PUSHED)]
)
def test_a_balance_that_does_not_close_is_caught(
    change: Callable[[Flights], Flights], quantity: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(v25, "QUICK_SAMPLED", 200)
    monkeypatch.setattr(model, "follow", lambda *given, **how: change(FOLLOW(*given, **how)))
    for name in ("_paths", "step_errors", "_places"):
        monkeypatch.setattr(v25, name, lambda *given: [])
    found = contradicted(V25)
    assert any(one.startswith(quantity) for one in found), found


@pytest.mark.slow(beside="test_a_balance_that_does_not_close_is_caught")
def test_a_grain_that_was_not_solved_is_counted_and_its_run_not_compared(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """It used to make means NaN, which were dropped without a word."""

    def one_fails(*given: Any, **how: Any) -> Flights:
        run = FOLLOW(*given, **how)
        if round(6.0 / given[6]) != 192:
            return run
        status, q = run.status.copy(), run.q.copy()
        status[3], q[3] = FAILED, np.nan
        return replace(run, status=status, q=q)

    monkeypatch.setattr(v25, "QUICK_SAMPLED", 100)
    monkeypatch.setattr(model, "follow", one_fails)
    for name in ("_paths", "_balances", "_places"):
        monkeypatch.setattr(v25, name, lambda *given: [])
    found = rows(V25)
    counted = next(row for row in found if row.quantity == f"{UNSOLVED}, all runs compared")
    of_runs = sum(192 in several for several in COMPARED.values())
    assert counted.verdict == CONTRADICTED and counted.measured >= of_runs * len(DIAMETERS)
    limit = next(row for row in found if "upper limit" in row.quantity)
    assert limit.verdict == NOT_RUN


def test_grains_that_touch_each_other_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each takes a little of its neighbour's place."""

    def leaking(*given: Any, **how: Any) -> Flights:
        run = FOLLOW(*given, **how)
        return replace(run, q=run.q + 1e-12 * np.roll(run.q, 1, axis=0))

    monkeypatch.setattr(v25, "QUICK_SAMPLED", 200)
    monkeypatch.setattr(model, "follow", leaking)
    for name in ("_paths", "step_errors", "_places"):
        monkeypatch.setattr(v25, name, lambda *given: [])
    assert ALONE in contradicted(V25)


@pytest.mark.slow(beside="test_a_wrong_flight_is_caught_by_the_truth")
def test_without_a_rising_wind_no_grain_gets_above_the_bound() -> None:
    """Thrown upwards in still air: what the row on the highest place rules out."""
    still = "def wind(q, decay):\n    return 0.0, 0.0, 0.0\n"
    cloud = model.Cloud(DIAMETERS[-1], BY_REYNOLDS, np.arange(500))
    q, v, t = cloud.starts()
    law, rates = cloud.rates
    run = FOLLOW(
        v25.collocation(v25.galvi.Galerkin, 2), q, v, t, np.tile(rates, (500, 1)), law, 1 / 64, 6.0,
        gravity=9.80665, saves=24, wind=still,
    )  # fmt: skip
    assert np.nanmax(run.places[:, :, 2]) < v25.thrown()
    table = quick(V25)
    table.loc[table["quantity"] == HIGHEST, "value"] = np.nanmax(run.places[:, :, 2])
    rows = V25.judge(table)
    assert next(row for row in rows if row.quantity == HIGHEST).verdict == CONTRADICTED

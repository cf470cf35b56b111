"""The energy of bodies walks at random where only rounding changes it, and a drift is seen."""

from __future__ import annotations

import pytest

import galvi
from benchmarks.experiments.body_round_off import energy_growth
from benchmarks.statistics.drift import Growth
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi.charts import CHARTS
from galvi.fast import law_stepper

FEW, MANY = 10_000, 100_000
SMALL, LARGE = 1e-18, 4e-18  # drifts in a step, relative, seen in many and in few steps


def growth_of_free_body(chart: object, steps: int, solver: str = "auto") -> Growth:
    method = gauss_collocation(12, chart).method
    return energy_growth(galvi.problems.free_rigid_body(), method, 0.5, steps, 12, solver)


@pytest.mark.parametrize(
    "chart, solver",
    [*((chart, "auto") for chart in CHARTS), (galvi.Exponential(), "newton")],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_free_body_has_no_drift_of_1e_18(chart: object, solver: str) -> None:
    found = growth_of_free_body(chart, FEW, solver)
    assert abs(found.drift) < 0.8 * SMALL, found
    assert found.drift_uncertainty < 0.25 * SMALL


def test_neither_has_one_that_also_moves() -> None:
    method = gauss_collocation(12).method
    found = energy_growth(galvi.problems.free_body_se3(), method, 0.25, FEW, 12)
    assert abs(found.drift) < 0.8 * SMALL, found


@pytest.mark.parametrize("steps, drift", [(FEW, LARGE), (MANY, SMALL)])
def test_a_drift_is_seen(steps: int, drift: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A weight too large by some units in its last place turns the body too far in each step."""
    sound = growth_of_free_body(galvi.Cayley(), steps)
    tables_of = law_stepper.group_law_tables

    def larger(table, step, lanes):  # type: ignore[no-untyped-def]
        tables, *others = tables_of(table, step, lanes)
        (planted,) = law_stepper.aligned(tables.shape)
        planted[:] = tables
        planted[4 * tables.shape[1], table.c.size // 2] += excess
        return planted, *others

    monkeypatch.setattr(law_stepper, "group_law_tables", larger)
    excess = 1e-15
    excess *= drift / growth_of_free_body(galvi.Cayley(), FEW).drift
    faulty = growth_of_free_body(galvi.Cayley(), steps)
    assert faulty.drifts and abs(faulty.drift) > 5.0 * faulty.drift_uncertainty
    assert abs(faulty.drift - drift) < 0.5 * drift
    assert not sound.drifts

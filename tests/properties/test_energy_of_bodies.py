"""The energy error of bodies is a random walk of rounding: a drift of 1e-18 a step would be seen.

Starts of an ensemble differ by 1e-12, so that each run rounds differently; the truncation errors of
the methods are below rounding. docs/why.md has what 300,000 steps show.
"""

from __future__ import annotations

import numpy as np
import pytest

import galvi
from benchmarks.statistics.drift import Growth, growth
from benchmarks.work_precision.galvi_methods import gauss_collocation
from galvi.charts import CHARTS
from galvi.run.in_lanes import lagrangian as law_stepper
from galvi.run.in_lanes.tables import aligned_copies

RUNS, SAMPLES, PERTURBATION, SEED = 12, 500, 1e-12, 1937
FEW, MANY = 10_000, 100_000
SMALL, LARGE = 1e-18, 4e-18  # drifts in a step, relative, seen in many and in few steps


def energy_growth(
    problem: galvi.Problem, method: galvi.Galerkin, step: float, steps: int, solver: str = "auto"
) -> Growth:
    """The growth of the relative energy error with the number of steps."""
    generator, errors = np.random.default_rng(SEED), []
    for _ in range(RUNS):
        v0 = problem.v0 * (1.0 + PERTURBATION * generator.standard_normal(problem.v0.shape))
        perturbed = galvi.Problem(problem.system, problem.q0, v0)
        save_every = max(1, steps // SAMPLES)
        run = galvi.integrate(perturbed, method, step, steps, save_every=save_every, solver=solver)
        assert run.success, run.status
        energy = galvi.energy(run)
        errors.append(energy / energy[0] - 1.0)
    return growth(run.t[1:] / step, np.array(errors)[:, 1:])


def growth_of_free_body(chart: object, steps: int, solver: str = "auto") -> Growth:
    method = gauss_collocation(12, chart).method
    return energy_growth(galvi.problems.free_rigid_body(), method, 0.5, steps, solver)


@pytest.mark.slow_cases(but=["modified Rodrigues-auto"])
@pytest.mark.parametrize(
    "chart, solver",
    [*((chart, "auto") for chart in CHARTS), (galvi.Exponential(), "newton")],
    ids=lambda value: getattr(value, "name", value),
)
def test_a_free_body_has_no_drift_of_1e_18(chart: object, solver: str) -> None:
    energy_error = growth_of_free_body(chart, FEW, solver)
    assert abs(energy_error.drift) < 0.8 * SMALL, energy_error
    assert energy_error.drift_uncertainty < 0.25 * SMALL


@pytest.mark.slow(beside="test_a_free_body_has_no_drift_of_1e_18")
def test_neither_has_one_that_also_moves() -> None:
    method = gauss_collocation(12).method
    energy_error = energy_growth(galvi.problems.free_body_se3(), method, 0.25, FEW)
    assert abs(energy_error.drift) < 0.8 * SMALL, energy_error


@pytest.mark.slow_cases("100000-1e-18")
@pytest.mark.parametrize("steps, drift", [(FEW, LARGE), (MANY, SMALL)])
def test_a_drift_is_seen(steps: int, drift: float, monkeypatch: pytest.MonkeyPatch) -> None:
    """A weight too large by some units in its last place turns the body too far in each step."""
    unchanged = growth_of_free_body(galvi.Cayley(), steps)
    tables_of = law_stepper.tables_on_group

    def with_larger_weight(table, form):  # type: ignore[no-untyped-def]
        arrays = tables_of(table, form)
        (faulty_table,) = aligned_copies(arrays.tables)
        faulty_table[4 * faulty_table.shape[1], table.c.size // 2] += excess
        return arrays._replace(tables=faulty_table)

    monkeypatch.setattr(law_stepper, "tables_on_group", with_larger_weight)
    excess = 1e-15
    excess *= drift / growth_of_free_body(galvi.Cayley(), FEW).drift
    faulty = growth_of_free_body(galvi.Cayley(), steps)
    assert faulty.drifts and abs(faulty.drift) > 5.0 * faulty.drift_uncertainty
    assert abs(faulty.drift - drift) < 0.5 * drift
    assert not unchanged.drifts

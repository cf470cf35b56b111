"""V33 accuses no true statement; what V33 and V34 measure with is what it is said to be."""

from __future__ import annotations

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Claim
from benchmarks.claims.vector_spaces import curves_beside_steps as curves
from benchmarks.claims.vector_spaces import noether_map
from benchmarks.claims.vector_spaces import v33_costs_and_step_lengths as v33
from benchmarks.claims.vector_spaces.kepler_orbit import problem
from benchmarks.measures.refinement import ENDS_AND_CURVE
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import frame, row
from references.closed_forms.kepler import KEPLER
from tests.suite.benchmarks.planted_tables import CLAIM
from tests.suite.benchmarks.quick_studies import quick

V33 = CLAIM["V33"]
# V33's quick study takes 7 s; other claims' tables show the same kinds of faults.
WHOLE_STUDY = pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")


def verdicts(claim: Claim, table: pd.DataFrame) -> dict[str, str]:
    return {one.quantity: one.verdict for one in claim.judge(table)}


# --- V33


def test_the_classical_runge_kutta_method_has_its_order() -> None:
    steps = np.array([64, 90, 128, 181, 256, 362, 512])
    exact = KEPLER.run(problem(), 2.0, {"samples": 1}).q[-1]
    ends = [
        v33.RK4.run(problem(), 2.0, {"step": 2.0 / k, "save_every": int(k)}).q[-1] for k in steps
    ]
    errors = [float(np.max(abs(end - exact))) for end in ends]
    fit = convergence_fits.algebraic((2.0 / steps).tolist(), errors, floor=1e-13)
    assert fit.rate == pytest.approx(4.0, abs=0.1)


@pytest.mark.parametrize(
    ("errors", "expected"),
    [
        ([1.0, 0.1, 1e-2, 1e-3], 2.0**-1.5),  # between 0.5 and 0.25, by the power law
        ([1e-3, 0.1, 1e-2, 1e-3], 2.0**-1.5),  # a coarse step that is accurate by chance
        ([1e-2, 1e-3, 1e-4, 1e-5], 1.0),
        ([np.nan, 1e-2, 1e-3, 1e-4], 0.5),
        ([1.0, 1.0, 1.0, 1.0], np.nan),
        ([1e-3, 1e-3, 1e-3, np.nan], np.nan),
    ],
)
def test_the_longest_accurate_step_is_found(errors: list[float], expected: float) -> None:
    steps = (1.0, 0.5, 0.25, 0.125)
    table = frame(
        row(quantity=v33.ERROR, label="any", step=h, value=error)
        for h, error in zip(steps, errors, strict=True)
    )
    limit = 10.0**-1.5
    assert v33.longest(table, "any", limit) == pytest.approx(expected, nan_ok=True)


@WHOLE_STUDY
def test_curves_that_keep_pace_are_not_accused() -> None:
    table = quick(V33)
    for steps in curves.FLOORS:
        ours = table["study"] == curves.IN_N % steps
        ends, curve = (table["quantity"] == name for name in ENDS_AND_CURVE)
        table.loc[ours & curve, "value"] = 2.5 * table.loc[ours & ends, "value"].to_numpy()
    found = verdicts(V33, table)
    name = "base of the step ends' error over the curve's"
    assert found[f"{name}, nearest to 1 over the numbers of steps"] == ATTAINED
    assert {found[f"{name}, {steps} steps"] for steps in curves.FLOORS} == {CONTRADICTED}


OWN = "largest curve error over that of step ends in h-refinement, least over n"
QUOTIENT = (
    "order of the angular momentum's error along the curve over the curve's own, largest over n"
)


@WHOLE_STUDY
@pytest.mark.parametrize(
    ("times", "verdict"), [(1.5, HOLDS), (5.0, CONTRADICTED), (20.0, NOT_REPRODUCED)]
)
def test_a_curve_whose_own_error_is_hidden_is_what_h_saw(times: float, verdict: str) -> None:
    table = quick(V33)
    tenth = table["study"] == "h-refinement, 10 steps"
    ends, curve = (tenth & (table["quantity"] == name) for name in ENDS_AND_CURVE)
    table.loc[curve, "value"] = times * table.loc[ends, "value"].to_numpy()
    assert verdicts(V33, table)[OWN] == verdict


@WHOLE_STUDY
@pytest.mark.parametrize(
    ("power", "verdict"), [(3.5, HOLDS), (1.5, CONTRADICTED), (0.0, NOT_REPRODUCED)]
)
def test_a_factor_of_another_order_is_seen(power: float, verdict: str) -> None:
    table = quick(V33)
    kept = (table["study"] == "h-refinement, 100 steps") & (
        table["quantity"] == "angular momentum error along the curve"
    )
    table.loc[kept, "value"] *= table.loc[kept, "step"] ** power
    assert verdicts(V33, table)[QUOTIENT] == verdict


# --- V34


def test_the_curve_is_that_of_the_run() -> None:
    """q'' from its values is the slope of its velocity."""
    run = galvi.integrate(problem(), galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(10)), 0.5, 1)
    step = noether_map.step_of(problem(), run, 10)
    assert step is not None
    t, apart = np.linspace(0.1, 0.4, 7), 1e-5
    slope = (run.velocity(t + apart) - run.velocity(t - apart)) / (2.0 * apart)
    assert step._bend(t) == pytest.approx(slope, abs=1e-8)
    assert step.a @ run.q[0] == 0.0

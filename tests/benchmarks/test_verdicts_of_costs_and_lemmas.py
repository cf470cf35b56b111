"""V33 and V34 catch wrong methods, truths, counts and formulas, and accuse no true statement."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, FINDING, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Claim
from benchmarks.claims.vector_spaces import curves_beside_steps as curves
from benchmarks.claims.vector_spaces import noether_map
from benchmarks.claims.vector_spaces import v33_costs_and_step_lengths as v33
from benchmarks.claims.vector_spaces import v34_lemmas_on_the_noether_map as v34
from benchmarks.claims.vector_spaces.kepler_orbit import problem
from benchmarks.claims.vector_spaces.v34_lemmas_on_the_noether_map import V34
from benchmarks.measures.refinement import ENDS_AND_CURVE
from benchmarks.statistics import convergence_fits
from benchmarks.store.frames import frame, row
from references.closed_forms.kepler import KEPLER
from tests.benchmarks.planted_tables import CLAIM, contradicted
from tests.benchmarks.quick_studies import quick

V33 = CLAIM["V33"]
# Quick studies of V33 and V34 take 7 and 11 s; other claims' tables show the same kinds of faults.
WHOLE_STUDY = pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")


def verdicts(claim: Claim, table: pd.DataFrame) -> dict[str, str]:
    return {one.quantity: one.verdict for one in claim.judge(table)}


def accused(claim: Claim, table: pd.DataFrame) -> set[str]:
    """Quantities whose verdict is not the one expected."""
    return {one.quantity for one in claim.judge(table) if one.verdict != one.expected}


def scaled(table: pd.DataFrame, by: Any, **where: Any) -> pd.DataFrame:
    chosen = np.full(len(table), True)
    for name, value in where.items():
        chosen &= (table[name] == value).to_numpy()
    assert chosen.any()
    table.loc[chosen, "value"] *= by
    return table


# --- V33


def test_the_classical_runge_kutta_method_has_its_order() -> None:
    steps = np.array([64, 90, 128, 181, 256, 362, 512])
    exact = KEPLER.run(problem(), 2.0, {"samples": 1}).q[-1]
    ends = [
        v33.RK4.run(problem(), 2.0, {"step": 2.0 / k, "save_every": int(k)}).q[-1] for k in steps
    ]
    errors = [float(np.max(abs(end - exact))) for end in ends]
    fit = convergence_fits.algebraic(2.0 / steps, errors, floor=1e-13)
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


@WHOLE_STUDY
def test_a_first_function_that_does_not_vanish_at_the_end_is_caught(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    right = v34.functions
    monkeypatch.setattr(
        v34,
        "functions",
        lambda n: {name: phi + 1e-3 * np.eye(n)[0] for name, phi in right(n).items()},
    )
    found = contradicted(V34)
    assert f"largest of {v34.SECOND}, all rules, phi_1, n and h" in found
    assert f"largest {v34.NOETHER}, all rules, phi_1, n and h" in found


@WHOLE_STUDY
def test_the_bound_without_integration_by_parts_needs_the_straight_line() -> None:
    table = quick(V34)
    hats = table["quantity"].eq(v34.PROVED) & table["label"].eq(v34.HATS)
    assert table.loc[hats, "value"].max() > 1.0
    table.loc[hats, "label"] = v34.LINE
    name = f"largest of {v34.PROVED}, phi_1 = {v34.LINE}, all rules, n and h"
    assert name in accused(V34, table)


@pytest.fixture
def no_generator() -> Iterator[None]:
    """a(q) of one that is no symmetry."""
    with pytest.MonkeyPatch.context() as patch:
        for module in (noether_map, v34):
            patch.setattr(module, "generator", lambda q: q * np.array([1.0, 0.0]))
        yield


@WHOLE_STUDY
@pytest.mark.usefixtures("no_generator")
def test_what_is_no_symmetry_is_not_kept() -> None:
    found = contradicted(V34)
    assert f"largest {v34.KEPT} on exact motions" in found
    assert f"largest of {v34.SECOND}, all rules, phi_1, n and h" in found


@WHOLE_STUDY
def test_local_motions_of_another_momentum_are_caught() -> None:
    """As if steps were handed on with a momentum that errs by as much as the bound allows."""
    table = scaled(quick(V34), 1e5, quantity=v34.GLOBAL)
    assert accused(V34, table) == {f"largest of {v34.GLOBAL}"}


@WHOLE_STUDY
def test_a_run_on_the_exact_ends_has_the_global_motion() -> None:
    table = scaled(quick(V34), 0.0, quantity=v34.FIRST)
    assert "|I(local motion) - I(start)| in the first step" in accused(V34, table)


@WHOLE_STUDY
@pytest.mark.parametrize(
    ("power", "quantity", "name"),
    [
        (
            -1.0,
            v34.LIPSCHITZ,
            "order of (|d| + |d'|) / |d''| in L^infinity, farthest from 1 over n",
        ),
        (1.0, v34.WHOLE, "order of |d|_W11 / (h |d'|_L^infinity), largest over n"),
    ],
)
def test_another_order_is_seen(power: float, quantity: str, name: str) -> None:
    table = quick(V34)
    own = table["quantity"] == quantity
    table.loc[own, "value"] *= table.loc[own, "step"] ** power
    assert name in accused(V34, table)


@WHOLE_STUDY
@pytest.mark.parametrize(
    ("by", "where", "name"),
    [
        (1e3, {"quantity": v34.PRINTED}, f"largest of {v34.PRINTED}, all rules, phi_1, n and h"),
        (1e3, {"quantity": v34.RULE, "study": v34.RICH}, f"largest {v34.RULE}, {v34.RICH}"),
        (0.5, {"quantity": v34.RULE}, f"largest {v34.RULE}, {v34.POOR}, phi_1 = {v34.HATS}"),
    ],
)
def test_sides_that_change_places_are_seen(by: float, where: dict[str, str], name: str) -> None:
    assert name in accused(V34, scaled(quick(V34), by, **where))


def test_the_curve_is_that_of_the_run() -> None:
    """q'' from its values is the slope of its velocity."""
    run = galvi.integrate(problem(), galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(10)), 0.5, 1)
    step = noether_map.step_of(problem(), run, 10)
    assert step is not None
    t, apart = np.linspace(0.1, 0.4, 7), 1e-5
    slope = (run.velocity(t + apart) - run.velocity(t - apart)) / (2.0 * apart)
    assert step._bend(t) == pytest.approx(slope, abs=1e-8)
    assert step.a @ run.q[0] == 0.0


@WHOLE_STUDY
def test_what_h_says_holds_and_what_is_ours_is_a_finding() -> None:
    assert set(verdicts(V34, quick(V34)).values()) == {HOLDS, FINDING}

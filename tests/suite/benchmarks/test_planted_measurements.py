"""Measurements planted in claims' quick studies get the right verdicts: false ones, such as a drift
of 5 %, are contradicted, and true ones are not."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, FINDING, HOLDS, NOT_REPRODUCED
from benchmarks.checks.claim import Claim
from benchmarks.checks.faults import times
from benchmarks.claims.vector_spaces import curves_beside_steps as curves
from benchmarks.claims.vector_spaces import v02_oscillator_energy as v02
from benchmarks.claims.vector_spaces import v07_momentum_along_curve as v07
from benchmarks.claims.vector_spaces import v14_curves_between_ends as v14
from benchmarks.claims.vector_spaces import v15_noether_quantities as v15
from benchmarks.claims.vector_spaces import v24_brownout_cost as v24
from benchmarks.claims.vector_spaces import v28_rates_at_finite_smoothness as v28
from benchmarks.claims.vector_spaces.kepler_orbit import fixed_number
from benchmarks.measures.boundary_motion import CURVE, ENDS
from benchmarks.measures.refinement import ENDS_AND_CURVE
from benchmarks.store.tables import row, table_of
from tests.suite.benchmarks.planted_tables import CLAIM
from tests.suite.benchmarks.quick_studies import quick

# Claims whose quick studies take more than a second or two.
SLOW = ("V2", "V15", "V33", "L8")
PLANTED_DRIFT = 0.05  # of the largest error
RAMPS: dict[str, Callable[[Any, Any], Any]] = {
    "rising": lambda errors, ramp: errors + PLANTED_DRIFT * np.max(np.abs(errors)) * ramp,
    "falling": lambda errors, ramp: errors - PLANTED_DRIFT * np.max(np.abs(errors)) * ramp,
    "widening": lambda errors, ramp: errors * (1.0 + PLANTED_DRIFT * ramp),
}


def verdicts(claim: Claim, table: pd.DataFrame) -> dict[str, str]:
    return {line.quantity: line.verdict for line in claim.check(table)}


def drifting(history: str, ramp: str, table: pd.DataFrame) -> None:
    """Halve the errors and add a drift: none exceeds the bound on the largest one."""
    rows = (table["study"] == "history") & (table["quantity"] == history)
    errors = table.loc[rows, "value"].to_numpy()
    table.loc[rows, "value"] = 0.5 * RAMPS[ramp](errors, np.linspace(0.0, 1.0, errors.size))


def curves_beside_ends(factor: float, studies: tuple[str, ...], table: pd.DataFrame) -> None:
    """Set errors of curves to a multiple of those of step ends."""
    for study in studies:
        ends, curve = (
            (table["study"] == study) & (table["quantity"] == name) for name in ENDS_AND_CURVE
        )
        table.loc[curve, "value"] = factor * table.loc[ends, "value"].to_numpy()


def gaining(gain: float, table: pd.DataFrame) -> None:
    """Set errors to h^(gain n + 2); H reads off a gain of one half."""
    selected = (table["quantity"] == v07.ANGULAR) & (table["study"] == fixed_number(100))
    h, n = (table.loc[selected, name].to_numpy(float) for name in ("step", "n"))
    table.loc[selected, "value"] = np.maximum((10.0 * h) ** (gain * n + 2.0), 1e-15)


def with_ms_own_n(table: pd.DataFrame) -> None:
    """Set the largest ratios to those with M's N in the place of N - 1."""
    named = table["quantity"].str.startswith("largest ratio")
    N = table.loc[named, "quantity"].str.rsplit(" ", n=1).str[-1].astype(float)
    table.loc[named, "value"] = (2.0 + 1.0 / N) ** 0.5


def of_the_printed_power(table: pd.DataFrame) -> None:
    best = table["quantity"] == v28.BEST
    s = np.where(table.loc[best, "study"].str.contains("b = -0.55"), 3.0, 2.0)
    table.loc[best, "value"] = 0.5 * (table.loc[best, "n"] - 1.0) ** -s


BASE = "base of the step ends' error over the curve's"
OWN = "largest curve error over that of step ends in h-refinement, least over n"
FACTOR = {
    "study": "h-refinement, 100 steps",
    "quantity": "angular momentum error along the curve",
}
QUOTIENT = (
    "order of the angular momentum's error along the curve over the curve's own, largest over n"
)
ALONG = f"error of {v15.ALONG}, over the largest of single steps from exact states"
IN_N = tuple(curves.IN_N % steps for steps in curves.FLOORS)
Plant = tuple[str, Callable[[pd.DataFrame], None], dict[str, str]]


def drifts(claim: str, history: str, quantity: str, *ramps: str) -> dict[str, Plant]:
    return {
        f"{claim}, {ramp}": (claim, partial(drifting, history, ramp), {quantity: CONTRADICTED})
        for ramp in ramps
    }


# (claim, change of its table, expected verdicts by the beginnings of quantities)
PLANTS: dict[str, Plant] = {
    **drifts("V2", v02.QUANTITY, "energy error, n = 14", "rising"),
    **drifts("V8", "energy error", "energy error, n = 8", "falling", "widening"),
    **drifts("V15", v15.ALONG, ALONG, "falling"),
    **drifts("L4", "energy error, n = 8", "energy error, n = 8", *RAMPS),
    **drifts("L8", "energy error", "energy error, n = 8", "widening"),
    "V7, as H reads it": (
        "V7",
        partial(gaining, 0.5),
        {f"what the order of the {v07.ANGULAR} gains with n, 100": ATTAINED},
    ),
    "V7, as measured": (
        "V7",
        partial(gaining, 1.0),
        {f"what the order of the {v07.ANGULAR} gains with n, 100": NOT_REPRODUCED},
    ),
    "V7, between": (
        "V7",
        partial(gaining, 0.75),
        {f"what the order of the {v07.ANGULAR} gains with n, 100": CONTRADICTED},
    ),
    "V21, with M's own N": ("V21", with_ms_own_n, {"largest ratio": HOLDS}),
    "V28, of the printed power": (
        "V28",
        of_the_printed_power,
        {
            "power of 1 / N": HOLDS,
            "largest departure of the power of 1 / N from 3/2 - b, t* inside": CONTRADICTED,
        },
    ),
    "V33, curves that keep pace": (
        "V33",
        partial(curves_beside_ends, 2.5, IN_N),
        {
            f"{BASE}, nearest to 1 over the numbers of steps": ATTAINED,
            **{f"{BASE}, {steps} steps": CONTRADICTED for steps in curves.FLOORS},
        },
    ),
    **{
        f"V33, curves {by} times off": (
            "V33",
            partial(curves_beside_ends, by, ("h-refinement, 10 steps",)),
            {OWN: verdict},
        )
        for by, verdict in ((1.5, HOLDS), (5.0, CONTRADICTED), (20.0, NOT_REPRODUCED))
    },
    **{
        f"V33, a factor h^{power}": ("V33", times(1.0, power, **FACTOR), {QUOTIENT: verdict})
        for power, verdict in ((3.5, HOLDS), (1.5, CONTRADICTED), (0.0, NOT_REPRODUCED))
    },
}


@pytest.mark.parametrize(
    "name",
    [pytest.param(name, marks=[pytest.mark.slow] * (PLANTS[name][0] in SLOW)) for name in PLANTS],
)
def test_a_planted_measurement_is_judged_as_it_deserves(name: str) -> None:
    claim, change, expected = PLANTS[name]
    table = quick(CLAIM[claim])
    change(table)
    by_quantity = verdicts(CLAIM[claim], table)
    for beginning, verdict in expected.items():
        assert {
            by_quantity[quantity] for quantity in by_quantity if quantity.startswith(beginning)
        } == {verdict}, beginning


@pytest.mark.parametrize(
    ("excess", "expected"),
    [(0.0, [CONTRADICTED, FINDING]), (0.5, [HOLDS, CONTRADICTED])],
    ids=["the root of C_f", "C_f"],
)
def test_the_printed_power_of_c_f_would_hold_if_it_were_so(
    excess: float, expected: list[str]
) -> None:
    """Curves of order n + 1/2 hold, and those of order n do not: no verdict is built in."""
    powers = {ENDS: lambda n: 2.0 * n - 1.0, CURVE: lambda n: n + excess}
    table = table_of(
        row(study=v14.COERCIVE, quantity=quantity, n=n, step=h, value=h ** power(n))
        for n in v14.NS
        for quantity, power in powers.items()
        for h in 2.0 ** -np.arange(2.0, 8.0)
    )
    by_quantity = verdicts(CLAIM["V14"], table)
    assert [
        by_quantity[quantity_name]
        for quantity_name in by_quantity
        if quantity_name.startswith("order of distance /")
    ] == expected


def test_no_verdict_about_the_cost_rests_on_a_time() -> None:
    table, random = quick(CLAIM["V24"]), np.random.default_rng(1)
    before = verdicts(CLAIM["V24"], table)
    chosen = table["quantity"].isin([v24.SECONDS, v24.FASTEST, v24.SLOWEST])
    table.loc[chosen, "value"] *= 1e3 * random.uniform(0.1, 10.0, chosen.sum())
    assert verdicts(CLAIM["V24"], table) == before

"""L17 and L18: verdicts that are not built in, and formulas, charts and actions gone wrong."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
import pandas as pd
import pytest

from benchmarks.checks.bounds import ATTAINED, CONTRADICTED, EXCEEDS, HOLDS
from benchmarks.claims.lie_groups import held_base, printed_formulas
from benchmarks.claims.lie_groups import l17_discrete_lagrangian as l17
from benchmarks.claims.lie_groups import l18_formulas_of_the_cayley_chart as l18
from benchmarks.claims.lie_groups.held_base import BodySteps, ScaledRotations
from benchmarks.claims.lie_groups.l17_discrete_lagrangian import L17
from benchmarks.claims.lie_groups.l18_formulas_of_the_cayley_chart import L18
from galvi.arrays import Array
from references.textbook.galerkin import cayley
from tests.benchmarks.planted_tables import contradicted, rows
from tests.benchmarks.quick_studies import quick

HELD = f"{l18.CHANGES[0]}, {l18.HELD} as printed, least over the rules, n = 3"
MOVED = f"largest {l18.CHANGES[1]}, {l18.MOVED}, all n and rules"
ACTIONS = {f"order of the {l17.ACTION}, {name}, n = {n}" for name in l17.CASES for n in l17.NS}


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """The shortest study of L18."""
    fewer = {"NS": (3,), "ORDERS": (), "SCALES": (10.0,), "STATES": 10, "STEPS": 1}
    for name, value in fewer.items():
        monkeypatch.setattr(l18, name, value)


def verdict(claim: Any, quantity: str, table: pd.DataFrame | None = None) -> str:
    found = rows(claim) if table is None else claim.judge(table)
    return next(row.verdict for row in found if row.quantity == quantity)


def changed(table: pd.DataFrame, values: Callable[[pd.DataFrame], Any], **where: Any) -> Any:
    """The frame with other values in these rows."""
    table, chosen = table.copy(), np.full(len(table), True)
    for name, value in where.items():
        chosen &= table[name] == value
    assert chosen.any()
    table.loc[chosen, "value"] = values(table[chosen])
    return table


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
def test_a_wrong_discrete_lagrangian_is_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    right = l17.discrete_lagrangian
    monkeypatch.setattr(l17, "discrete_lagrangian", lambda run: (1.0 + 1e-6) * right(run))
    found = contradicted(L17)
    assert found >= {quantity for quantity in ACTIONS if not quantity.endswith("n = 3")}
    assert any("leading term" in quantity for quantity in found)
    assert not any(l17.STEPPED in quantity for quantity in found)


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
@pytest.mark.parametrize("n", l17.STEADY_NS)
def test_another_constant_of_a_steady_turning_is_caught(
    n: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    table = quick(L17)
    monkeypatch.setattr(l17, "RATES", {k: 1.02 * rate for k, rate in l17.RATES.items()})
    name = f"order of the departure of {l17.ACTION} from its leading term, relative, "
    assert verdict(L17, f"{name}{l17.STEADY}, n = {n}", table) == CONTRADICTED


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
@pytest.mark.parametrize(("order", "expected"), [(4, ATTAINED), (3, CONTRADICTED), (7, EXCEEDS)])
def test_the_printed_order_can_be_met_and_missed(order: int, expected: str) -> None:
    table = changed(
        quick(L17), lambda rows: 0.01 * rows["step"] ** order,
        study=l17.PENDULUM, quantity=l17.ACTION, n=4,
    )  # fmt: skip
    name = f"order of the {l17.ACTION}, {l17.PENDULUM}, n = 4, against the bound"
    assert verdict(L17, name, table) == expected


@pytest.mark.slow(beside="test_faults.py::test_a_planted_fault_is_caught")
@pytest.mark.parametrize(
    ("power", "expected"), [(1, CONTRADICTED), (2, HOLDS), (0.5, CONTRADICTED)]
)
def test_an_error_that_is_not_the_square_of_the_best_approximation_is_caught(
    power: float, expected: str
) -> None:
    """Its first power still meets the printed bound."""
    sound, study = quick(L17), f"{l17.FREE}, {l17.IN_N}"
    best = sound[(sound["study"] == study) & (sound["quantity"] == l17.BEST)]["value"].to_numpy()
    table = changed(sound, lambda rows: best**power, study=study, quantity=l17.ACTION)
    square = f"power of the {l17.BEST} in the {l17.ACTION}, {l17.FREE}"
    base = f"base of the {l17.ACTION} against that of the best approximation, {l17.FREE}"
    assert (verdict(L17, square, table) == CONTRADICTED) == (expected == CONTRADICTED)
    assert verdict(L17, base, table) == (HOLDS if power >= 1 else CONTRADICTED)


@pytest.mark.usefixtures("few")
def test_formulas_that_are_right_are_not_accused(monkeypatch: pytest.MonkeyPatch) -> None:
    trace, slope = printed_formulas.trace_lagrangian, printed_formulas.changed_slope
    monkeypatch.setattr(l18, "AS_PRINTED", printed_formulas.IN_ORDER)
    monkeypatch.setattr(printed_formulas, "trace_lagrangian", lambda *given: 0.5 * trace(*given))
    monkeypatch.setattr(
        printed_formulas, "changed_slope", lambda a, b, printed: slope(a, b, printed=False)
    )
    monkeypatch.setattr(BodySteps, "matched", moving)
    found = {row.quantity: row.verdict for row in rows(L18)}
    names = (l18.PAIRS, l18.OF_PRINTED, l18.TRACE, l18.CHAIN)
    assert {found[name] for name in (*(f"{one}, departure" for one in names), HELD)} == {HOLDS}


def moving(body: BodySteps, x: Array, sums: Array, p: Array, first: Array) -> Array:
    """The momentum matched with the base moved, whatever is asked for."""
    return p - cayley(x[-1]) @ body.after(x, sums)


@pytest.mark.usefixtures("few")
def test_a_base_that_is_held_loses_momentum_wherever_it_is(monkeypatch: pytest.MonkeyPatch) -> None:
    made = l18.BodySteps
    monkeypatch.setattr(l18, "BodySteps", lambda *given: made(*given[:-1], True))
    assert contradicted(L18) == {MOVED}


@pytest.mark.usefixtures("few")
def test_slopes_that_are_slightly_wrong_are_caught(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = printed_formulas.stage_terms

    def wrong(moments: Array, xi: Array, rate: Array, value: Any, slope: Any) -> Array:
        return sound(moments, xi, rate, (1.0 + 1e-9) * value, slope)

    for module in (printed_formulas, held_base):
        monkeypatch.setattr(module, "stage_terms", wrong)
    found = contradicted(L18)
    assert {f"{l18.OF_ORDERED}, departure", f"{l18.MENDED}, departure", l18.STAGES} <= found


@pytest.mark.slow_cases(but=["velocity"])
@pytest.mark.usefixtures("few")
@pytest.mark.parametrize("part", ["carried", "velocity", "tangent"])
def test_a_chart_that_is_not_scaled_throughout_is_caught(
    part: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = getattr(ScaledRotations, part)
    monkeypatch.setattr(
        ScaledRotations, part, lambda chart, *given: sound(chart, *given) * (1.0 + 1e-9)
    )
    assert {f"largest {l18.SCALED}, {name}" for name in ("free", "pendulum")} <= contradicted(L18)

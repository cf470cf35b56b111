"""L18: verdicts that are not built in, and formulas and charts gone wrong."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.checks.bounds import HOLDS
from benchmarks.claims.lie_groups import held_base, printed_formulas
from benchmarks.claims.lie_groups import l18_formulas_of_the_cayley_chart as l18
from benchmarks.claims.lie_groups.held_base import BodySteps, ScaledRotations
from benchmarks.claims.lie_groups.l18_formulas_of_the_cayley_chart import L18
from galvi.arrays import Array
from references.textbook.galerkin import cayley
from tests.benchmarks.planted_tables import contradicted, rows

HELD = f"{l18.CHANGES[0]}, {l18.HELD} as printed, least over the rules, n = 3"
MOVED = f"largest {l18.CHANGES[1]}, {l18.MOVED}, all n and rules"


@pytest.fixture
def few(monkeypatch: pytest.MonkeyPatch) -> None:
    """The shortest study of L18."""
    fewer = {"NS": (3,), "ORDERS": (), "SCALES": (10.0,), "STATES": 10, "STEPS": 1}
    for name, value in fewer.items():
        monkeypatch.setattr(l18, name, value)


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

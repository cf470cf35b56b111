"""L18: its verdicts are not built in."""

from __future__ import annotations

from typing import Any

import pytest

from benchmarks.checks.bounds import HOLDS
from benchmarks.claims.lie_groups import l18_formulas_of_the_cayley_chart as l18
from benchmarks.claims.lie_groups import printed_formulas
from benchmarks.claims.lie_groups.printed_formulas import BodySteps
from references.textbook.galerkin import cayley
from tests.suite.benchmarks.planted_tables import CLAIM, rows


def test_formulas_that_are_right_are_not_accused(monkeypatch: pytest.MonkeyPatch) -> None:
    def moving(body: BodySteps, x: Any, sums: Any, p: Any, first: Any) -> Any:
        """The momentum matched with the base moved, whatever is asked for."""
        return p - cayley(x[-1]) @ body.after(x, sums)

    monkeypatch.setattr(printed_formulas, "J_D", 0.5 * printed_formulas.J_D)
    monkeypatch.setattr(printed_formulas, "AS_PRINTED", printed_formulas.IN_ORDER)
    monkeypatch.setattr(printed_formulas, "SLIP", 1)
    monkeypatch.setattr(BodySteps, "matched", moving)
    for name, value in {"SCALES": (10.0,), "STEPS": 1, "STATES": 10, "BODY_STEPS": 1}.items():
        monkeypatch.setattr(l18, name, value)
    accused = [row for row in rows(CLAIM["L18"]) if row.expected == "contradicted"]
    assert len(accused) == 8 and {row.verdict for row in accused} == {HOLDS}

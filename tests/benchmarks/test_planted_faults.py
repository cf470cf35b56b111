"""Each family of claims catches a method, a clock or a force that is slightly wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.claim import Claim, Row
from benchmarks.claims import CLAIMS
from benchmarks.verdicts import CONTRADICTED, HOLDS
from galvi import Problem

CLAIM = {claim.id: claim for claim in CLAIMS}
Change = Callable[[Any], dict[str, Any]]


def faulty(change: Change) -> Callable[[Any, Any], Any]:
    """Galerkin methods whose table is not the one of their space and rule.

    The rule's name tells them from the sound ones, to which they would otherwise be equal.
    """

    def make(space: Any, rule: Any) -> galvi.Galerkin:
        method = galvi.Galerkin(space, replace(rule, name=f"{rule.name}, wrong {change.__name__}"))
        vars(method)["table"] = replace(method.table, **change(method.table))
        return method

    return make


def position_weights(table: Any) -> dict[str, Any]:
    return {"beta": table.beta * (1.0 + 1e-6)}


def velocity_weights(table: Any) -> dict[str, Any]:
    return {"b": table.b * (1.0 + 1e-3)}


def stages(table: Any) -> dict[str, Any]:
    return {"A": table.A * (1.0 + 1e-4)}


def curve(table: Any) -> dict[str, Any]:
    return {"C": table.C * (1.0 + 1e-4)}


def rows(claim: Claim, make: Any = galvi.Galerkin) -> list[Row]:
    return claim.judge(claim.study(make, True, lambda sentence: None))


def contradicted(found: list[Row]) -> list[str]:
    return [row.quantity for row in found if row.verdict == CONTRADICTED]


@pytest.mark.parametrize(
    ("claim", "change", "quantity"),
    [
        ("V1", position_weights, "base of the one-step error"),
        ("V1", position_weights, "smallest one-step error"),
        ("V2", velocity_weights, "base of the energy error"),
        ("V2", velocity_weights, "energy error, n = 14"),
        ("V3", position_weights, "base of the one-step error"),
        ("V4", curve, "base of the curve error"),
        ("V5", curve, "base of the energy error along the curve"),
        ("V5", curve, "base of the angular momentum error along the curve"),
        ("V6", stages, "order of the one-step error, n = 4, fixed T"),
        ("V6", stages, "order of the one-step error, n = 6, fixed number of steps"),
        ("V7", curve, "order of the angular momentum error along the curve, n = 8, fixed T"),
        ("V8", velocity_weights, "energy error, n = 8"),
        ("V8", velocity_weights, "angular momentum error, n = 8"),
        ("V9", position_weights, "Mercury, distance to IAS15 at the end [au], n = 41"),
        ("V9", velocity_weights, "energy error, n = 25"),
    ],
)
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: str, change: Change, quantity: str
) -> None:
    assert quantity in contradicted(rows(CLAIM[claim], faulty(change)))


def reversed_clock(problem: Problem) -> Problem:
    return Problem(problem.system, problem.q0, -problem.v0, problem.t0, problem.name)


def stronger_force(problem: Problem) -> Problem:
    """The centre, or the Sun, heavier by a millionth."""
    system: Any = problem.system
    if isinstance(system, galvi.NBody):
        heavier = np.where(np.arange(system.masses.size) == 0, 1.0 + 1e-6, 1.0)
        changed: Any = galvi.NBody(system.masses * heavier, system.G)
    else:
        changed = replace(system, potential=galvi.CentralForce(system.potential.mu * (1.0 + 1e-6)))
    return Problem(changed, problem.q0, problem.v0, problem.t0, problem.name, problem.parameters)


@pytest.mark.parametrize("claim", ["V3", "V6", "V9"])
@pytest.mark.parametrize("change", [reversed_clock, stronger_force])
def test_a_wrong_motion_is_caught_by_the_truth(
    claim: str, change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    true_to_itself = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest: true_to_itself(change(problem), *rest)
    )
    assert contradicted(rows(CLAIM[claim])) != []


@pytest.mark.parametrize("change", [reversed_clock, stronger_force])
def test_invariants_alone_do_not_see_a_wrong_motion(
    change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    true_to_itself = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest: true_to_itself(change(problem), *rest)
    )
    assert [row.verdict for row in rows(CLAIM["V8"])] == [HOLDS, HOLDS]

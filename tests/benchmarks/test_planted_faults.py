"""Each family of claims catches a method, a clock or a force that is slightly wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED, HOLDS
from benchmarks.checks.claim import Claim, Row
from benchmarks.claims import CLAIMS
from benchmarks.claims.vector_spaces import v11_euler_methods_on_planets as v11
from galvi import Problem
from references.textbook.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from tests.benchmarks.planted_tables import with_table

CLAIM = {claim.id: claim for claim in CLAIMS}
Change = Callable[[Any], dict[str, Any]]


def faulty(change: Change) -> Callable[[Any, Any], Any]:
    """Galerkin methods whose table is not the one of their space and rule.

    The rule's name tells them from the sound ones, to which they would otherwise be equal.
    """

    def make(space: Any, rule: Any) -> galvi.Galerkin:
        sound = galvi.Galerkin(space, rule)
        table = replace(sound.table, **change(sound.table))
        return with_table(sound, f"wrong {change.__name__}", table)

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
    ("claim", "change", "quantities"),
    [
        ("V1", position_weights, {"base of the one-step error", "smallest one-step error"}),
        ("V2", velocity_weights, {"base of the energy error", "energy error, n = 14"}),
        ("V3", position_weights, {"base of the one-step error"}),
        ("V4", curve, {"base of the curve error"}),
        ("V5", curve, {f"base of the {what} error along the curve"
                       for what in ("energy", "angular momentum")}),
        ("V6", stages, {f"order of the one-step error, {which}"
                        for which in ("n = 4, fixed T", "n = 6, fixed number of steps")}),
        ("V7", curve, {"order of the angular momentum error along the curve, n = 8, fixed T"}),
        ("V8", velocity_weights, {"energy error, n = 8", "angular momentum error, n = 8"}),
        ("V9", position_weights, {"Mercury, distance to IAS15 at the end [au], n = 41"}),
        ("V9", velocity_weights, {"energy error, n = 25"}),
        ("V10", position_weights, {"farthest planet from IAS15 at the end [au], n = 25"}),
        ("V10", velocity_weights, {"energy error, n = 25"}),
    ],
)  # fmt: skip
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: str, change: Change, quantities: set[str]
) -> None:
    assert quantities <= set(contradicted(rows(CLAIM[claim], faulty(change))))


def reversed_clock(problem: Problem) -> Problem:
    start = problem.q0, -problem.v0
    return Problem(problem.system, *start, problem.t0, problem.name, problem.parameters)


def stronger_force(problem: Problem) -> Problem:
    """The centre, or the Sun, heavier by a millionth."""
    system: Any = problem.system
    if isinstance(system, galvi.NBody):
        heavier = np.where(np.arange(system.masses.size) == 0, 1.0 + 1e-6, 1.0)
        changed: Any = galvi.NBody(system.masses * heavier, system.G)
    else:
        changed = replace(system, potential=galvi.CentralForce(system.potential.mu * (1.0 + 1e-6)))
    return Problem(changed, problem.q0, problem.v0, problem.t0, problem.name, problem.parameters)


@pytest.mark.parametrize("claim", ["V3", "V6", "V9", "V10"])
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


@pytest.mark.parametrize(
    ("label", "instead", "quantities"),
    [
        (
            v11.SYMPLECTIC,
            EXPLICIT_EULER,
            ["largest relative energy error, symplectic Euler"],
        ),
        (
            v11.IMPLICIT,
            EXPLICIT_EULER,
            [
                "energy before the solve stops, relative change, implicit Euler",
                "share of steps in which the energy rises, implicit Euler",
            ],
        ),
        (
            v11.EXPLICIT,
            SYMPLECTIC_EULER,
            [
                "energy at the end, relative change, explicit Euler",
                "share of steps in which the energy rises, explicit Euler",
            ],
        ),
    ],
    ids=["symplectic is explicit", "implicit is explicit", "explicit is symplectic"],
)
def test_a_method_of_euler_that_is_another_is_caught(
    label: str, instead: Any, quantities: list[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = v11.methods()
    some = {key: sound[key] for key in sound if key != v11.BLIND}
    monkeypatch.setattr(v11, "methods", lambda: {**some, label: (instead, {})})
    assert set(quantities) <= set(contradicted(rows(CLAIM["V11"])))


def test_a_wrong_sign_of_the_velocity_is_caught_in_v11(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = v11.methods()
    found = {
        label: (_Changed(contender, reversed_clock), options)
        for label, (contender, options) in sound.items()
        if label != v11.BLIND
    }
    monkeypatch.setattr(v11, "methods", lambda: found)
    orders = [quantity for quantity in contradicted(rows(CLAIM["V11"])) if "order" in quantity]
    assert len(orders) == 3


class _Changed:
    """A contender that solves a changed problem."""

    def __init__(self, contender: Any, change: Callable[[Problem], Problem]) -> None:
        self.contender, self.change = contender, change

    def run(self, problem: Problem, duration: float, setting: Any) -> galvi.Trajectory:
        return self.contender.run(self.change(problem), duration, setting)

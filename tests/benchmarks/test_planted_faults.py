"""Each family of claims catches a method, a clock or a force that is slightly wrong."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

import galvi
from benchmarks.checks.bounds import HOLDS
from benchmarks.claims import CLAIMS
from benchmarks.claims.vector_spaces import v02_oscillator_energy as v02
from benchmarks.claims.vector_spaces import v11_euler_methods_on_planets as v11
from galvi import Problem
from references.textbook.euler import EXPLICIT_EULER, SYMPLECTIC_EULER
from tests.benchmarks.planted_tables import contradicted, faulty, reversed_clock, rows

CLAIM = {claim.id: claim for claim in CLAIMS}
POSITION_WEIGHTS = {"beta": 1.0 + 1e-6}
VELOCITY_WEIGHTS = {"b": 1.0 + 1e-3}
STAGES = {"A": 1.0 + 1e-4}
CURVE = {"C": 1.0 + 1e-4}


@pytest.mark.parametrize(
    ("claim", "scale", "quantities"),
    [
        ("V1", POSITION_WEIGHTS, {"base of the one-step error", "smallest one-step error"}),
        ("V2", VELOCITY_WEIGHTS, {"base of the energy error", "energy error, n = 14", v02.OF_FORM}),
        ("V3", POSITION_WEIGHTS, {"base of the one-step error"}),
        ("V4", CURVE, {"base of the curve error"}),
        ("V5", CURVE, {f"base of the {what} error along the curve"
                       for what in ("energy", "angular momentum")}),
        ("V6", STAGES, {f"order of the one-step error, {which}"
                        for which in ("n = 4, fixed T", "n = 6, fixed number of steps")}),
        ("V7", CURVE, {"order of the angular momentum error along the curve, n = 8, fixed T"}),
        ("V8", VELOCITY_WEIGHTS, {"energy error, n = 8", "angular momentum error, n = 8"}),
        ("V9", POSITION_WEIGHTS, {"base of Mercury's largest distance to IAS15"}),
        ("V9", VELOCITY_WEIGHTS, {"energy error, n = 25"}),
        ("V10", POSITION_WEIGHTS, {"farthest planet from IAS15 at the end [au], n = 25"}),
        ("V10", VELOCITY_WEIGHTS, {"energy error, n = 25"}),
        ("V10", {"integral": 1.5}, {"energy error in the Kepler frame",
                                    "farthest planet from IAS15 at step ends, in the Kepler frame "
                                    "[au]"}),
    ],
)  # fmt: skip
def test_a_table_that_is_slightly_wrong_is_caught(
    claim: str, scale: dict[str, float], quantities: set[str]
) -> None:
    assert quantities <= contradicted(CLAIM[claim], faulty(**scale))


def stronger_force(problem: Problem) -> Problem:
    """The centre, or the Sun, heavier by a millionth."""
    system: Any = problem.system
    if isinstance(system, galvi.NBody):
        heavier = np.where(np.arange(system.masses.size) == 0, 1.0 + 1e-6, 1.0)
        changed: Any = galvi.NBody(system.masses * heavier, system.G)
    else:
        changed = replace(system, potential=galvi.CentralForce(system.potential.mu * (1.0 + 1e-6)))
    return replace(problem, system=changed)


@pytest.mark.parametrize("claim", ["V3", "V6", "V9", "V10"])
@pytest.mark.parametrize("change", [reversed_clock, stronger_force])
def test_a_wrong_motion_is_caught_by_the_truth(
    claim: str, change: Callable[[Problem], Problem], monkeypatch: pytest.MonkeyPatch
) -> None:
    true_to_itself = galvi.integrate
    monkeypatch.setattr(
        galvi, "integrate", lambda problem, *rest: true_to_itself(change(problem), *rest)
    )
    assert contradicted(CLAIM[claim]) != set()


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
            ["order of the energy error beyond the modified energy, symplectic Euler"],
        ),
        (
            v11.IMPLICIT,
            EXPLICIT_EULER,
            [
                "order of the energy change beyond first order in h, implicit Euler",
                "share of steps in which the energy rises, largest over h, implicit Euler",
            ],
        ),
        (
            v11.EXPLICIT,
            SYMPLECTIC_EULER,
            [
                "order of the energy change beyond first order in h, explicit Euler",
                "share of steps in which the energy rises, least over h, explicit Euler",
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
    monkeypatch.setattr(v11, "two_body_rows", lambda *given: [])
    assert set(quantities) <= contradicted(CLAIM["V11"])


def test_a_wrong_sign_of_the_velocity_is_caught_in_v11(monkeypatch: pytest.MonkeyPatch) -> None:
    sound = v11.methods()
    found = {
        label: (_Changed(contender, reversed_clock), options)
        for label, (contender, options) in sound.items()
        if label != v11.BLIND
    }
    monkeypatch.setattr(v11, "methods", lambda: found)
    monkeypatch.setattr(v11, "two_body_rows", lambda *given: [])
    orders = [name for name in contradicted(CLAIM["V11"]) if name.startswith("order of the posi")]
    assert len(orders) == 3


class _Changed:
    """A contender that solves a changed problem."""

    def __init__(self, contender: Any, change: Callable[[Problem], Problem]) -> None:
        self.contender, self.change = contender, change

    def run(self, problem: Problem, duration: float, setting: Any) -> galvi.Trajectory:
        return self.contender.run(self.change(problem), duration, setting)

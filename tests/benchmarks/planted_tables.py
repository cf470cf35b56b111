"""Methods that step by a wrong table, wrong motions, and what the claims say of them."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from copy import copy
from dataclasses import replace
from functools import cache
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED
from benchmarks.checks.claim import Claim, Row
from galvi import Problem
from references.closed_forms.kepler import KEPLER
from references.closed_forms.top_motion import FREE_TOP
from references.rebound.ias15 import IAS15

TRUTHS = tuple(type(truth) for truth in (KEPLER, FREE_TOP, IAS15))


def faulty(**scale: float) -> Callable[..., Any]:
    """Methods with these arrays of their table multiplied.

    Those with a degree for each component stay as they are: their table is not what they step by.
    """

    def make(space: Any, rule: Any, *chart: Any) -> galvi.Galerkin:
        sound = galvi.Galerkin(space, rule, *chart)
        if hasattr(space, "degrees"):
            return sound
        wrong = {name: getattr(sound.table, name) * by for name, by in scale.items()}
        return with_table(sound, f"wrong {scale}", replace(sound.table, **wrong))

    return make


def with_table(sound: galvi.Galerkin, why: str, table: Any) -> galvi.Galerkin:
    """The method with another table; its rule's name tells it from the sound one.

    Made without its constructor, which would tabulate the renamed rule once more.
    """
    method = copy(sound)
    rule: Any = sound.rule
    vars(method).update(rule=replace(rule, name=f"{rule.name}, {why}"), table=table)
    return method


def rows(claim: Claim, make: Any = galvi.Galerkin) -> list[Row]:
    """What the claim's quick study comes to; a truth is computed once for all faults."""
    with pytest.MonkeyPatch.context() as patch:
        for kind in TRUTHS:
            patch.setattr(kind, "run", remembered(kind.run))
        return claim.judge(claim.study(make, True, lambda sentence: None))


@cache
def remembered(run: Callable[..., Any]) -> Callable[..., Any]:
    """It runs once for all problems, durations and settings of the same content."""
    kept: dict[bytes, Any] = {}

    def again(self: Any, problem: Problem, duration: float, setting: Any) -> Any:
        key = pickle.dumps((self, problem, duration, setting))
        if key not in kept:
            kept[key] = run(self, problem, duration, setting)
        return kept[key]

    return again


def contradicted(claim: Claim, make: Any = galvi.Galerkin) -> set[str]:
    """The quantities that were, and were not expected to be."""
    return {
        row.quantity
        for row in rows(claim, make)
        if row.verdict == CONTRADICTED and row.expected != CONTRADICTED
    }


def reversed_clock(problem: Problem) -> Problem:
    """The start with its velocity reversed."""
    return replace(problem, v0=-problem.v0)

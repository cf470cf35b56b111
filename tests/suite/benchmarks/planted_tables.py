"""Verdicts of claims with planted faults, wrong methods among them."""

from __future__ import annotations

import pickle
from collections.abc import Callable
from functools import cache
from pkgutil import resolve_name
from typing import Any

import pytest

import galvi
from benchmarks.checks.bounds import CONTRADICTED
from benchmarks.checks.claim import Claim, Row
from benchmarks.checks.faults import Fault
from benchmarks.claims import CLAIMS
from galvi import Problem
from references.closed_forms.kepler import KEPLER
from references.closed_forms.top_motion import FREE_TOP
from references.rebound.ias15 import IAS15
from tests.suite.benchmarks.quick_studies import quick

TRUTHS = tuple(type(truth) for truth in (KEPLER, FREE_TOP, IAS15))
CLAIM = {claim.id: claim for claim in CLAIMS}


def rows(claim: Claim, fault: Fault | Callable[..., Any] = galvi.Galerkin) -> list[Row]:
    """Rows of the claim's quick study with a fault, or with methods that a function makes. Runs of
    truths are computed once for all studies."""
    if not isinstance(fault, Fault):
        fault = Fault(fault)
    if fault.table is not None:
        table = quick(claim)
        fault.table(table)
        return claim.check(table)
    with pytest.MonkeyPatch.context() as patch:
        for truth in TRUTHS:
            patch.setattr(truth, "run", remembered(truth.run))
        for name, change in fault.wrong.items():
            patch.setattr(name, change(resolve_name(name)))
        return claim.check(claim.study(fault.make, True, lambda sentence: None))


@cache
def remembered(run: Callable[..., Any]) -> Callable[..., Any]:
    """A `run` that computes once for each content of problem, duration and setting."""
    runs: dict[bytes, Any] = {}

    def run_once(self: Any, problem: Problem, duration: float, setting: Any) -> Any:
        key = pickle.dumps((self, problem, duration, setting))
        if key not in runs:
            runs[key] = run(self, problem, duration, setting)
        return runs[key]

    return run_once


def contradicted(claim: Claim, fault: Fault | Callable[..., Any] = galvi.Galerkin) -> set[str]:
    """Quantities that are contradicted although they were not expected to be."""
    return {
        row.quantity
        for row in rows(claim, fault)
        if row.verdict == CONTRADICTED and row.expected != CONTRADICTED
    }

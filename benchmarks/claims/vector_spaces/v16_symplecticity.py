"""V16: every method is symplectic on nonlinear problems (H 1.2)."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Fault, MakeMethod, Problem, Report, readings, with_arguments
from benchmarks.measures.space_rule_pairs import SUFFICIENT_POINTS, kinds, methods
from benchmarks.measures.symplectic_form import canonical_defect, map_derivative
from galvi.arrays import Array

STEP = 0.5
PROBLEMS = {
    "Henon-Heiles": galvi.problems.henon_heiles(),
    "Kepler": Problem(
        galvi.problems.kepler(0.3).system, np.array([1.3, 0.0]), np.array([0.0, (0.7 / 1.3) ** 0.5])
    ),
}
FAULTS = {
    "the derivative of another step": Fault(
        wrong={
            "galvi.step_derivative": with_arguments(
                lambda problem, method, h: (problem, method, 1.000001 * h)
            )
        }
    )
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """The largest defect for each problem and kind of space; the largest difference of DF from
    central differences, for the first method of each kind with each family of rules; and the number
    of methods of each kind."""
    pairs = (
        ((2,), (1, 2, 3, SUFFICIENT_POINTS))
        if quick
        else ((1, 2, 3, 4), (1, 2, 3, 4, 5, 6, SUFFICIENT_POINTS))
    )
    of_kind: dict[str, list[Any]] = {kind: [] for kind in kinds()}
    firsts: dict[tuple[str, str], Any] = {}
    for pair, method in methods(make_method, *pairs):
        of_kind[pair.kind].append(method)
        firsts.setdefault((pair.kind, pair.family), method)
    by_component = make_method(galvi.ComponentPolynomials((6, 4)), galvi.gauss(6))
    numbers = {f"methods{k}": float(len(some)) for k, some in enumerate(of_kind.values(), 1)}
    for name, problem in PROBLEMS.items():
        report(name)
        defects = {
            kind: readings.largest(
                np.array([canonical_defect(derivative(problem, method)) for method in some])
            )
            for kind, some in of_kind.items()
        }
        differenced = map_derivative(problem, by_component, STEP)
        defects["ComponentPolynomials((6, 4))"] = canonical_defect(differenced)
        for kind, defect in defects.items():
            numbers[f"defect of DF^T J DF = J, {kind}, {name}"] = defect
        numbers[f"DF against central differences, {name}"] = np.max(
            [
                np.abs(derivative(problem, method) - map_derivative(problem, method, STEP))
                for method in firsts.values()
            ]
        )
    return numbers


def derivative(problem: Problem, method: Any) -> Array:
    """DF by the implicit function theorem at the converged stages; NaN for a failed step."""
    try:
        return galvi.step_derivative(problem, method, STEP)
    except ValueError:
        return np.full((4, 4), np.nan)

"""The method of every pair of space and rule: `python -m benchmarks.studies.taxonomy`.

Predictions of the theory are compared with measurements: the order on the Kepler problem against
its closed form, the defect of DF^T J DF = J on the Henon-Heiles problem, and the error after a run
forwards and backwards. M (section 5) classifies polynomials in this way; here are all spaces and
rules of galvi.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.space_rule_pairs import SUFFICIENT_POINTS, Pair, pairs
from benchmarks.measures.symplectic_form import canonical_defect
from benchmarks.statistics import convergence_fits
from galvi.arrays import Array
from galvi.properties.properties import classical_names
from references.closed_forms.kepler import KEPLER

METHOD, ILL_POSED, INCONSISTENT = "method", "ill-posed", "inconsistent"
MAX_ARGUMENT = {
    "Polynomials": 4
}  # largest constructor argument of a kind of space, else DEFAULT_ARGUMENT
DEFAULT_ARGUMENT, QUICK_ARGUMENT = 2, 1
POINTS, QUICK_POINTS = (1, 2, 3, 4, 5, 6, SUFFICIENT_POINTS), (1, 2, 3, SUFFICIENT_POINTS)
ORBIT, DURATION = galvi.problems.kepler(eccentricity=0.3), 4.0
SAMPLES = 4  # times of the errors: at a single one leading terms may cancel
CHAOS, STEP = galvi.problems.henon_heiles(), 0.5
BACK_STEP, BACK_STEPS = 0.25, 8
FLOOR = 3e-13  # of q and p of size 1; 6e-14 was measured
COARSEST = {1: 96, 2: 48, 3: 32, 4: 24, 5: 20, 6: 16, 7: 16, 8: 16}  # steps, by predicted order
STEP_COUNTS = 7  # how many numbers of steps are run, each larger by the square root of 2

COLUMNS: Mapping[str, str] = {
    "kind": "of space",
    "number": "it is made from",
    "space": "in words",
    "family": "of rules",
    "points": "of the rule, on each piece where the space has pieces",
    "rule": "in words",
    "verdict": "method, ill-posed or inconsistent",
    "C_N": "M (11); empty where no constant will do",
    "predicted": "order at step ends; 0 for what makes no method",
    "measured": "order at step ends, of q and p",
    "uncertainty": "its standard error",
    "symplecticity": "defect of DF^T J DF = J, relative to |DF|^2",
    "symmetric": "whether a step back should undo a step",
    "symmetry": "largest component left after 8 steps there and back",
    "name": "the best known of a method with this tableau",
    "status": "why there is no method, or no number",
}


def taxonomy(quick: bool, report: Report, make_method: MakeMethod = galvi.Galerkin) -> pd.DataFrame:
    """A row for each pair, with the columns above."""
    exact = KEPLER.run(ORBIT, DURATION, {"samples": SAMPLES})
    truth = np.hstack([exact.q, exact.p])
    lines, kind = [], ""
    largest_argument = QUICK_ARGUMENT if quick else DEFAULT_ARGUMENT
    for pair in pairs(range(1, 5), QUICK_POINTS if quick else POINTS):
        if pair.number > (
            largest_argument if quick else MAX_ARGUMENT.get(pair.kind, largest_argument)
        ):
            continue
        if pair.kind != kind:
            kind = pair.kind
            report(kind)
        lines.append(_line(pair, truth, make_method))
    return pd.DataFrame(lines, columns=list(COLUMNS))


def _line(pair: Pair, truth: Array, make_method: MakeMethod) -> dict[str, Any]:
    theory = galvi.theory(pair.space, pair.rule)
    line: dict[str, Any] = {
        "kind": pair.kind,
        "number": pair.number,
        "space": theory.space,
        "family": pair.family,
        "points": pair.points,
        "rule": theory.rule,
        "verdict": METHOD,
        "C_N": np.nan if theory.friedrichs is None else theory.friedrichs,
        "predicted": theory.order,
        "symmetric": theory.symmetric,
        "name": "",
        "status": "",
    }
    try:
        method = make_method(pair.space, pair.rule)
    except ValueError as refusal:
        verdict = INCONSISTENT if theory.well_posed else ILL_POSED
        return {**line, "verdict": verdict, "status": str(refusal)}
    fit, status = _order(method, theory.order, truth)
    return {
        **line,
        "name": next(iter(classical_names(method.table, separable=True)), ""),  # on these problems
        "measured": fit.rate,
        "uncertainty": fit.uncertainty,
        "symplecticity": canonical_defect(galvi.step_derivative(CHAOS, method, STEP)),
        "symmetry": galvi.round_trip_error(ORBIT, method, BACK_STEP, BACK_STEPS),
        "status": status,
    }


def _order(method: Any, predicted: int, truth: Array) -> tuple[convergence_fits.Fit, str]:
    """The fit to the largest errors of q and p at the samples, and the status of a failed run or
    ""."""
    first, status = COARSEST.get(predicted, min(COARSEST.values())), ""
    steps = [SAMPLES * round(first / SAMPLES * 2.0 ** (j / 2)) for j in range(STEP_COUNTS)]
    errors = []
    for count in steps:
        h, between = DURATION / count, count // SAMPLES
        run = galvi.integrate(ORBIT, method, h, count, save_every=between)
        errors.append(float(np.max(np.abs(np.hstack([run.q, run.p]) - truth))))
        status = status if run.success else run.status
    return convergence_fits.algebraic(
        [DURATION / count for count in steps], errors, floor=FLOOR
    ), status


if __name__ == "__main__":
    table = taxonomy(False, print).drop(columns=["kind", "number", "family", "points"])
    print(table.to_string(index=False, max_colwidth=60, float_format="{:.2g}".format))

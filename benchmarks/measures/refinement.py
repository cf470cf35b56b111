"""Convergence studies: one problem, many n and h, errors against an independent truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.errors import PER_STEP, QUANTITIES
from benchmarks.store import tables
from benchmarks.store.tables import failure, rows
from galvi import Problem, Trajectory
from galvi.arrays import Array
from references import Contender

MethodOf = Callable[[MakeMethod, int], Any]
ENDS_AND_CURVE = ("one-step error", "curve error")  # of QUANTITIES
CAYLEY = galvi.Cayley()


@dataclass(frozen=True)
class Case:
    """n basis functions (degree n - 1), ``steps`` steps of size ``step``."""

    n: int
    step: float
    steps: int

    @property
    def columns(self) -> dict[str, Any]:
        """The case as columns of a tidy row."""
        return {"n": self.n, "step": self.step, "steps": self.steps}


def outcome(run: Trajectory) -> dict[str, Any]:
    """Status and counts of a run, as columns of a tidy row."""
    return {"status": failure(run), "force_evaluations": run.counts["force_evaluations"]}


def all_steps_solved(run: Trajectory) -> bool:
    """Whether every step was solved, however large the error of the energy."""
    return bool(np.all(np.isfinite(run.p[-1])))


def at_fixed_time(ns: Iterable[int], duration: float, steps: Sequence[int]) -> list[Case]:
    """h-refinement for each n with the final time fixed: steps of duration / k for each k."""
    return [Case(n, duration / k, k) for n in ns for k in steps]


def with_fixed_number(ns: Iterable[int], steps: int, sizes: Sequence[float]) -> list[Case]:
    """h-refinement for each n as in H, with a fixed number of steps: the final time shrinks."""
    return [Case(n, h, steps) for n in ns for h in sizes]


def method_of(make_method: MakeMethod, n: int) -> Any:
    """H 2.4: polynomials of degree n - 1 with the Gauss rule of 2n points."""
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n))


def method_on_group(make_method: MakeMethod, n: int, chart: Any = CAYLEY) -> Any:
    """H 3.4.2: polynomials of degree n - 1 with a Gauss rule, of n points; Cayley's chart."""
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(n), chart)


def collocation(make_method: MakeMethod, s: int, *chart: Any) -> Any:
    """Polynomials of degree s with s Gauss points, perhaps in a chart."""
    return make_method(galvi.Polynomials(s), galvi.gauss(s), *chart)


def refine(
    study: str,
    problem: Problem,
    truth: Contender,
    cases: Iterable[Case],
    quantities: Iterable[str],
    make_method: MakeMethod,
    report: Report,
    method: MethodOf = method_of,
) -> list[dict[str, Any]]:
    """One row for each case and quantity, a name of `benchmarks.measures.errors.QUANTITIES`; NaN
    where a step was not solved."""
    exact: dict[tuple[float, int], Trajectory] = {}
    quantities = tuple(quantities)
    needs_truth = {"one-step error", "curve error"} & set(quantities)
    per_step = PER_STEP if "curve error" in quantities else 1
    measurements = []
    for case in cases:
        report(f"n = {case.n}, {case.steps} steps of {case.step:.4g}")
        run = galvi.integrate(problem, method(make_method, case.n), case.step, case.steps)
        span = (case.step * case.steps, case.steps * per_step)
        if needs_truth and all_steps_solved(run) and span not in exact:
            exact[span] = truth.run(problem, span[0], {"samples": span[1]})
        values = {
            quantity: QUANTITIES[quantity](run, exact.get(span))
            if all_steps_solved(run)
            else float("nan")
            for quantity in quantities
        }
        measurements += rows(values, study=study, **case.columns, **outcome(run))
    return measurements


def refine_at_end(
    study: str,
    quantity: str,
    problem: Problem,
    exact: Array,
    cases: Iterable[Case],
    make_method: MakeMethod,
    report: Report,
    method: MethodOf = method_of,
) -> list[dict[str, Any]]:
    """One row for each case: the largest entry of q - exact at the final time, or NaN where a step
    was not solved."""
    measurements = []
    for case in cases:
        report(f"{study}, n = {case.n}, {case.steps} steps")
        run = galvi.integrate(problem, method(make_method, case.n), case.step, case.steps)
        error = float(np.max(np.abs(run.q[-1] - exact))) if all_steps_solved(run) else float("nan")
        measurements += rows({quantity: error}, study=study, **case.columns, **outcome(run))
    return measurements


def history(
    study: str,
    problem: Problem,
    case: Case,
    measures: Any,
    make_method: MakeMethod,
    method: MethodOf = method_of,
) -> list[dict[str, Any]]:
    """One row for each step end and quantity.

    Parameters
    ----------
    measures
        name of a quantity -> function of the run that returns a number for each step end
    """
    run = galvi.integrate(problem, method(make_method, case.n), case.step, case.steps)
    columns = {"study": study, **case.columns, **outcome(run)}
    return [
        row
        for quantity, measure in measures.items()
        for row in tables.history(quantity, run.t, measure(run), **columns)
    ]

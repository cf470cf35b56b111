"""Convergence studies: one problem, many n and h, errors against an independent truth."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import Any

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.errors import PER_STEP, QUANTITIES
from benchmarks.store.frames import row
from galvi import Problem, Trajectory
from references import Contender

MethodOf = Callable[[MakeMethod, int], Any]


@dataclass(frozen=True)
class Case:
    """n basis functions (degree n - 1), ``steps`` steps of size ``step``."""

    n: int
    step: float
    steps: int


def at_fixed_time(n: int, duration: float, steps: Iterable[int]) -> list[Case]:
    """h-refinement with the final time fixed: steps of duration / k for each k."""
    return [Case(n, duration / k, k) for k in steps]


def with_fixed_number(n: int, steps: int, step_sizes: Iterable[float]) -> list[Case]:
    """h-refinement as H does it: always as many steps, so that the final time shrinks."""
    return [Case(n, h, steps) for h in step_sizes]


def method_of(make_method: MakeMethod, n: int) -> Any:
    """H 2.4: polynomials of degree n - 1 with the Gauss rule of 2n points."""
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(2 * n))


def method_on_group(make_method: MakeMethod, n: int) -> Any:
    """H 3.4.2: polynomials of degree n - 1 with a Gauss rule, of n points; Cayley's chart."""
    return make_method(galvi.Polynomials(n - 1), galvi.gauss(n))


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
    """One row for each case and quantity (names of `benchmarks.measures.errors.QUANTITIES`)."""
    exact: dict[tuple[float, int], Trajectory] = {}
    quantities = tuple(quantities)
    needs_truth = {"one-step error", "curve error"} & set(quantities)
    per_step = PER_STEP if "curve error" in quantities else 1
    rows = []
    for case in cases:
        report(f"n = {case.n}, {case.steps} steps of {case.step:.4g}")
        run = galvi.integrate(problem, method(make_method, case.n), case.step, case.steps)
        span = (case.step * case.steps, case.steps * per_step)
        if needs_truth and run.success and span not in exact:
            exact[span] = truth.run(problem, span[0], {"samples": span[1]})
        for quantity in quantities:
            rows.append(
                row(
                    study=study,
                    quantity=quantity,
                    n=case.n,
                    step=case.step,
                    steps=case.steps,
                    value=QUANTITIES[quantity](run, exact.get(span))
                    if run.success
                    else float("nan"),
                    status="" if run.success else run.status,
                    force_evaluations=run.counts["force_evaluations"],
                )
            )
    return rows


def history(
    study: str,
    problem: Problem,
    case: Case,
    measures: Any,
    make_method: MakeMethod,
    method: MethodOf = method_of,
) -> list[dict[str, Any]]:
    """One row for each step end and quantity; ``measures`` maps its name to a function of the run
    that returns one number for each step end."""
    run = galvi.integrate(problem, method(make_method, case.n), case.step, case.steps)
    return [
        row(
            study=study,
            quantity=quantity,
            n=case.n,
            step=case.step,
            steps=case.steps,
            t=t,
            value=value,
            status="" if run.success else run.status,
            force_evaluations=run.counts["force_evaluations"],
        )
        for quantity, measure in measures.items()
        for t, value in zip(run.t, measure(run), strict=True)
    ]

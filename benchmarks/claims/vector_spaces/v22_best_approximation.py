"""V22: best approximation, errors along the path, and orders limited by the rule (M section 5)."""

from __future__ import annotations

from collections.abc import Sequence
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    OTHER_TRUTH,
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    always,
    at_fixed_time,
    failure,
    number,
    readings,
    refine,
    row,
    rows,
    table_of,
    with_arguments,
)
from benchmarks.measures.best_approximation import Motion, best_errors, step_error
from benchmarks.test_problems.oscillators import DURATION, KINK, motion, two_springs
from references.closed_forms.kepler import KEPLER
from references.scipy.ivp import DOP853, TIGHT

LARGEST, MEAN, PATH = "e_max", "e_mean", "error along the path"
ENDS, INTEGRAL = "one-step error", "error of the rule"
DEGREES = (1, 2, 3, 4)
FLOOR = 1e-12  # round-off of norms
ENDS_FLOOR = 3e-13  # round-off of positions
INTEGRAL_FLOOR = 1e-30  # round-off of integrals with 50 digits
LOBATTO = "Lobatto N"  # with N nodes, at least 2
NAMED: dict[str, Any] = {  # rules that M names
    "Gauss N": galvi.gauss,
    "Lobatto N + 1": lambda N: galvi.lobatto(N + 1),
}
RULES = NAMED | {LOBATTO: galvi.lobatto}
CHECK = {"samples": 1, **TIGHT, "max_step": 0.02}  # setting of DOP853


def cosine(t: Any) -> Any:
    """The oscillator's position and velocity at t."""
    return np.cos(t), -np.sin(t)


CASES: dict[str, tuple[Problem, Motion, float, Sequence[float]]] = {  # with duration and kinks
    "smooth": (galvi.problems.harmonic_oscillator(), cosine, 8.0, ()),
    "rough": (two_springs(), motion, DURATION, (KINK,)),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Errors of each series, with the degree N as n - 1:

    e_max, e_mean of each case
    'error along the path' of one step of each case with Gauss N + 1, and of the smooth one for each
                           rule, in `study`
    'one-step error'       of Kepler's problem for each rule
    'error of the rule'    int_0^h e^t dt by Gauss and by Lobatto with 3 nodes, in `study`
    'distance between the two references'  closed form and DOP853, of each motion in `study`
    """
    counts = sorted({2 * round(2.5 * 2.0 ** (j / 2)) + 1 for j in range(1, 11 if quick else 15)})
    steps = [round(2.0 ** (j / 2)) for j in range(5, 15 if quick else 20)]
    orbit = galvi.problems.kepler(eccentricity=0.3)
    cases = at_fixed_time([N + 1 for N in DEGREES[1:]], 4.0, steps)
    difference = KEPLER.run(orbit, 4.0, {"samples": 1}).q[-1] - DOP853.run(orbit, 4.0, CHECK).q[-1]
    observations = [
        row(study="Kepler", quantity=ORACLES, value=np.max(abs(difference))),
        *of_integrals(),
    ]
    observations += [
        row(study=name, quantity=ORACLES, value=distance_of(*case)) for name, case in CASES.items()
    ]
    rules = {name: lambda N: galvi.gauss(N + 1) for name in CASES} | RULES
    for name, rule in rules.items():
        report(name)
        for N in DEGREES[1:] if name == LOBATTO else DEGREES:
            method = make_method(galvi.Polynomials(N), rule(N))
            for count in counts:
                observations += errors_of(name, method, N, count)
    for name, rule in RULES.items():

        def method_of(make: MakeMethod, n: int, rule: Any = rule) -> Any:
            return make(galvi.Polynomials(n - 1), rule(n - 1))

        observations += refine(name, orbit, KEPLER, cases, (ENDS,), make_method, report, method_of)
    return table_of(observations)


def errors_of(name: str, method: Any, N: int, count: int) -> list[dict[str, Any]]:
    """Rows of |u - u_N|_X of the step in the middle of the duration, from the exact state; for
    names in CASES also of the errors of best polynomials on all subintervals."""
    problem, exact, duration, kinks = CASES.get(name, CASES["smooth"])
    edges, h = np.linspace(0.0, duration, count + 1), duration / count
    t = float(edges[count // 2])
    q, v = exact(np.array([t]))
    run = galvi.integrate(Problem(problem.system, q, v, t), method, h, 1)
    errors = {PATH: step_error(run, exact, kinks) if run.success else np.nan}
    if name in CASES:
        best = best_errors(exact, edges, N, kinks)
        errors |= {LARGEST: best.max(), MEAN: best.mean()}
    return rows(errors, study=name, n=N + 1, step=h, steps=count, status=failure(run))


def of_integrals() -> list[dict[str, Any]]:
    """Rows of the error of a rule for int_0^h e^t dt, from nodes and weights of 50 digits."""
    observations = []
    with localcontext(prec=50):
        for family, rule in (("Gauss", galvi.gauss(3)), ("Lobatto", galvi.lobatto(3))):
            for k in range(8):
                h = Decimal(1) / 2**k
                nodes = zip(rule.exact_weights, rule.exact_nodes, strict=True)
                error = abs(h.exp() - 1 - h * sum(w * (h * c).exp() for w, c in nodes))
                observations.append(
                    row(study=family, quantity=INTEGRAL, n=3, step=float(h), value=float(error))
                )
    return observations


def distance_of(problem: Problem, exact: Motion, duration: float, kinks: Sequence[float]) -> float:
    """The largest difference of q or p between the closed form, of mass 1, and DOP853, which runs
    from kink to kink, at the kinks and at the end."""
    gaps: list[Array] = []
    for end in (*kinks, duration):
        run = DOP853.run(problem, end - problem.t0, CHECK)
        q, v = exact(np.array([end]))
        gaps += [run.q[-1] - q, run.p[-1] - v]
        problem = Problem(problem.system, run.q[-1], run.p[-1], end)
    return float(np.max(np.abs(gaps)))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders in X of both motions, of the path for each rule, at step ends, and of the
    rules."""

    fitted = [
        *(
            (f"{quantity}, {name}", name, quantity, FLOOR, DEGREES)
            for name in CASES
            for quantity in (LARGEST, MEAN, PATH)
        ),
        *((f"{PATH}, smooth, {name}", name, PATH, FLOOR, DEGREES) for name in NAMED),
        (f"{PATH}, smooth, {LOBATTO}", LOBATTO, PATH, FLOOR, DEGREES[1:]),
        *((f"the {ENDS}, {name}", name, ENDS, ENDS_FLOOR, DEGREES[1:]) for name in RULES),
        *(
            (f"the {ENDS} against 2 N, {name}", name, ENDS, ENDS_FLOOR, DEGREES[1:])
            for name in NAMED
        ),
    ]
    numbers: dict[str, Measurement] = {
        f"order of {name}, N = {N}": readings.order(
            table, floor, study=study, quantity=quantity, n=N + 1
        )
        for name, study, quantity, floor, degrees in fitted
        for N in degrees
    }
    for family in ("Gauss", "Lobatto"):
        for name in INTEGRAL, f"{INTEGRAL} with its own count of nodes":
            numbers[f"order of the {name}, {family}, 3 nodes"] = readings.order(
                table, INTEGRAL_FLOOR, study=family, quantity=INTEGRAL
            )
    for name in (*CASES, "Kepler"):
        numbers[f"{ORACLES}, {name}"] = number(table, study=name, quantity=ORACLES)
    return numbers


def of_another_order(study: str, power: int) -> Fault:
    """A fault that multiplies errors along the path by a power of the step."""

    def change(table: DataFrame) -> None:
        path = (table["study"] == study) & (table["quantity"] == PATH)
        table.loc[path, "value"] *= table.loc[path, "step"] ** power

    return Fault(table=change)


FAULTS = {
    "a truth of another motion": OTHER_TRUTH,
    "a rule that is one order better": of_another_order(LOBATTO, 1),
    "a path across the jump that is one order worse": of_another_order("rough", -1),
    "approximations of degree 1": Fault(
        wrong={
            f"{__name__}.refine": always(lambda *arguments: []),
            f"{__name__}.best_errors": with_arguments(
                lambda exact, edges, degree, kinks: (exact, edges, 1, kinks)
            ),
        }
    ),
}

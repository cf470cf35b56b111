"""V26: the discrete Lagrangian against the exact one (H 2.1.1, 2.3.2; M theorems 4 and 5)."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    algebraic,
    failure,
    method_of,
    readings,
    row,
    rows,
    scaled,
    series,
    table_of,
)
from benchmarks.claims.vector_spaces import kepler_orbit
from benchmarks.claims.vector_spaces.step_actions import (
    ACTION,
    IN_N,
    STEPPED,
    action_along,
    discrete_lagrangian,
    exact_lagrangian,
)
from benchmarks.measures.boundary_motion import BoundaryValueMotion
from references import Contender
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR

SQUARE = "error of L_d over |u - u_N|^2 in X"
DEPARTURE = f"departure of {ACTION} from its leading term, relative"
FLOOR = 1e-14  # of actions up to 4, each rounded to 4e-16
POWER = 1.0  # of the factor n^-1 in n-refinement of the action
LOBATTO = "Kepler, Lobatto rule of n - 1 points"
POLAR = "free particle in polar coordinates"
NS = {"oscillator": (3, 4, 5, 6), "Kepler": (3, 4, 5), LOBATTO: (4, 5)}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For one step the errors of L_d and of (q, p) at the end: over h for each problem and n, and
    over n at h = 2; SQUARE for the oscillator; and the distance between the two references.

    The oscillator's motion is circular, so that |q^(n)| = 1. With a Lobatto rule of n - 1 points,
    the error of the rule dominates.
    """

    def with_lobatto(make_method: MakeMethod, n: int) -> Any:
        return make_method(galvi.Polynomials(n - 1), galvi.lobatto(n - 1))

    spring = galvi.problems.harmonic_oscillator().system
    circle = Problem(spring, np.array([1.0, 0.0]), np.array([0.0, 1.0]))
    orbit, long = kepler_orbit.problem(), kepler_orbit.STEP
    halved = [2.0 ** (-j / 2) for j in range(-2, 16)]
    cases: dict[str, tuple[Problem, Contender, Any, Any, list[float]]] = {
        "oscillator": (circle, OSCILLATOR, method_of, NS["oscillator"], halved),
        "Kepler": (orbit, KEPLER, method_of, NS["Kepler"], halved[6:]),  # below 0.2986
        LOBATTO: (orbit, KEPLER, with_lobatto, NS[LOBATTO], halved[6:]),
        IN_N: (orbit, KEPLER, method_of, range(6, 31, 3 if quick else 1), [long]),
    }
    observations = []
    for name, (problem, truth, make, ns, sizes) in cases.items():
        report(name)
        for n in ns:
            method = make(make_method, n)
            for h in sizes:
                run = galvi.integrate(problem, method, h, 1)
                errors = errors_of(run, h, truth, name == "oscillator")
                observations += rows(errors, study=name, n=n, step=h, steps=1, status=failure(run))
        for h in (long, *sizes[::4]):
            along, end = action_along(problem, h, truth)
            distance = abs(along - exact_lagrangian(problem, problem.q0, end, h))
            observations.append(row(study=name, quantity=ORACLES, step=h, value=distance))
    for n in (3, 4):
        for h in halved[4:15]:
            error = error_in_polar_coordinates(method_of(make_method, n), h)
            observations.append(row(study=POLAR, quantity=ACTION, n=n, step=h, value=error))
    return table_of(observations)


def error_in_polar_coordinates(method: Any, h: float) -> float:
    """The error of L_d in one step for L = (r'^2 + r^2 a'^2) / 2, whose motions are straight lines
    with the action |q1 - q0|^2 / (2 h); NaN for a failed run."""

    def lagrangian(q: Array, v: Array) -> Any:
        return 0.5 * (v[0] ** 2 + (q[0] * v[1]) ** 2)

    system = galvi.Lagrangian(lagrangian, galvi.Rn(2))
    run = galvi.integrate(Problem(system, [1.0, 0.0], [0.5, 0.5]), method, h, 1)
    if not run.success:
        return math.nan
    ends = [r * np.array([math.cos(angle), math.sin(angle)]) for r, angle in run.q]
    exact = np.sum((ends[1] - ends[0]) ** 2) / (2.0 * h)
    return float(abs(discrete_lagrangian(run) - exact))


def errors_of(run: Any, h: float, truth: Contender, squared: bool) -> dict[str, float]:
    """The errors of one step, NaN for a failed run.

    With `squared` also SQUARE, if h < pi and the error of the action exceeds 1e-10.
    """
    if not run.success:
        return dict.fromkeys((ACTION, STEPPED), math.nan)
    error = abs(discrete_lagrangian(run) - exact_lagrangian(run.problem, run.q[0], run.q[1], h))
    end = truth.run(run.problem, h, {"samples": 1})
    step_error = np.max(abs(np.concatenate([run.q[1] - end.q[1], run.p[1] - end.p[1]])))
    errors = {ACTION: error, STEPPED: float(step_error)}
    if squared and error > 1e-10 and h < math.pi:
        motion = BoundaryValueMotion(run.problem, h, truth)
        errors[SQUARE] = error / motion.square_of_rates(run)
    return errors


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders and bases of both errors, the order of DEPARTURE, and the largest SQUARE."""
    numbers: dict[str, Measurement] = {
        f"order of the {quantity}, {name}, n = {n}": readings.order(
            table, FLOOR, study=name, quantity=quantity, n=n
        )
        for name, ns in NS.items()
        for n in ns
        for quantity in (ACTION, STEPPED)
    }
    for n in (3, 4):
        numbers[f"order of the {ACTION}, {POLAR}, n = {n}"] = readings.order(
            table, FLOOR, study=POLAR, quantity=ACTION, n=n
        )
    for n in NS["Kepler"]:
        order = f"order of the {ACTION}, Kepler, n = {n}"
        numbers[f"{order}, against the bound"] = numbers[order]
    for quantity, power in ((ACTION, POWER), (STEPPED, 0.0)):
        numbers[f"base of the {quantity}, Kepler"] = readings.base(
            table, FLOOR, power=(power, 0.0), study=IN_N, quantity=quantity
        )
    for n in NS["oscillator"][:3]:
        h, error = series(table, "step", study="oscillator", quantity=ACTION, n=n)
        ratio = math.factorial(n - 1) / math.factorial(2 * n - 2)
        departure = abs(error / (h ** (2 * n - 1) * ratio**2 / (2 * (2 * n - 1))) - 1.0)
        above = ~(error <= 1e3 * FLOOR)
        numbers[f"order of the {DEPARTURE}, oscillator, n = {n}"] = algebraic(
            h[above].tolist(), departure[above].tolist(), floor=1e-3
        )
    distance = readings.largest_of(table, quantity=ORACLES)
    return numbers | {
        f"largest {SQUARE}": readings.largest_of(table, quantity=SQUARE),
        ORACLES: distance,
        "apart": distance,
    }


def with_energies(original: Callable[..., Any]) -> Callable[..., Any]:
    """T + V in place of the Lagrangian, for a fault: no step depends on the potential's sign."""
    return lambda problem, q, v, t: np.sum(v * v, axis=-1) - original(problem, q, v, t)


FAULTS = {
    "the potential's sign, which no step sees": Fault(
        wrong={"galvi.diagnostics.discrete_lagrangians.lagrangian_values": with_energies}
    ),
    "oracles that differ": Fault(wrong={f"{__name__}.exact_lagrangian": scaled(1.0 + 1e-12)}),
}

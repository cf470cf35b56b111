"""L17: the discrete Lagrangian on SO(3) against the exact one (H 3.1.1, 3.3.1, 3.3.2)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    ORACLES,
    Array,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    algebraic,
    always,
    failure,
    method_on_group,
    of_motion,
    readings,
    reversed_clock,
    row,
    rows,
    scaled,
    series,
    table_of,
)
from benchmarks.claims.lie_groups import free_body, pendulum_motion
from benchmarks.claims.lie_groups.cayley_curve import distance_of_polynomials
from benchmarks.claims.vector_spaces.step_actions import action_along, discrete_lagrangian
from benchmarks.measures.boundary_motion import between
from benchmarks.work_precision.with_settings import WithSettings
from references import Contender
from references.closed_forms.top_motion import FREE_TOP
from references.scipy.ivp import TIGHT
from references.scipy.rigid_ivp import RIGID_DOP853

ACTION, STEPPED = "error of L_d", "error of one step"
BEST = "distance of the motion from polynomials"
DEPARTURE = f"departure of {ACTION} from its leading term, relative, steady turning"
FREE, PENDULUM = "free body", "3D pendulum"
LOBATTO = f"{FREE}, Lobatto rule of n - 1 points"
NS = {FREE: (3, 4, 5), PENDULUM: (3, 4, 5), LOBATTO: (4, 5)}
FLOOR = {ACTION: 1e-14, STEPPED: 2e-15}  # actions, of 0.3 to 4; entries of R
LONG_FLOOR = 3e-14  # of the actions of the longest steps, up to 7; 1e-14 was measured at large n
RATES = {3: 0.5, 5: 1.0}  # |xi^(n)| of 2 tan(t / 2) at t = 0
OTHER = WithSettings(RIGID_DOP853, TIGHT)


# Motion -> (problem, truth, j of the largest step 2^(-j / 4) of the h-refinement, step of the
# n-refinement).
MOTIONS: Mapping[str, tuple[Problem, Contender, int, float]] = {
    FREE: (free_body.problem(), FREE_TOP, 8, 0.5),
    PENDULUM: (pendulum_motion.problem(), pendulum_motion.TRUTH, 6, 1.0),
}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For one step the errors of L_d and of R at the end: over h for each motion and n, and over n
    with the distance of polynomials; the distance of two references; and `departures`."""
    measured: list[dict[str, Any]] = []
    for name, (problem, truth, first, step) in MOTIONS.items():
        report(name)
        sizes = [2.0 ** (-j / 4) for j in range(first, 25)]
        cases = [(name, galvi.gauss(n), n, h) for n in NS[name] for h in sizes]
        cases += [(f"{name}, in n", galvi.gauss(n), n, step) for n in range(3, 14)]
        if name == FREE:
            cases += [(LOBATTO, galvi.lobatto(n - 1), n, h) for n in NS[LOBATTO] for h in sizes]
        for label, rule, n, h in cases:
            method = make_method(galvi.Polynomials(n - 1), rule, CAYLEY)
            run = galvi.integrate(problem, method, h, 1)
            values = dict.fromkeys((ACTION, STEPPED), math.nan)
            if run.success:
                end = truth.run(problem, h, {"samples": 1}).q[-1]
                exact = exact_lagrangian(problem, truth, run.q[1], h)
                values[ACTION] = abs(discrete_lagrangian(run) - exact)
                values[STEPPED] = np.max(abs(run.q[1] - end))
            measured += rows(values, study=label, n=n, step=h, steps=1, status=failure(run))
        path = truth.run(problem, step, {"samples": 400})
        omega = problem.system.velocity(path.p)
        for n in range(3, 14):
            best = distance_of_polynomials(path.q, omega, n - 1)
            measured.append(row(study=f"{name}, in n", quantity=BEST, n=n, value=best))
        for h in (step, *sizes[::4]):
            last = truth.run(problem, h, {"samples": 1}).q[-1]
            along, _ = action_along(problem, h, OTHER)
            distance = abs(along - exact_lagrangian(problem, truth, last, h))
            measured.append(row(study=name, quantity=ORACLES, step=h, value=distance))
    return table_of([*measured, *departures(make_method)])


def exact_lagrangian(problem: Problem, truth: Contender, last: Array, h: float) -> float:
    """The action of the motion from the problem's attitude to ``last`` in the time h.

    It is h T for a free body, whose kinetic energy T is constant, else Romberg's integral; NaN if
    no such motion is found.
    """
    motion = between(problem, last, h, truth, samples=1)
    if motion is None:
        return math.nan
    system: Any = problem.system
    if system.potential is None:
        return 0.5 * h * motion.problem.v0 @ system.inertia @ motion.problem.v0
    return action_along(motion.problem, h, truth)[0]


def departures(make_method: MakeMethod) -> Iterator[dict[str, Any]]:
    """Rows of the relative departure of L_d - S from its leading term in a steady rotation.

    S = J theta^2 / (2 h) is the exact action, and the leading term is
    h^(2 n - 1) J |xi^(n)|^2 ((n - 1)! / (2 n - 2)!)^2 / (2 (2 n - 1)). Steps whose error is
    round-off have no row.
    """
    body = galvi.problems.free_rigid_body(velocity=(0.0, 0.0, 1.0))
    for n, rate in RATES.items():
        ratio = rate * math.factorial(n - 1) / math.factorial(2 * n - 2)
        for h in [2.0 ** (-j / 2) for j in range(-1, 12)]:
            run = galvi.integrate(body, method_on_group(make_method, n), h, 1)
            turn = math.atan2(run.q[1][1, 0], run.q[1][0, 0])
            error = abs(discrete_lagrangian(run) - 3.4 * turn**2 / (2.0 * h))
            leading = 3.4 * h ** (2 * n - 1) * ratio**2 / (2 * (2 * n - 1))
            if error > 2e-13:
                yield row(quantity=DEPARTURE, n=n, step=h, value=abs(error / leading - 1.0))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The orders of both errors, their bases and powers in n, and the order of DEPARTURE."""
    numbers: dict[str, Measurement] = {
        f"order of the {quantity}, {name}, n = {n}": readings.order(
            table, floor, study=name, quantity=quantity, n=n
        )
        for quantity, floor in FLOOR.items()
        for name, ns in NS.items()
        for n in ns
    }
    for n in NS[PENDULUM]:
        order = f"order of the {ACTION}, {PENDULUM}, n = {n}"
        numbers[f"{order}, against the bound"] = numbers[order]
    for name in MOTIONS:
        label, word = f"{name}, in n", name.split()[-1]
        best = readings.base(table, LONG_FLOOR, study=label, quantity=BEST)
        error = readings.decay(table, LONG_FLOOR, study=label, quantity=ACTION)
        both = [readings.values(table, "n", study=label, quantity=q) for q in (BEST, ACTION)]
        numbers |= {
            f"base of the {ACTION}, {name}": error,
            f"base of the {ACTION} against that of the best approximation, {name}": error.fit,
            f"power of the {BEST} in the {ACTION}, {name}": algebraic(
                both[0].tolist(), both[1].tolist(), floor=LONG_FLOOR
            ),
            f"best_{word}": best.rate,
            f"error_{word}": best.uncertainty,
        }
    for n in RATES:
        h, values = series(table, "step", quantity=DEPARTURE, n=n)
        numbers[f"order of the {DEPARTURE}, n = {n}"] = algebraic(
            h.tolist(), values.tolist(), floor=1e-3, ceiling=1.0
        )
    numbers["apart"] = numbers[ORACLES] = readings.largest_of(table, quantity=ORACLES)
    return numbers


COARSE = WithSettings(RIGID_DOP853, {"rtol": 1e-8, "atol": 1e-8})
FAULTS = {
    "clock reversed": of_motion(reversed_clock),
    "a coarse reference": Fault(wrong={f"{__name__}.OTHER": always(COARSE)}),
    "L_d off by 1e-4": Fault(wrong={f"{__name__}.discrete_lagrangian": scaled(1.0 + 1e-4)}),
    "another constant": Fault(wrong={f"{__name__}.RATES": always({3: 0.51, 5: 1.02})}),
    "distances to the third power": Fault(
        wrong={
            f"{__name__}.distance_of_polynomials": lambda original: (
                lambda *curve: original(*curve) ** 3
            )
        }
    ),
}

"""V33: lengths and costs of steps compared with other methods, and whether curves keep pace."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    Trajectory,
    failure,
    method_of,
    pick,
    readings,
    rows,
    series,
    table_of,
    times,
)
from benchmarks.claims.vector_spaces.curves_beside_steps import bases_and_orders, errors_of_curves
from benchmarks.claims.vector_spaces.v09_solar_system_in_long_steps import (
    MERCURY,
    STEP,
    STEPS,
    VISIBLE,
    N,
)
from benchmarks.measures.orbit_shape import period
from references import Contender
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import BEST as ORDER_8
from references.rebound.leapfrog import LEAPFROG
from references.rebound.whfast import WHFAST
from references.textbook.euler import STORMER_VERLET
from references.textbook.nystrom import Nystrom

RK4 = Nystrom(
    "the classical Runge-Kutta method",
    order=4,
    stages=((0.0,) * 4, (0.0,) * 4, (0.25, 0.0, 0.0, 0.0), (0.0, 0.5, 0.0, 0.0)),
    nodes=(0.0, 0.5, 0.5, 1.0),
    position=(1.0 / 6.0, 1.0 / 6.0, 1.0 / 6.0, 0.0),
    velocity=(1.0 / 6.0, 1.0 / 3.0, 1.0 / 3.0, 1.0 / 6.0),
)
GALERKIN, NEWTON = "Galerkin", "Galerkin, by Newton's method"
LEAP, KUTTA, EIGHT, WISDOM = "leapfrog", "Runge-Kutta 4", "leapfrog of order 8", "WHFast"
# Label -> (contender, options, largest j of the step sizes STEP / 2^(j/2)).
EXPLICIT: Mapping[str, tuple[Contender, Mapping[str, Any], int]] = {
    LEAP: (STORMER_VERLET, {}, 26),
    KUTTA: (RK4, {}, 24),
    EIGHT: (LEAPFROG, ORDER_8, 12),
    WISDOM: (WHFAST, {}, 12),
}
FINE = 41  # largest number of basis functions in V9's scan
ERROR, FARTHEST = "distance to IAS15", "Mercury's distance from the Sun, over the mean one"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For each method, in `label`, and step: the largest distance of a body from IAS15 at intervals
    of 100 days, and Mercury's largest distance from the Sun; and rows of `errors_of_curves`."""
    problem = galvi.problems.solar_system()
    report("IAS15")
    truth = IAS15.run(problem, STEP * STEPS, {"samples": STEPS})
    table = []
    for label, n, solver in (
        (GALERKIN, N, "fixed_point"),
        (GALERKIN, FINE, "fixed_point"),
        (NEWTON, N, "newton"),
    ):
        report(f"{label}, n = {n}")
        run = galvi.integrate(problem, method_of(make_method, n), STEP, STEPS, solver=solver)
        table += _distances(run, truth, label=label, n=n, step=STEP, steps=STEPS)
    for label, (contender, options, last) in EXPLICIT.items():
        report(label)
        for j in (*range(12), *range(12, last + 1, 2 if quick else 1)):
            k = round(2.0 ** (j / 2))
            setting = {"step": STEP / k, "save_every": k, **options}
            run = contender.run(problem, STEP * STEPS, setting)
            table += _distances(run, truth, label=label, step=STEP / k, steps=k * STEPS)
    return table_of([*table, *errors_of_curves(make_method, quick, report)])


def _distances(run: Trajectory, truth: Trajectory, **where: Any) -> list[dict[str, Any]]:
    distance = np.max(np.linalg.norm(run.q - truth.q, axis=-1))
    away = np.max(np.linalg.norm(run.q[:, MERCURY] - run.q[:, 0], axis=-1))
    values = {ERROR: distance, FARTHEST: away / mean_distance(run.problem)}
    work = run.counts.get("force_evaluations", math.nan)  # REBOUND counts none
    return rows(values, status=failure(run), force_evaluations=work, **where)


def mean_distance(problem: Any) -> float:
    """Mercury's mean distance from the Sun, by Kepler's third law."""
    gm = problem.system.G * (problem.system.masses[0] + problem.system.masses[MERCURY])
    return float(gm * (period(problem, MERCURY) / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)


def longest(
    table: DataFrame, label: str, limit: float, quantity: str = ERROR, **where: Any
) -> float:
    """The longest step for which, as for all shorter ones, a quantity is at most `limit`.

    For errors it is interpolated between two steps by a power law. NaN if the quantity exceeds the
    limit in the shortest step.
    """
    h, values = series(table, "step", quantity=quantity, label=label, **where)
    outside = np.flatnonzero(~(values <= limit))
    first = int(outside[-1]) + 1 if outside.size else 0
    if first == len(h):
        return math.nan
    if first == 0 or quantity != ERROR or not math.isfinite(values[first - 1]):
        return float(h[first])
    x, y = np.log(h[first - 1 : first + 1]), np.log(values[first - 1 : first + 1])
    return float(np.exp(np.interp(math.log(limit), y[::-1], x[::-1])))


def read(table: DataFrame) -> dict[str, Measurement]:
    """Ratios of steps with equal errors and of longest accurate or bounded steps, of costs, and the
    numbers of `bases_and_orders`."""

    def of_one_error(label: str, n: int) -> float:
        error = readings.largest_of(table, quantity=ERROR, label=GALERKIN, n=n)
        return longest(table, label, error)

    def work(label: str, **where: int) -> float:
        """The smallest number of force evaluations per step; NaN if they were not counted."""
        runs = pick(table, quantity=ERROR, label=label, **where)
        return readings.smallest((runs["force_evaluations"] / runs["steps"]).to_numpy())

    def cost(label: str, n: int) -> float:
        """Evaluations of the Galerkin method over those of another method with the same error."""
        return work(GALERKIN, n=n) * of_one_error(label, n) / (STEP * work(label))

    visible = VISIBLE * mean_distance(galvi.problems.solar_system())
    step = longest(table, GALERKIN, visible, n=N)
    best = readings.smallest(np.array([of_one_error(label, N) for label in (EIGHT, WISDOM)]))
    either = readings.smallest(np.array([work(GALERKIN, n=N), work(NEWTON)]))
    over, evaluations = "log10 of the Galerkin step over", "force evaluations"
    one_error = ((LEAP, N), (KUTTA, N), (KUTTA, FINE))
    logarithms = {
        f"largest {over} that of {EIGHT} or of {WISDOM} with its error, n = {N}": STEP / best,
        **{
            f"{over} that of {label} with its error, n = {n}": STEP / of_one_error(label, n)
            for label, n in one_error
        },
        **{
            f"{over} the longest of {label} that is accurate, n = {N}": (
                step / longest(table, label, visible)
            )
            for label in (LEAP, KUTTA)
        },
        **{
            f"{over} the longest of {label} in which Mercury stays": (
                step / longest(table, label, 2.0, FARTHEST)
            )
            for label in (LEAP, KUTTA)
        },
        **{
            f"log10 of the {evaluations} in a Galerkin step over those of {label}, n = {N}": (
                either / work(label)
            )
            for label in (LEAP, KUTTA)
        },
    }
    return {
        **{name: math.log10(ratio) for name, ratio in logarithms.items()},
        **{
            f"{evaluations} of the Galerkin method over those of {label} with its error, n = {n}": (
                cost(label, n)
            )
            for label, n in one_error
        },
        **bases_and_orders(table),
    }


def in_each_others_place(table: DataFrame) -> None:
    """Exchange the leapfrogs of orders 2 and 8, for a planted fault."""
    table["label"] = table["label"].replace({LEAP: EIGHT, EIGHT: LEAP})


def dearer(table: DataFrame, by: float) -> None:
    """Multiply the force evaluations of Galerkin steps by a factor, for a planted fault."""
    table.loc[table["label"].isin([GALERKIN, NEWTON]), "force_evaluations"] *= by


def worse_in_n(table: DataFrame) -> None:
    """Multiply errors of curves by 1.1^n, for a planted fault."""
    curve = table["quantity"] == ENDS_AND_CURVE[1]
    table.loc[curve, "value"] *= 1.1 ** table.loc[curve, "n"]


FAULTS = {
    "Galerkin steps of a larger error": Fault(table=times(1e4, label=GALERKIN, quantity=ERROR)),
    "leapfrogs of order 2 and 8 in each other's place": Fault(table=in_each_others_place),
    "orbits that leave in short steps": Fault(table=times(4.0, power=1.0, quantity=FARTHEST)),
    "passes of one evaluation": Fault(table=partial(dearer, by=0.02)),
    "steps ten times as dear": Fault(table=partial(dearer, by=10.0)),
    "curves that lose a tenth with each n": Fault(table=worse_in_n),
}

"""V24: one brownout particle, error against processor time (M figure 3, right)."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from benchmarks.claims.kit import (
    OTHER_TRUTH,
    DataFrame,
    Estimate,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    failure,
    number,
    row,
    rows,
    table_of,
    times,
)
from benchmarks.claims.vector_spaces.brownout_particle import (
    AWAY,
    ERROR,
    EULER,
    PIECES,
    error_of,
    run_of,
    truth,
)
from benchmarks.statistics.timing import interleaved, warmed
from benchmarks.work_precision.fronts import seconds_at
from references.scipy.ivp import RADAU

DEGREES = (1, 2, 4, 6)
SECONDS, FASTEST, SLOWEST = "seconds", "seconds, fastest round", "seconds, slowest round"
# (times of Euler's method, times of the degrees) of ratios: of medians, and the two extremes.
CLOCKS = ((SECONDS, SECONDS), (FASTEST, SLOWEST), (SLOWEST, FASTEST))
EVALUATIONS = "force evaluations"
REFERENCE_DISTANCE = "distance between the two references [m]"
SMALL_ERROR = 2e-4  # m, a small error, reached at low order with 65,536 steps
FINE_ERROR = 1e-7  # m, out of reach at low order
COARSE_ERROR = 2e-2  # m, a hundred times SMALL_ERROR


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For each contender, in `study`, and number of steps: 'error of the place' [m], 'force
    evaluations', and 'seconds' with the fastest and the slowest of interleaved rounds; and the
    distance between DOP853 and Radau.
    """
    euler = (4, 16, 64, 256, 1024, 8192) if quick else (4, 16, 64, 256, 1024, 4096, 8192, 16384)
    sizes = (1, 2, 4, 8, 32) if quick else (1, 2, 3, 4, 6, 8, 16, 32)
    cases = [
        *((0, size) for size in euler),
        *((N, size) for N in DEGREES for size in sizes if N < 6 or size <= 8),  # then round-off
    ]
    calls = [partial(run_of, make_method, AWAY, *case) for case in cases]
    runs, seconds = zip(*map(warmed, calls), strict=True)
    timings = interleaved(calls, 3, 0.003 if quick else 0.03, seconds)
    distance = np.max(abs(truth(AWAY, RADAU) - truth(AWAY)))
    table = [row(quantity=REFERENCE_DISTANCE, value=distance)]
    for (degree, size), run, timing in zip(cases, runs, timings, strict=True):
        values = {
            ERROR: error_of(run, AWAY),
            EVALUATIONS: run.counts["force_evaluations"],
            SECONDS: timing.seconds,
            FASTEST: timing.low,
            SLOWEST: timing.high,
        }
        steps = PIECES * size
        table += rows(values, study=label_of(degree), steps=steps, status=failure(run))
    return table_of(table)


def label_of(degree: int) -> str:
    """The name of the study of a degree, 0 for semi-implicit Euler."""
    return f"N = {degree}" if degree else EULER


def read(table: DataFrame) -> dict[str, Measurement]:
    """Ratios of evaluations, which are the same on every machine; and ratios of times, whose
    uncertainty is half the distance between those of the extreme rounds."""
    runs = table.pivot(index=["study", "steps"], columns="quantity", values="value")

    def least_cost(error: float, cost: str, *degrees: int) -> float:
        """The lowest cost at which runs of these degrees reach the error; NaN if none does."""
        of_degrees = runs.loc[list(map(label_of, degrees))]
        return seconds_at(of_degrees[ERROR], of_degrees[cost], error)

    def ratio(error: float, euler: str = EVALUATIONS, high: str = EVALUATIONS) -> float:
        return least_cost(error, euler, 0) / least_cost(error, high, *DEGREES)

    def crossing(*costs: str) -> float:
        """The error below which high order is cheaper at all errors that both reach; 0 if it is
        not cheaper at the smallest of these, NaN if there are none."""
        errors = np.geomspace(2.0, 1e-4, 200)  # m; the particle is carried 8 m
        ratios = np.array([ratio(error, *costs) for error in errors])
        reached, dearer = errors[np.isfinite(ratios)], errors[ratios <= 1.0]
        if not reached.size:
            return float("nan")
        smallest = float([2.0, *dearer][-1])
        return smallest if smallest > reached[-1] else 0.0

    def timed(of_clocks: Callable[..., float]) -> Estimate:
        median, *ends = (of_clocks(*clocks) for clocks in CLOCKS)
        return Estimate(median, 0.5 * abs(ends[0] - ends[1]) or None)

    growth = np.log(ratio(SMALL_ERROR) / ratio(COARSE_ERROR)) / np.log(COARSE_ERROR / SMALL_ERROR)
    low, high = (least_cost(FINE_ERROR, EVALUATIONS, degree) for degree in (2, 6))
    return {
        f"{EVALUATIONS} of {EULER} over those of the best N at {SMALL_ERROR:g} m": ratio(
            SMALL_ERROR
        ),
        "power of the inverse error with which that ratio grows, from "
        f"{COARSE_ERROR:g} to {SMALL_ERROR:g} m": growth,
        f"{EVALUATIONS} of N = 2 over those of N = 6 at {FINE_ERROR:g} m": low / high,
        f"time of {EULER} over that of the best N at {SMALL_ERROR:g} m": timed(
            partial(ratio, SMALL_ERROR)
        ),
        f"error below which high order is cheaper in time than {EULER} [m]": timed(crossing),
        REFERENCE_DISTANCE: number(table, quantity=REFERENCE_DISTANCE),
    }


def as_steep(table: DataFrame) -> None:
    """Change the evaluations of the degrees to those of a method of first order, for a fault."""
    high = table["study"] != EULER
    errors = table.loc[high & (table["quantity"] == ERROR), "value"]
    table.loc[high & (table["quantity"] == EVALUATIONS), "value"] = 1.0 / errors.to_numpy()


FAULTS = {
    "a truth of another motion": OTHER_TRUTH,
    "Euler's method cheaper by a thousand": Fault(
        table=times(1e-3, study=EULER, quantity=EVALUATIONS)
    ),
    "costs that grow as fast as Euler's": Fault(table=as_steep),
}

"""V14: Galerkin curves against exact motions with the same end points (H thms. 2.3.6, 2.3.7).

On the oscillator C_f of H's theorem 2.3.8 is min(m / 4h, (m pi^2 / 2h^2 - k) / 2h): m / 4h for h
below pi / sqrt(3) = 1.81.
"""

from __future__ import annotations

import math
from collections.abc import Iterable

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    DataFrame,
    Estimate,
    MakeMethod,
    Measurement,
    Problem,
    Report,
    Trajectory,
    failure,
    method_of,
    number,
    readings,
    rows,
    table_of,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    STEP,
    convergence_of_polynomials,
    oracles,
    problem,
)
from benchmarks.measures.boundary_motion import CURVE, ENDS, IN_H, IN_N, BoundaryValueMotion
from references import Contender
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR

LARGEST = "distance of the curve in L^infinity"
RATIO = f"largest {LARGEST}, over max(1 / h, 1) of that in W^{{1,1}}"
COERCIVE = "oscillator, h-refinement, one step"
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 3e-14, LARGEST: 3e-14}

# q has a branch point (t - t*)^(1/2) at -1 + 0.2986 i of the step [-1, 1], so that the Legendre
# coefficients of q' are of size n^0 r^-n (Darboux). The curve leaves out those from P_(n - 1) on:
# its velocity errs by n^(-1/2) r^-n in the mean, the curve by the integral of P_(n - 1), n^(-3/2)
# r^-n, and the end of the step by n^0 r^-2n, see V3.
POWERS = {ENDS: 0.0, CURVE: 0.5, LARGEST: 1.5}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """For one step the error at its end and the distances of its curve: over n at h = 2, over h for
    n = 3 to 6, and over h on the oscillator, as maxima over eight starts."""
    spring = galvi.problems.harmonic_oscillator()
    angles = np.pi * np.arange(8) / 8
    around = [spring.with_initial_state([np.cos(a)], [-np.sin(a)]) for a in angles]
    halves = [2.0 ** (-j / 2) for j in (range(3, 13) if quick else range(15))]
    quarters = [2.0 ** (-j / 4) for j in range(-3, 25)]
    series: dict[str, tuple[Contender, list[Problem], Iterable[int], list[float]]] = {
        IN_N: (KEPLER, [problem()], range(6, 31, 4) if quick else range(5, 34), [STEP]),
        IN_H: (KEPLER, [problem()], NS, halves),
        COERCIVE: (OSCILLATOR, around, NS, quarters),
    }
    observations = oracles("oracles", STEP, 1)
    for name, (truth, starts, ns, sizes) in series.items():
        for h in sizes:
            report(f"{name}, h = {h:.4g}")
            motions = [BoundaryValueMotion(start, h, truth) for start in starts]
            for n in ns:
                method = method_of(make_method, n)
                runs = [galvi.integrate(start, method, h, 1) for start in starts]
                errors = np.max(list(map(errors_of, motions, runs)), axis=0)
                observations += rows(
                    dict(zip((*FLOOR, RATIO), errors, strict=True)),
                    study=name,
                    n=n,
                    step=h,
                    steps=1,
                    status=" ".join(filter(None, map(failure, runs))),
                )
    return table_of(observations)


def errors_of(motion: BoundaryValueMotion, run: Trajectory) -> tuple[float, ...]:
    """(error at a step's end, distance of its curve in W^{1,1}, distance in L^infinity, RATIO); the
    error is that of q, on the oscillator of q and p."""
    missed = motion.error(run)
    if motion.truth is OSCILLATOR:
        exact = OSCILLATOR.run(motion.problem, motion.step, {"samples": 1})
        missed = max(missed, abs(float(run.p[-1, 0] - exact.p[-1, 0])))
    in_w11, largest = motion.distances(run)
    return missed, in_w11, largest, largest / in_w11 * min(motion.step, 1.0)


def read(table: DataFrame) -> dict[str, Measurement]:
    """Bases and orders of steps and curves; the largest RATIO; and on the oscillator the orders of
    the distance over C_f^-1, or C_f^(-1/2), times the root of the error of one step."""
    decay = readings.decay(table, FLOOR[ENDS], study=IN_N, quantity=ENDS)
    numbers: dict[str, Measurement] = {
        "base of the step's error": decay,
        "base of the step's error, against K": decay.fit,
    }
    for quantity in (CURVE, LARGEST):
        numbers[f"base of the {quantity}"] = readings.base(
            table, FLOOR[quantity], power=(POWERS[quantity], 0.0), study=IN_N, quantity=quantity
        )
        for n in NS:
            numbers[f"order of the {quantity}, n = {n}"] = readings.order(
                table, FLOOR[quantity], study=IN_H, quantity=quantity, n=n
            )
    kepler = table[(table["study"] != COERCIVE) & (table["step"] != 1.0)]  # n = 3 has none
    orders = np.array([order_over_root(table, n) for n in NS])
    highest = orders[np.argmax(orders[:, 0])]
    farthest = orders[np.argmax(np.abs(orders[:, 0] - 0.5))]
    root = convergence_of_polynomials(0.0, STEP)
    return numbers | {
        RATIO: readings.largest_of(kepler, quantity=RATIO),
        "order of distance / (C_f^-1 sqrt(error of one step)), oscillator, largest over n": (
            Estimate(highest[0] - 1.0, highest[1])
        ),
        "order of distance / (C_f^(-1/2) sqrt(error of one step)), oscillator, farthest from 0 "
        "over n": Estimate(farthest[0] - 0.5, farthest[1]),
        "root": root,
        "square": root**2,
        "apart": number(table, quantity=ORACLES),
    }


def order_over_root(table: DataFrame, n: int) -> tuple[float, float]:
    """The order in h of the curve's distance over the root of the error of one step, on the
    oscillator, and its standard error; NaN if one of the two has no order."""
    curve, ends = (
        readings.order(table, FLOOR[quantity], study=COERCIVE, quantity=quantity, n=n)
        for quantity in (CURVE, ENDS)
    )
    if curve.relapse or ends.relapse:
        return math.nan, math.nan
    return curve.rate - 0.5 * ends.rate, math.hypot(curve.uncertainty, 0.5 * ends.uncertainty)

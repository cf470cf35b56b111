"""V28: rates in N and h for motions with s derivatives, and M's open question (M (13), sec. 5)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
from scipy.integrate import quad

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    DataFrame,
    Estimate,
    Fault,
    Fit,
    MakeMethod,
    Measurement,
    Report,
    failure,
    of_motion,
    readings,
    row,
    rows,
    scaled,
    table_of,
    with_arguments,
)
from benchmarks.claims.vector_spaces import singular_approximation
from benchmarks.claims.vector_spaces.singular_approximation import (
    closed_errors,
    path_error,
    quadrature_error,
)
from benchmarks.measures.best_approximation import best_errors
from benchmarks.test_problems.oscillators import SingularDrive

BEST, CLOSED_FORM_DISTANCE = "error of the best polynomial", "relative distance of its closed form"
LARGEST, PATH = "e_max", "error along the path"
INSIDE, END = (0.5, 0.3, 0.1), 0.0  # t* in [0, 1]
EXPONENTS = (0.49, 0.45, 0.25, -0.25, -0.55)
ROUGH = (0.49, 0.45, 0.25)  # exponents b for the rates in h
POWERS = (16, 24, 32, 48, 64, 96, 128, 192)  # degrees N; the quick form leaves out the last
AT_END = POWERS[:5]  # degrees for t* = 0, where errors fall with twice the power
DEGREES = (1, 2, 4)
PLACE = 1.0 / 3.0  # t*; with 3 m + 1 subintervals, at a third of the one that contains it
COUNTS = (4, 7, 10, 16, 22, 31, 43, 64, 91, 127, 181, 256)  # the quick form has nine
FLOOR = 1e-12


def named(singularity: float, b: float) -> str:
    """The name of the study of a motion."""
    return f"t* = {singularity:g}, b = {b:g}"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Rows of the error of the best polynomial on [0, 1] over the degree, n = N + 1, with its
    distance from the closed form; of e_max and of the error of galvi's step through t* over the
    number of subintervals; and of the motion's distance from an integral.
    """
    observations: list[dict[str, Any]] = []
    for singularity in (*INSIDE, END):
        report(f"t* = {singularity:g}")
        for b in EXPONENTS:
            degrees = AT_END if singularity == END else POWERS[:-1] if quick else POWERS
            motion = SingularDrive(singularity, b).motion
            best = np.array([quadrature_error(motion, singularity, 0.0, 1.0, N) for N in degrees])
            distances = abs(closed_errors(singularity, b, 0.0, 1.0, degrees) / best - 1.0)
            for quantity, values in ((BEST, best), (CLOSED_FORM_DISTANCE, distances)):
                for N, value in zip(degrees, values, strict=True):
                    observations.append(
                        row(study=named(singularity, b), quantity=quantity, n=N + 1, value=value)
                    )
    for b in ROUGH:
        report(f"K subintervals, b = {b:g}")
        drive = SingularDrive(PLACE, b, spring=True)
        observations.append(
            row(study=named(PLACE, b), quantity=ORACLES, value=from_integral(drive))
        )
        for degree in DEGREES:
            method = make_method(galvi.Polynomials(degree), galvi.gauss(degree + 1))
            for count in COUNTS[:9] if quick else COUNTS:
                observations += in_step(drive, method, degree, count)
    return table_of(observations)


def in_step(drive: SingularDrive, method: Any, degree: int, count: int) -> list[dict[str, Any]]:
    """Rows of e_max on `count` subintervals of [0, 1], and of the error in the step through t*."""
    edges = np.linspace(0.0, 1.0, count + 1)
    k = int(drive.singularity * count)
    errors = best_errors(drive.motion, edges, degree)
    errors[k] = quadrature_error(drive.motion, drive.singularity, edges[k], edges[k + 1], degree)
    run = galvi.integrate(drive.problem(float(edges[k])), method, 1.0 / count, 1)
    path = path_error(run, drive.motion, drive.singularity) if run.success else np.nan
    return rows(
        {LARGEST: np.max(errors), PATH: path},
        study=named(drive.singularity, drive.b),
        n=degree + 1,
        step=1.0 / count,
        steps=count,
        status=failure(run),
    )


def from_integral(drive: SingularDrive) -> float:
    """The largest distance of |u| and |u'| from int_0^x f(x - r) r^-b dr, f = sin and cos, x =
    |t - t*|, by QUADPACK's QAWS, at three times."""
    distances = []
    for t in (0.1, 0.4, 0.9):
        x = abs(t - drive.singularity)
        for part, f in zip(drive.motion(np.array(t)), (np.sin, np.cos), strict=True):
            integral = quad(lambda r, f=f, x=x: f(x - r), 0.0, x, weight="alg", wvar=(-drive.b, 0))
            distances.append(abs(abs(part) - integral[0]))
    return float(np.max(distances))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The powers of N for each t* and b, and the orders in h."""

    def order(quantity: str, b: float, N: int) -> Fit:
        return readings.order(table, FLOOR, study=named(PLACE, b), quantity=quantity, n=N + 1)

    powers = {
        (singularity, b): readings.power(table, FLOOR, study=named(singularity, b), quantity=BEST)
        for singularity in (*INSIDE, END)
        for b in EXPONENTS
    }
    claimed = 1.5 - np.array(EXPONENTS)
    *inside, at_end = np.array([fit.rate for fit in powers.values()]).reshape(-1, len(claimed))
    gaps = [
        Estimate(
            powers[singularity, b].rate - SingularDrive(singularity, b).smoothness + 1.0,
            powers[singularity, b].uncertainty,
        )
        for singularity in INSIDE
        for b in EXPONENTS
    ]
    largest = np.array([[order(LARGEST, b, N).rate for b in ROUGH] for N in DEGREES])
    distances = readings.values(
        table, quantity=CLOSED_FORM_DISTANCE
    )  # NaN where the closed form has no digits
    distance = readings.largest(distances[np.isfinite(distances)])
    motion = readings.largest_of(table, quantity=ORACLES)
    return {
        **{
            f"power of 1 / N, {named(singularity, b)}": powers[singularity, b]
            for singularity in (INSIDE[0], END)
            for b in EXPONENTS
        },
        **{
            f"largest power of 1 / N over b, s = 2, t* = {singularity:g}": float(
                np.max(rates[claimed < 2.0])
            )
            for singularity, rates in zip(INSIDE[1:], inside[1:], strict=True)
        },
        "largest departure of the power of 1 / N from 3/2 - b, t* inside": float(
            np.max(abs(inside - claimed))
        ),
        "largest departure of the power of 1 / N from 3 - 2 b, t* = 0": float(
            np.max(abs(at_end - 2.0 * claimed))
        ),
        "least of the power of 1 / N less s - 1, t* inside": min(gaps, key=lambda gap: gap.value),
        "least order of e_max, all b and N": np.min(largest),
        "largest departure of the order of e_max from 3/2 - b, all b and N": np.max(
            abs(largest - 1.5 + np.array(ROUGH))
        ),
        **{
            f"order of the error along the path, b = {b:g}, N = {N}": order(PATH, b, N)
            for b in ROUGH
            for N in DEGREES
        },
        "apart": distance,
        "motion": motion,
        f"{ORACLES}, best approximation, relative": distance,
        f"{ORACLES}, motion": motion,
    }


FAULTS = {
    "a coarse quadrature": Fault(
        wrong={
            f"{singular_approximation.__name__}.graded_nodes": with_arguments(
                lambda singularity, start, stop, points: (singularity, start, stop, points // 4)
            )
        }
    ),
    "another motion": Fault(
        wrong={"benchmarks.test_problems.oscillators.SingularDrive.motion": scaled(1.0 + 1e-4)}
    ),
    "a singularity elsewhere": of_motion(lambda problem: replace(problem, t0=problem.t0 - 0.01)),
}

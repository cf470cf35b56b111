"""L11: stationary points are minima, and coercive, below a step (H lemmas 3.3.1 and 3.3.2)."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    CAYLEY,
    Array,
    Fault,
    MakeMethod,
    Problem,
    Report,
    readings,
    scaled,
    with_arguments,
)
from benchmarks.claims.lie_groups.pendulum_motion import problem
from benchmarks.measures.second_variation import constants, over_lower_form, smallest

LONG_STEP = 2.2  # a step well beyond that at which the least eigenvalue is 0
PENDULUM, FREE = "3D pendulum, Cayley chart", "free rigid body, exponential chart"


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Least eigenvalues of the discrete second variation, relative to the integral of |dxi'|^2 and
    to H's lower form; and the step at which the former is 0, over H's two bounds."""
    h = np.round(np.arange(0.1, 2.41, 0.1 if quick else 0.05), 10)
    numbers: dict[str, float] = {}
    for name, start, chart in (
        (FREE, galvi.problems.free_rigid_body(), galvi.Exponential()),
        (PENDULUM, problem(), CAYLEY),
    ):
        report(name)
        method = make_method(galvi.Polynomials(15), galvi.gauss(16), chart)
        eigenvalue, minimum, coercive, form = np.transpose([of_step(start, method, s) for s in h])
        below, form = eigenvalue[h < minimum], form[np.isfinite(form)]
        numbers |= {
            f"least eigenvalue over all steps below the bound, {name}": readings.smallest(below),
            "second variation over H's lower form, least over all steps below the coercive bound, "
            f"{name}": readings.smallest(form),
        }
    numbers |= {
        "zero": first_zero(h, eigenvalue),
        "minimum": first_zero(h, minimum - h),
        "coercive": first_zero(h, coercive - h),
        f"least eigenvalue at h = {LONG_STEP:g}, {name}": eigenvalue[h == LONG_STEP].item(),
    }
    for bound, word in (("minimum", ""), ("coercive", "coercive ")):
        quantity = f"step where the least eigenvalue is 0, over H's {word}bound on the step, {name}"
        numbers[quantity] = numbers["zero"] / numbers[bound]
    return numbers


def of_step(start: Problem, method: Any, h: float) -> tuple[float, float, float, float]:
    """(least eigenvalue, bound for minima, bound for coercivity, second variation over the lower
    form) of one step; NaN for a failed run."""
    run = galvi.integrate(start, method, h, 1)
    if not run.success:
        return (np.nan,) * 4
    C = constants(run)
    return smallest(run), C.minimum, C.coercive, over_lower_form(run, C)


def first_zero(h: Array, values: Array) -> float:
    """The first h at which positive values reach 0, by linear interpolation between two steps; NaN
    if they never do, or are not positive at first."""
    nonpositive = np.flatnonzero(values <= 0.0)
    if not nonpositive.size or nonpositive[0] == 0:
        return np.nan
    neighbours = [nonpositive[0], nonpositive[0] - 1]
    return float(np.interp(0.0, values[neighbours], h[neighbours]))


VARIATION = "benchmarks.measures.second_variation"
FAULTS = {
    "a larger C_xi'": Fault(
        wrong={
            f"{VARIATION}.Constants": with_arguments(
                lambda speed, *constants: (4.0 * speed, *constants)
            )
        }
    ),
    "no C_V": Fault(
        wrong={
            f"{VARIATION}.Constants": with_arguments(
                lambda speed, configuration, well: (speed, configuration, 0.0)
            )
        }
    ),
    "no potential": Fault(wrong={f"{VARIATION}._potential": scaled(0.0)}),
}

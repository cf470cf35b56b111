"""The two-body problem of H 2.4.2, shared by V3 to V8."""

from __future__ import annotations

import cmath
import math
from collections.abc import Iterable
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    Case,
    MakeMethod,
    Problem,
    Report,
    at_fixed_time,
    heavier,
    of_motion,
    refine,
    reversed_clock,
    row,
    with_fixed_number,
)
from references.closed_forms.kepler import KEPLER
from references.rebound.ias15 import IAS15

STEP, STEPS = 2.0, 100
FLOOR = 2e-11  # round-off of the phase after 32 revolutions; 8e-12 was measured at n = 56
INVARIANTS = ("energy error along the curve", "angular momentum error along the curve")

# Where the complex distance vanishes, 1 - e cos E = 0, Kepler's equation is stationary in E, so
# that E and with it q = (cos E - e, sqrt(1 - e^2) sin E) have branch points (t - t*)^(1/2), at
# t* = +- i (arccosh(1/e) - sqrt(1 - e^2)) about each pericentre.
ECCENTRICITY = 0.6
SINGULARITY = math.acosh(1.0 / ECCENTRICITY) - math.sqrt(1.0 - ECCENTRICITY**2)  # 0.2986

IN_N = "n-refinement"
FIXED_TIME = "h-refinement, T = 2"
OTHER_MOTIONS = {
    "clock reversed": of_motion(reversed_clock),
    "centre heavier": of_motion(heavier),
}


def problem(start: float = 0.0) -> Problem:
    """The Kepler problem with GM = a = 1, e = 0.6, from the time `start` after the pericentre."""
    first = galvi.problems.kepler(eccentricity=ECCENTRICITY)
    if not start:
        return first
    motion = KEPLER.run(first, start % (2.0 * math.pi), {"samples": 1})
    return Problem(first.system, motion.q[-1], first.system.velocity(motion.p)[-1])


def convergence_of_polynomials(start: float, h: float) -> float:
    """1 / r for a step of length h from the time `start` after the pericentre, where r is the sum
    of half-axes of Bernstein's ellipse through the singularity of that pericentre."""
    z = 2.0 * (1j * SINGULARITY - start) / h - 1.0
    r = abs(z + cmath.sqrt(z * z - 1.0))
    return min(r, 1.0 / r)


def oracles(study: str, duration: float, samples: int) -> list[dict[str, Any]]:
    """The row ORACLES: the largest difference of a component between IAS15 and the closed form."""
    ends = [c.run(problem(), duration, {"samples": samples}).q for c in (KEPLER, IAS15)]
    distance = float(np.max(np.abs(ends[0] - ends[1])))
    return [row(study=study, quantity=ORACLES, value=distance)]


def n_refinement(
    ns: range, quantities: tuple[str, ...], make_method: MakeMethod, report: Report
) -> list[dict[str, Any]]:
    """The series IN_N of these quantities, with 100 steps of h = 2."""
    cases = [Case(n, STEP, STEPS) for n in ns]
    return refine(IN_N, problem(), KEPLER, cases, quantities, make_method, report)


def fixed_number(steps: int) -> str:
    """The name of the study of h-refinement with a fixed number of steps."""
    return f"h-refinement, {steps} steps"


def at_one_time(ns: Iterable[int], quick: bool) -> list[Case]:
    """Cases with the final time 2; the numbers of steps have the ratio sqrt(2)."""
    return at_fixed_time(ns, 2.0, [round(2.0 ** (j / 2)) for j in range(4, 16 if quick else 19)])


def in_as_many_steps(ns: Iterable[int], steps: int, quick: bool) -> list[Case]:
    """Cases with a fixed number of steps; successive step sizes have the ratio 1 / sqrt(2)."""
    return with_fixed_number(ns, steps, [2.0 ** (-j / 2) for j in range(2, 14 if quick else 18)])

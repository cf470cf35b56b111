"""The two-body problem of H 2.4.2, shared by V3 to V8."""

from __future__ import annotations

from collections.abc import Iterable

import pandas as pd

import galvi
from benchmarks.checks.claim import MakeMethod, Report
from benchmarks.measures.refinement import Case, at_fixed_time, refine, with_fixed_number
from benchmarks.store.frames import frame
from galvi import Problem
from references.closed_forms.kepler import KEPLER

STEP, STEPS = 2.0, 100
ORBIT = "Kepler, GM = 1, e = 0.6, q0 = (0.4, 0), v0 = (0, 2)"
METHOD = "Polynomials(n - 1), gauss(2 n)"
SETUP = f"{ORBIT}; {METHOD}; h = {STEP:g}, {STEPS} steps"
FLOOR = 1e-11  # round-off of the phase after 32 revolutions; 8e-12 was measured at n = 56

# With the pericentre in the middle of a step of length 2, the nearest singularity of q(t) is at
# i (arccosh(1/e) - sqrt(1 - e^2)) = 0.2986 i: polynomials on [-1, 1] converge like r^-n with
# r = 0.2986 + sqrt(1 + 0.2986^2) = 1.342, 1/r = 0.745, 1/r^2 = 0.555 (Bernstein's ellipse).
THEORY = (
    "The complex singularity of the orbit nearest to a step centred on the pericentre is 0.2986 "
    "from it: polynomials converge like 0.745^n, the method's superconvergent step ends like its "
    "square, 0.555^n"
)

DURATION = 2.0  # final time of h-refinement at fixed time
FIXED_TIME = "h-refinement, T = 2"


def problem() -> Problem:
    """The Kepler problem with GM = a = 1, e = 0.6, from the pericentre."""
    return galvi.problems.kepler(eccentricity=0.6)


def n_refinement(
    ns: range, quantities: tuple[str, ...], make_method: MakeMethod, report: Report
) -> pd.DataFrame:
    """Series 'n-refinement' at h = 2, 100 steps."""
    cases = [Case(n, STEP, STEPS) for n in ns]
    return frame(refine("n-refinement", problem(), KEPLER, cases, quantities, make_method, report))


def fixed_number(steps: int) -> str:
    """The name of the study of h-refinement with a fixed number of steps."""
    return f"h-refinement, {steps} steps"


def protocols(steps: int) -> dict[str, tuple[str, str]]:
    """Both studies of h-refinement: study -> (what is fixed, the step sizes in words)."""
    return {
        FIXED_TIME: ("fixed T", f"T = {DURATION:g}, h = T / round(2^(j/2)), j = 4, 5, ..."),
        fixed_number(steps): (
            "fixed number of steps",
            f"{steps} steps of h = 2^(-j/2), j = 2, 3, ...",
        ),
    }


def at_one_time(ns: Iterable[int], quick: bool) -> list[Case]:
    """Cases at the fixed final time; the number of steps grows by the square root of 2."""
    counts = [round(2.0 ** (j / 2)) for j in range(4, 16 if quick else 19)]
    return at_fixed_time(ns, DURATION, counts)


def in_as_many_steps(ns: Iterable[int], steps: int, quick: bool) -> list[Case]:
    """Cases with a fixed number of steps; the step shrinks by the square root of 2."""
    sizes = [2.0 ** (-j / 2) for j in range(2, 14 if quick else 18)]
    return with_fixed_number(ns, steps, sizes)

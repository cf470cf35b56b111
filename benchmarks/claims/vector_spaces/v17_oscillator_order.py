"""V17: the harmonic oscillator, order 2 N under h-refinement (M 6.1, figure 1 left)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.oscillator import (
    DURATION,
    FLOOR,
    LARGEST,
    METHOD,
    OSCILLATION,
    QUANTITY,
    TRUTH,
    refinement,
)

DEGREES = (1, 2, 3, 4, 5)
STUDY = "h-refinement, T = 8"
SETUP = (
    f"{OSCILLATION}; {METHOD}; T = {DURATION:g}, h = {LARGEST:g} / 2^(j/4), j = 0, 1, ..., "
    "rounded to whole numbers of steps"
)


def step_counts(quick: bool) -> list[int]:
    """Steps to the final time, growing by the fourth root of 2, M's among them."""
    return [round(DURATION / LARGEST * 2.0 ** (j / 4)) for j in range(21 if quick else 33)]


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'h-refinement, T = 8' for N = 1 to 5."""
    cases = at_fixed_time([degree + 1 for degree in DEGREES], DURATION, step_counts(quick))
    return frame(refinement(STUDY, cases, make_method, report))


def judge(table: DataFrame) -> list[Row]:
    """For each N the order measured in M, 2 N, and the order its theory predicts, 2 N - 1."""
    return [row for degree in DEGREES for row in _orders(table, degree)]


def _orders(table: DataFrame, degree: int) -> list[Row]:
    fit = readings.order(table, FLOOR, study=STUDY, quantity=QUANTITY, n=degree + 1)
    setup = f"{SETUP}; N = {degree}"
    return [
        V17.row(
            f"order of the error, N = {degree}",
            Order(2 * degree),
            fit,
            source="M 6.1, fig. 1 left",
            setup=setup,
            claimed=f"the measured convergence rate is 2 N = {2 * degree}",
            reason="A rule this exact gives the order of Gauss collocation with N points.",
        ),
        V17.row(
            f"order of the error, N = {degree}, against the theory",
            Order(2 * degree - 1),
            fit,
            source="M sec. 5, thm. 4 and 5",
            setup=setup,
            claimed=f"the predicted order is 2 N - 1 = {2 * degree - 1}",
            expected=EXCEEDS,
            reason="M squares its bound on the best approximation, h^N, where h^(N + 1/2) is the "
            "rate (V22): L_d is of one order more. M says that its estimate is not optimal.",
        ),
    ]


V17 = Claim(
    "V17",
    "Oscillator: order 2 N in h",
    study,
    judge,
    ("M fig. 1 left",),
    reference=f"{TRUTH.name}; SciPy DOP853 (A9)",
    statement="M 6.1, fig. 1 left: the measured order is 2 N, where M's theory predicts 2 N - 1. "
    "Measured: 2 N.",
    caught=(
        of_table(
            *(
                f"order of the error, N = {degree}{more}"
                for degree in (3, 4, 5)
                for more in ("", ", against the theory")
            ),
            A=1.0 + 1e-4,
        ),
    ),
)

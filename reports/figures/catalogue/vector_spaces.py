"""The figures of V14, V17, V18, V22, V26 and V28: fixed ends, best approximation; M 5, 6.1."""

from __future__ import annotations

from benchmarks.claims.vector_spaces import oscillator
from benchmarks.claims.vector_spaces import v14_curves_between_ends as v14
from benchmarks.claims.vector_spaces import v17_oscillator_order as v17
from benchmarks.claims.vector_spaces import v18_oscillator_convergence_in_degree as v18
from benchmarks.claims.vector_spaces import v22_best_approximation as v22
from benchmarks.claims.vector_spaces import v26_discrete_lagrangian as v26
from benchmarks.claims.vector_spaces import v28_rates_at_finite_smoothness as v28
from benchmarks.claims.vector_spaces.kepler_orbit import STEP
from benchmarks.measures.boundary_motion import CURVE, ENDS, IN_H, IN_N
from benchmarks.test_problems.oscillators import SMOOTHNESS
from reports.figures.plots.convergence import Rate, convergence, in_h
from reports.results.section import Figure

SOLID_TEXT = "Solid line: fit over the filled points"
SINGULARITIES = ((0.5, 0.49), (0.5, 0.25), (0.0, 0.49), (0.0, 0.25))  # t*, b
LARGEST_EXPONENT = v28.ROUGH[0]
POSITION_ERROR = "largest error of the position [unit of length]"


def _approximations(quantity: str, ylabel: str, rate_loss: float) -> Figure:
    """The figure of a quantity for a motion whose third derivative jumps, a line for each N.

    The claimed rate in h is min(SMOOTHNESS, N + 1) - `rate_loss`.
    """
    return Figure(
        name=f"best-approximation-{quantity.replace('_', '-')}",
        source="M sec. 5",
        title=f"{quantity} of best approximations to a motion whose third derivative jumps",
        claims=("V22",),
        draw=convergence,
        options={
            "rates": in_h(
                "rough",
                quantity,
                [N + 1 for N in v22.DEGREES],
                v22.FLOOR,
                lambda n: min(SMOOTHNESS, n) - rate_loss,
                degrees=True,
            ),
            "ylabel": ylabel,
        },
        caption=f"A point between two springs; {SOLID_TEXT.lower()}; dashed, a little above: the "
        "rate "
        "claimed.",
        size=(6.4, 4.4),
    )


VECTOR_SPACES: tuple[Figure, ...] = (
    Figure(
        name="curve-between-same-points",
        source="H thm. 2.3.6",
        title=f"one step of h = {STEP:g} of the Kepler problem, e = 0.6",
        claims=("V14",),
        draw=convergence,
        options={
            "rates": tuple(
                Rate(IN_N, quantity, label, v14.FLOOR[quantity], power=(v14.POWERS[quantity], 0.0))
                for quantity, label in (
                    (ENDS, "end"),
                    (CURVE, "curve, $W^{1,1}$"),
                    (v14.LARGEST, r"curve, $L^\infty$"),
                )
            ),
            "ylabel": "error at the end, distance of the curve",
        },
        caption=f"{SOLID_TEXT}. The curve, in the norms of W^{{1,1}} and L^infinity, against the "
        "exact "
        "motion between the same points: half as many digits as at the end.",
    ),
    Figure(
        name="curve-between-same-points-h",
        source="H thm. 2.3.7",
        title="one step of the Kepler problem, e = 0.6: distance of the curve",
        claims=("V14",),
        draw=convergence,
        options={
            "rates": in_h(IN_H, CURVE, v14.NS, v14.FLOOR[CURVE]),
            "ylabel": "distance in $W^{1,1}$",
        },
        caption=f"{SOLID_TEXT}. Against the exact motion between the same points.",
    ),
    Figure(
        name="discrete-lagrangian",
        source="H thm. 2.3.2",
        title=f"one step of h = {STEP:g} of the Kepler problem, e = 0.6",
        claims=("V26",),
        draw=convergence,
        options={
            "rates": (
                Rate(v26.IN_N, v26.STEPPED, "end of the step", v26.FLOOR),
                Rate(v26.IN_N, v26.ACTION, "$L_d$", v26.FLOOR, power=(v26.POWER, 0.0)),
            ),
            "ylabel": "error",
        },
        caption=f"{SOLID_TEXT}. The discrete Lagrangian at the ends of a step against the action "
        "of the "
        "exact motion between them, and the end of the step itself.",
    ),
    Figure(
        name="discrete-lagrangian-h",
        source="M thm. 4",
        title="one step of the Kepler problem, e = 0.6: discrete Lagrangian",
        claims=("V26",),
        draw=convergence,
        options={
            "rates": in_h(
                "Kepler", v26.ACTION, v26.NS["Kepler"], v26.FLOOR, lambda n: 2.0 * n - 1.0
            ),
            "ylabel": "error of $L_d$",
        },
        caption=f"{SOLID_TEXT}; dashed, a little above: the step's order and one.",
    ),
    Figure(
        name="m-fig-1-left",
        source="M fig. 1 left",
        title=f"Harmonic oscillator, T = {oscillator.DURATION:g}: h-refinement",
        claims=("V17",),
        draw=convergence,
        options={
            "rates": in_h(
                v17.STUDY,
                oscillator.QUANTITY,
                [N + 1 for N in v17.DEGREES],
                oscillator.FLOOR,
                lambda n: 2.0 * (n - 1),
                degrees=True,
            ),
            "ylabel": POSITION_ERROR,
        },
        caption=f"{SOLID_TEXT}; dashed, offset upwards: the rate measured in M.",
        size=(6.4, 4.4),
    ),
    Figure(
        name="m-fig-1-right",
        source="M fig. 1 right",
        title=f"Harmonic oscillator, T = {oscillator.DURATION:g}: N-refinement, N = n - 1",
        claims=("V18",),
        draw=convergence,
        options={
            "rates": tuple(
                Rate(name, oscillator.QUANTITY, f"$h={h:g}$", oscillator.FLOOR)
                for name, h in v18.STUDIES.items()
            ),
            "ylabel": POSITION_ERROR,
        },
        caption=f"{SOLID_TEXT}. The lines bend downwards: the base itself decreases with n.",
    ),
    _approximations(v22.LARGEST, "largest $|u - v|_X$ of the subintervals", 1.0),
    _approximations(v22.MEAN, "mean $|u - v|_X$ of the subintervals", 0.5),
    Figure(
        name="finite-smoothness-in-degree",
        source="M sec. 5",
        title="best polynomials of degree N for u'' = |t - t*|^-b on [0, 1]",
        claims=("V28",),
        draw=convergence,
        options={
            "rates": tuple(
                Rate(
                    v28.named(t, b),
                    v28.BEST,
                    f"$t^*={t:g}$, $b={b:g}$",
                    v28.FLOOR,
                    claimed=2.0,
                    algebraic=True,
                )
                for t, b in SINGULARITIES
            ),
            "ylabel": "$|u - v|_X$",
        },
        caption="Solid line: fit over the filled points; dashed: N^-2, claimed for two derivatives "
        "in L^2. A singularity inside (t* = 1/2) loses up to one power of N, one at an end none.",
        size=(6.4, 4.4),
    ),
    Figure(
        name="finite-smoothness-in-step",
        source="M sec. 5",
        title=f"a step through the singularity of u'' + u = |t - t*|^-{LARGEST_EXPONENT:g}",
        claims=("V28",),
        draw=convergence,
        options={
            "rates": in_h(
                v28.named(v28.PLACE, LARGEST_EXPONENT),
                v28.PATH,
                [N + 1 for N in v28.DEGREES],
                v28.FLOOR,
                lambda n: 1.0 if n == v28.DEGREES[0] + 1 else None,
                degrees=True,
            ),
            "ylabel": "$|u - u_N|_X$ of the step",
        },
        caption="Solid line: fit over the filled points; dashed, a little above: the order of "
        "e_max for two derivatives in L^2, of which M knew no example.",
    ),
)

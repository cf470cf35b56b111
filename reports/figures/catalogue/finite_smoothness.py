"""The figures of V28: motions of finite smoothness, in the degree and in the step."""

from __future__ import annotations

from benchmarks.claims.vector_spaces import v28_rates_at_finite_smoothness as v28
from reports.figures.plots.convergence import Rate, convergence_in_degree, convergence_in_h
from reports.results.section import Figure

SHOWN = ((0.5, 0.49), (0.5, 0.25), (0.0, 0.49), (0.0, 0.25))  # t*, b
ROUGHEST = v28.ROUGH[0]

FINITE_SMOOTHNESS: tuple[Figure, ...] = (
    Figure(
        name="finite-smoothness-in-degree",
        source="M sec. 5",
        title="best polynomials of degree N for u'' = |t - t*|^-b on [0, 1]",
        claims=("V28",),
        draw=convergence_in_degree,
        options={
            "rates": tuple(
                Rate(
                    v28.named(place, b),
                    v28.BEST,
                    f"$t^*={place:g}$, $b={b:g}$",
                    v28.FLOOR,
                    claimed=2.0,
                    algebraic=True,
                )
                for place, b in SHOWN
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
        title=f"a step through the singularity of u'' + u = |t - t*|^-{ROUGHEST:g}",
        claims=("V28",),
        draw=convergence_in_h,
        options={
            "rates": tuple(
                Rate(
                    v28.named(v28.PLACE, ROUGHEST),
                    v28.PATH,
                    f"$N={N}$",
                    v28.FLOOR,
                    claimed=1.0 if v28.DEGREES[0] == N else None,
                    n=N + 1,
                )
                for N in v28.DEGREES
            ),
            "ylabel": "$|u - u_N|_X$ of the step",
        },
        caption="Solid line: fit over the filled points; dashed, a little above: the order of "
        "e_max for two derivatives in L^2, of which M knew no example.",
    ),
)

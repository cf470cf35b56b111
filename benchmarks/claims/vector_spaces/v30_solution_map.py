"""V30: the solution map is Lipschitz continuous, and theorem 3 (M theorems 1 to 3, section 4)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    Array,
    Fault,
    MakeMethod,
    Problem,
    Report,
    always,
    faulty,
    fewer,
    of_motion,
    scaled,
    with_arguments,
)
from benchmarks.claims.vector_spaces.solution_map import (
    Motions,
    bounds,
    differences,
    discrete_sizes,
    exact_sizes,
    nodes,
    opposed,
    oscillations,
    swings,
)
from benchmarks.claims.vector_spaces.theorem_three import COMPARISONS, terms
from benchmarks.measures.independent_space import all_of_degree, friedrichs, grams, z0
from benchmarks.test_problems.oscillators import PENDULUM
from references.closed_forms.pendulum import PENDULUM as EXACT_PENDULUM

MOTIONS: Mapping[str, Motions] = {"oscillator": oscillations, "pendulum": swings}
STEPS = (0.01, 0.05, 0.2, 0.4, 0.49)  # eta = 1 at 0.4967
RULES: Mapping[str, Any] = {
    "Gauss N": lambda degree: galvi.gauss(degree),
    "Gauss N + 1": lambda degree: galvi.gauss(degree + 1),
    "Lobatto N + 1": lambda degree: galvi.lobatto(degree + 1),
    "Lobatto N": lambda degree: galvi.lobatto(degree),
}
DEGREES, THIRD_DEGREES = (1, 2, 4, 8), (1, 2, 3, 4, 6)
SHARES = (0.02, 0.25, 0.5, 0.9)  # step over that at which eta C_N^2 = 1
SIZES = (0.4, 0.2, 0.1, 0.05, 0.025)


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Differences of two solutions over their bounds, exact and for each rule; the constants of
    {1, (1 - t)^k}; and ratios of theorem 3 for each rule and problem."""
    pairs, third = differences(12 if quick else 24), []
    over = {
        name: [over_bounds(h, pairs, exact_sizes(motions, h, pairs)) for h in STEPS]
        for name, motions in MOTIONS.items()
    }
    for name, rule in RULES.items():
        report(name)
        methods = {
            N: make_method(galvi.Polynomials(N), rule(N))
            for N in {*DEGREES, *THIRD_DEGREES}
            if N > 1 or name != "Lobatto N"
        }
        over[name] = [
            ratios for N in DEGREES if N in methods for ratios in in_steps(methods[N], N, pairs)
        ]
        degrees = [N for N in THIRD_DEGREES if N in methods]
        third.append(
            [
                np.max(
                    [
                        *filter(
                            None, (terms(case, methods[N], N, h) for N in degrees for h in SIZES)
                        )
                    ],
                    axis=0,
                )
                for case in COMPARISONS
            ]
        )
    sizes = ("|d|_X", "|dp_h|", "|d|_X + |dp_h|")
    by_rule, by_case = np.max(third, axis=1), np.max(third, axis=0)
    return {
        **of_general_spaces(),
        "apart": distance_of_references(),
        f"{ORACLES}, pendulum": distance_of_references(),
        "least of the largest quotient, times sqrt(h) / cos h": min(map(growth, STEPS)),
        **{
            f"largest of {size} over its bound, {name}": ratio
            for name, ratios in over.items()
            for size, ratio in zip(sizes, np.max(ratios, axis=0), strict=False)
        },
        **{
            f"largest of printed left side over right side, {name}": printed
            for name, (printed, *_) in zip(RULES, by_rule, strict=True)
        },
        **{
            f"largest of left side over right side, {case.name}": proved
            for case, (_, proved, *_) in zip(COMPARISONS, by_case, strict=True)
        },
        "largest of the proof's bound on F, Gauss N": by_rule[0][2],
        **{
            f"largest of |u - u_N|_(0,N) / (h |u - u_N|_X), {name}": ratio
            for name, (*_, ratio) in zip(RULES, by_rule, strict=True)
        },
    }


def over_bounds(
    h: float, pairs: tuple[Array, ...], sizes: tuple[Array, Array], *constant: float
) -> list[float]:
    """The largest ratios of |d|_X, |dp_h| and their sum to their bounds."""
    limits = bounds(h, pairs[2], pairs[3], *constant)
    return [np.max(size / limit) for size, limit in zip((*sizes, sum(sizes)), limits, strict=True)]


def in_steps(method: Any, degree: int, pairs: tuple[Array, ...]) -> list[list[float]]:
    """As `over_bounds` without the sum, for steps of the pendulum of SHARES of the h at which
    eta C_N^2 = 1."""
    constant = friedrichs(grams(all_of_degree(degree), *nodes(method.rule)))
    steps = [share * z0() / math.sqrt(3.0) / constant for share in SHARES]
    return [over_bounds(h, pairs, discrete_sizes(method, h, pairs), constant)[:2] for h in steps]


def growth(h: float) -> float:
    """The largest quotient of the oscillator times sqrt(h) / cos h; the quotient is convex in
    (du, dp), so that du or dp is 0 where it is largest."""
    sizes = exact_sizes(oscillations, h, (np.zeros(2), np.zeros(2), *np.eye(2)))
    return float(np.max(sum(sizes))) * math.sqrt(h) / math.cos(h)


def of_general_spaces() -> dict[str, Any]:
    """Numbers on spaces whose free motions are not straight, for which proposition 1 has another
    constant."""
    inf_sup, farthest, eta, singular = np.array([opposed(k) for k in (3, 6, 11)]).T
    return {
        "least inf-sup constant over m": np.min(inf_sup),
        "departure of inf-sup constant times sqrt(1 + T_N^2) from m, relative": (
            np.max(abs(inf_sup * np.sqrt(1.0 + farthest**2) - 1.0))
        ),
        "eta C_N^2 of that pair": eta[-1],
        "least singular value of the equations (8), over the largest": (
            singular[-1] if eta[-1] < 1.0 else "the theorem does not speak of such a step"
        ),
    }


def distance_of_references() -> float:
    """The largest difference between the pendulum's closed form and DOP853 after the longest step,
    over three starts."""
    starts, h = (np.array([1.0, -2.0, 0.5]), np.array([1.0, 2.0, -1.5])), STEPS[-1]
    exact = EXACT_PENDULUM.run(Problem(PENDULUM.problem().system, *starts), h, {"samples": 1})
    ends = np.squeeze(swings(*starts, np.array([h])))
    return float(np.max(abs(np.array([exact.q[-1], exact.p[-1]]) - ends)))


def faster(u0: Array, v0: Array, t: Array) -> tuple[Array, Array]:
    """As `oscillations`, for u'' = -4 u, for a planted fault."""
    u, v = oscillations(u0, v0 / 2.0, 2.0 * t)
    return u, 2.0 * v


SHORTENED = fewer(__name__, DEGREES=(1, 4), THIRD_DEGREES=(1, 4))
STEEP = galvi.Canonical(1.0, galvi.CosinePotential(4.0))
FAULTS = {
    "C and projection larger by a fiftieth": Fault(
        make=faulty(C=1.02, projection=1.02), wrong=SHORTENED
    ),
    "a curve from elsewhere": of_motion(
        lambda problem: replace(problem, q0=problem.q0 + 1e-3), wrong=SHORTENED
    ),
    "a norm that is too small": Fault(wrong={f"{__name__}.exact_sizes": scaled(0.99), **SHORTENED}),
    "another motion of the pendulum": Fault(
        wrong={
            f"{__name__}.swings": with_arguments(lambda u, v, t: (u, v, (1.0 + 1e-11) * t)),
            **SHORTENED,
        }
    ),
    "a wrong constant of a general space": Fault(
        wrong={f"{opposed.__module__}.farthest": scaled(1.0 + 1e-9), **SHORTENED}
    ),
    "dp counts for a third": Fault(
        wrong={
            f"{__name__}.bounds": with_arguments(
                lambda h, du, dp, *constant: (h, du, dp / 3.0, *constant)
            ),
            **SHORTENED,
        }
    ),
    "half of the pull of d on dp_h": Fault(
        wrong={f"{bounds.__module__}.pull": scaled(0.5), **SHORTENED}
    ),
    "a force steeper than its constant": of_motion(
        lambda problem: replace(problem, system=STEEP),
        wrong={
            f"{__name__}.MOTIONS": always({"oscillator": faster, "pendulum": swings}),
            **SHORTENED,
        },
    ),
}

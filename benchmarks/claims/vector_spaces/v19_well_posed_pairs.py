"""V19: well posed iff the free particle has a unique motion (M lemma 1); consistent pairs."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, DataFrame, Fault, MakeMethod, Report
from benchmarks.measures.independent_space import (
    Functions,
    broken_powers,
    gauss_points,
    lobatto_points,
    powers,
    table,
    waves,
)
from galvi.tableau import IllPosed

STRAIGHT = 1e-13  # largest departure of a straight motion; 2e-14 and 3e-11 were the nearest values
SINGULAR = 1e9  # smallest condition number of a singular matrix; 1e7 and 1e16 were the nearest


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Counts of pairs in which the two sides of the lemma, or galvi's decisions, differ from what
    they should be; and the free motions of two pairs that are no methods."""
    pairs = DataFrame(
        {
            "name": f"{name}, {rule.name}",
            **by_hand(functions, *points),
            **by_galvi(make_method, space, rule),
        }
        for name, (space, functions, pieces) in spaces().items()
        for rule, points in rules(pieces)
    ).set_index("name")
    unique, straight = pairs["unique"], pairs["off"] <= STRAIGHT
    otherwise = (pairs["well posed"] != unique) | (pairs["consistent"] != straight)
    still, bent = "{1, Fourier 2}, Gauss 16", "{1, t, Fourier 2}, Gauss 5"
    return {
        "pairs in which the two sides of the lemma differ": sum(pairs["norm"] != unique),
        "pairs refused as ill-posed without being so, or not refused": sum(
            pairs["ill-posed"] == unique
        ),
        "pairs accepted with a bent free motion, or refused with a straight one": sum(
            pairs["accepted"] != straight
        ),
        "pairs of each refused kind, the fewer": min(sum(~unique), sum(unique & ~straight)),
        "largest |alpha - c|, |beta_p - 1| in the tables of accepted pairs": pairs["defect"].max(),
        "pairs that galvi.theory judges otherwise": sum(otherwise),
        f"how far a free particle comes in a step, over h v0, {still}": pairs["end"][still],
        f"how far a free particle is off a straight line, over h v0, {bent}": pairs["off"][bent],
    }


def spaces() -> dict[str, tuple[Any, Functions, int]]:
    """Name -> (galvi's space, the same functions in numpy, number of pieces)."""
    constant = powers(0)
    return {
        **{f"P{s}": (galvi.Polynomials(s), powers(s), 1) for s in (1, 2, 3, 4, 6)},
        "{1, Fourier 1}": (galvi.Fourier(1), constant + waves(1), 1),
        "{1, Fourier 2}": (galvi.Fourier(2), constant + waves(2), 1),
        "{1, Fourier 1}, w = 2": (galvi.Fourier(1, 2.0), constant + waves(1, 2.0), 1),
        "{1, t, Fourier 1}": (galvi.PolynomialFourier(1, 1), powers(1) + waves(1), 1),
        "{1, t, Fourier 2}": (galvi.PolynomialFourier(1, 2), powers(1) + waves(2), 1),
        "piecewise P1, 2": (galvi.PiecewisePolynomials(1, 2), broken_powers(1, 2, 0), 2),
        "piecewise P2, 2": (galvi.PiecewisePolynomials(2, 2), broken_powers(2, 2, 0), 2),
        "Hermite, 2": (galvi.PiecewiseHermite(2), broken_powers(3, 2, 1), 2),
    }


def rules(pieces: int) -> Iterator[tuple[galvi.Rule, tuple[Array, Array]]]:
    """(galvi's rule, its (nodes, weights) by numpy) for each rule."""
    for n in (1, 2, 3, 4, 5, 6, 8, 16):
        yield galvi.gauss(n), gauss_points(n)
    for n in (2, 3, 4, 5, 6, 7):
        yield galvi.lobatto(n), lobatto_points(n)
    for n in (1, 2, 3) if pieces > 1 else ():
        t, b = gauss_points(n)
        nodes = ((np.arange(pieces)[:, None] + t) / pieces).ravel()
        yield galvi.composite(galvi.gauss(n), pieces), (nodes, np.tile(b / pieces, pieces))


def by_hand(functions: Functions, t: Array, b: Array) -> dict[str, float]:
    """Results of M's problem (9) on [0, 1] for m = 1, u(0) = 0 and p = 1, in functions of norm 1.

    Whether the seminorm is a norm, whether the motion is unique, its end, and its largest departure
    from a straight line; NaN for the last two without a unique motion.
    """
    u, du = table(functions, gauss_points(60)[0])
    size = np.sqrt(np.mean(u**2, axis=0) + np.mean(du**2, axis=0))
    at_nodes, slope = (values / size for values in table(functions, t))
    ends = table(functions, np.array([0.0, 1.0]))[0] / size
    stiff = slope.T @ (b[:, None] * slope)
    saddle = np.block([[stiff, -ends[1:].T], [ends[:1], np.zeros((1, 1))]])
    norm, unique = (
        np.linalg.cond(matrix) < SINGULAR for matrix in (stiff + np.outer(ends[1], ends[1]), saddle)
    )
    end = departure = math.nan
    if unique:
        motion = np.linalg.solve(saddle, np.append(-ends[0], 0.0))[:-1]
        end = ends[1] @ motion
        departure = max(np.max(abs(at_nodes @ motion - t)), abs(end - 1.0))
    return {"norm": norm, "unique": unique, "end": end, "off": departure}


def by_galvi(make_method: MakeMethod, space: Any, rule: galvi.Rule) -> dict[str, Any]:
    """galvi's decisions on a pair, and the departure of its tableau from a straight motion."""
    theory = galvi.theory(space, rule)
    decided = {"well posed": theory.well_posed, "consistent": theory.consistent}
    try:
        tableau = make_method(space, rule).table
    except ValueError as refusal:
        return decided | {"accepted": False, "ill-posed": isinstance(refusal, IllPosed)}
    stages = np.max(abs(tableau.psi @ tableau.velocity_coefficients - tableau.c))
    defect = max(stages, abs(tableau.end @ tableau.velocity_coefficients - 1.0))
    return decided | {"accepted": True, "ill-posed": False, "defect": defect}


def taking_bent_motions(space: Any, rule: galvi.Rule) -> galvi.Galerkin:
    """A faulty constructor that accepts inconsistent pairs."""
    try:
        return galvi.Galerkin(space, rule)
    except IllPosed:
        raise
    except ValueError:
        return galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(2))


def too_strict(space: Any, rule: galvi.Rule) -> galvi.Galerkin:
    """A faulty constructor that refuses pairs with fewer points than functions: H's condition is
    sufficient, but not necessary."""
    if rule.points < space.dimension:
        raise IllPosed(f"{space} with {rule.name}")
    return galvi.Galerkin(space, rule)


def consistent(original: Callable[..., Any]) -> Callable[..., Any]:
    """A faulty `galvi.theory` that calls every pair consistent."""
    return lambda *pair: replace(original(*pair), consistent=True)


FAULTS = {
    "inconsistent pairs taken": Fault(make=taking_bent_motions),
    "fewer points than functions refused": Fault(make=too_strict),
    "a theory that takes every pair for consistent": Fault(wrong={"galvi.theory": consistent}),
}

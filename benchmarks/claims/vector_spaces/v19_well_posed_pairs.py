"""V19: well posed iff the free particle has a unique motion (M lemma 1); consistent pairs."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks.bounds import Above, AtLeast, AtMost, Bound, Exactly, Finding
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.measures.independent_functions import Functions, broken_powers, powers, table, waves
from benchmarks.measures.independent_space import gauss_points, lobatto_points
from benchmarks.statistics import readings
from benchmarks.store.frames import frame, rows
from galvi.arrays import Array

NORM, SOLVABLE = "|.|_{X,N} is a norm", "free particle has a unique motion"
DEFECT, END = "free particle off the straight line", "displacement over a step h v0"
ACCEPTED, AS_ILL_POSED = "accepted", "refused as ill-posed"
TABLE_DEFECT, SAID = "defect of the table", "galvi.theory agrees"
STRAIGHT = 1e-13  # of a step; 2e-14 and 3e-11 were the nearest measured by numpy
CLEAR = 1e-9  # least singular value over the largest; 1e-16 and 8e-8 were the nearest measured
KINDS = (
    "polynomials, Fourier, both, piecewise and Hermite, with Gauss, Lobatto and repeated Gauss "
    "rules"
)
PERIODIC, MIXED = "{1, Fourier 2}, Gauss 16", "{1, t, Fourier 2}, Gauss 5"


def spaces() -> Mapping[str, tuple[Any, Functions, int]]:
    """Name -> (galvi's space, the same functions in numpy, pieces)."""
    one = powers(0)
    return {
        **{f"P{s}": (galvi.Polynomials(s), powers(s), 1) for s in (1, 2, 3, 4, 6)},
        "{1, Fourier 1}": (galvi.Fourier(1), one + waves(1), 1),
        "{1, Fourier 2}": (galvi.Fourier(2), one + waves(2), 1),
        "{1, Fourier 1}, w = 2": (galvi.Fourier(1, 2.0), one + waves(1, 2.0), 1),
        "{1, t, Fourier 1}": (galvi.PolynomialFourier(1, 1), powers(1) + waves(1), 1),
        "{1, t, Fourier 2}": (galvi.PolynomialFourier(1, 2), powers(1) + waves(2), 1),
        "piecewise P1, 2": (galvi.PiecewisePolynomials(1, 2), broken_powers(1, 2, 0), 2),
        "piecewise P2, 2": (galvi.PiecewisePolynomials(2, 2), broken_powers(2, 2, 0), 2),
        "Hermite, 2": (galvi.PiecewiseHermite(2), broken_powers(3, 2, 1), 2),
    }


def rules(pieces: int) -> Mapping[str, tuple[galvi.Rule, tuple[Array, Array]]]:
    """Name -> (galvi's rule, nodes and weights by numpy)."""
    found = {f"Gauss {n}": (galvi.gauss(n), gauss_points(n)) for n in (1, 2, 3, 4, 5, 6, 8, 16)}
    for n in (2, 3, 4, 5, 6, 7):
        found[f"Lobatto {n}"] = galvi.lobatto(n), lobatto_points(n)
    if pieces > 1:
        for n in (1, 2, 3):
            repeated = galvi.composite(galvi.gauss(n), pieces)
            found[repeated.name] = repeated, _repeated(gauss_points(n), pieces)
    return found


def _repeated(points: tuple[Array, Array], pieces: int) -> tuple[Array, Array]:
    t, b = points
    return (
        ((np.arange(pieces)[:, None] + t) / pieces).ravel(),
        np.tile(b / pieces, pieces),
    )


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """For each pair, one row per quantity, with the pair's name in ``label``."""
    observed = []
    for name, (space, functions, pieces) in spaces().items():
        report(name)
        for rule_name, (rule, points) in rules(pieces).items():
            found = {**_by_hand(functions, *points), **_by_galvi(make_method, space, rule)}
            found[SAID] = _agrees(space, rule, found)
            observed += rows(found, study="pairs", label=f"{name}, {rule_name}")
    return frame(observed)


def _by_hand(functions: Functions, t: Array, b: Array) -> dict[str, float]:
    """M's problem (9) on [0, 1], m = 1, from u = 0 with p = 1, in functions of norm 1."""
    fine_u, fine_du = table(functions, *[gauss_points(60)[0]])
    size = np.sqrt(np.mean(fine_u**2, axis=0) + np.mean(fine_du**2, axis=0))
    place, slope = (part / size for part in table(functions, t))
    ends = table(functions, np.array([0.0, 1.0]))[0] / size
    stiff = slope.T @ (b[:, None] * slope)
    saddle = np.block([[stiff, -ends[1:].T], [ends[:1], np.zeros((1, 1))]])
    norm = stiff + np.outer(ends[1], ends[1])
    seen = _gap(norm), _gap(saddle)
    found = {NORM: float(seen[0] > CLEAR), SOLVABLE: float(seen[1] > CLEAR)}
    found[DEFECT] = found[END] = float("nan")
    if found[SOLVABLE]:
        motion = np.linalg.solve(saddle, np.append(-ends[0], 0.0))[:-1]
        found[END] = float(ends[1] @ motion)
        found[DEFECT] = float(max(np.max(abs(place @ motion - t)), abs(found[END] - 1.0)))
    return found


def _gap(matrix: Array) -> float:
    found = np.linalg.svd(matrix, compute_uv=False)
    return float(found[-1] / found[0])


def _by_galvi(make_method: MakeMethod, space: Any, rule: Any) -> dict[str, float]:
    try:
        method = make_method(space, rule)
    except ValueError as refusal:
        ill_posed = float("is ill-posed" in str(refusal))
        return {ACCEPTED: 0.0, AS_ILL_POSED: ill_posed, TABLE_DEFECT: float("nan")}
    known = method.table
    stages = np.max(abs(known.psi @ known.velocity_coefficients - known.c))
    defect = float(max(stages, abs(known.end @ known.velocity_coefficients - 1.0)))
    return {ACCEPTED: 1.0, AS_ILL_POSED: 0.0, TABLE_DEFECT: defect}


def _agrees(space: Any, rule: Any, found: Mapping[str, float]) -> float:
    said = galvi.theory(space, rule)
    straight = bool(found[DEFECT] <= STRAIGHT)
    return float(said.well_posed == bool(found[SOLVABLE]) and said.consistent == straight)


def judge(found: pd.DataFrame) -> list[Row]:
    """Rows for both sides of the lemma, for galvi's decisions, and two well-posed non-methods."""
    wide = found.pivot(index="label", columns="quantity", values="value") if len(found) else found
    count = len(wide)
    lemma = ill = bent = both = said = worst = float("nan")
    if count:
        straight = wide[DEFECT] <= STRAIGHT
        lemma = float((wide[NORM] != wide[SOLVABLE]).sum())
        ill = float(((wide[AS_ILL_POSED] > 0) != (wide[SOLVABLE] == 0)).sum())
        bent = float(((wide[ACCEPTED] > 0) != straight).sum())
        both = float(min((wide[SOLVABLE] == 0).sum(), (~straight & (wide[SOLVABLE] > 0)).sum()))
        said = float((wide[SAID] == 0).sum())
        worst = readings.largest(wide[TABLE_DEFECT].dropna().to_numpy())
    setup = f"{count} pairs; {KINDS}"
    return [
        V19.row(
            "pairs in which the two sides of the lemma differ",
            Exactly(0),
            lemma,
            source="M lemma 1",
            setup=setup,
            claimed="unique solution iff a norm",
            reason="Necessary and sufficient.",
        ),
        V19.row(
            "pairs refused as ill-posed without being so, or not refused",
            Exactly(0),
            ill,
            source="M lemma 1",
            setup=setup,
            claimed="well posed iff the free particle has a unique motion",
            reason="galvi eliminates in 60 digits, or 16 for spaces in floats.",
        ),
        V19.row(
            "pairs accepted with a bent free motion, or refused with a straight one",
            Finding(Exactly(0)),
            bent,
            setup=setup,
            claimed="consistent iff alpha = c, beta_p = 1 to 1e-13",
            reason="A method of any order moves a free particle in a straight line.",
        ),
        V19.row(
            "pairs of each refused kind, the fewer",
            Finding(AtLeast(5)),
            both,
            setup=setup,
            claimed="neither criterion is empty",
            reason="Rules with few points; Fourier spaces, and rules that are not exact for them.",
        ),
        V19.row(
            "largest |alpha - c|, |beta_p - 1| in the tables of accepted pairs",
            Finding(AtMost(STRAIGHT)),
            worst,
            setup=setup,
            claimed="straight to 1e-13",
            reason="Rounded once.",
        ),
        V19.row(
            "pairs that galvi.theory judges otherwise",
            Finding(Exactly(0)),
            said,
            source="M lemma 1, ours",
            setup=setup,
            claimed="well posed, consistent",
            reason="The same elimination.",
        ),
        _unique_but_wrong(
            wide,
            PERIODIC,
            END,
            AtMost(STRAIGHT),
            "how far a free particle comes in a step, over h v0",
            "The motion is unique, as lemma 1 says, but beta_p = 0: what has the step as its "
            "period is where it was, and q never moves. A method of any order comes to 1.",
        ),
        _unique_but_wrong(
            wide,
            MIXED,
            DEFECT,
            Above(STRAIGHT),
            "how far a free particle is off a straight line, over h v0",
            "The motion is unique, as lemma 1 says, but bent: Gauss 5 does not integrate "
            "the cosines exactly. The error is a part of every step, however short: order 0.",
        ),
    ]


def _unique_but_wrong(
    wide: pd.DataFrame, pair: str, measured: str, bound: Bound, quantity: str, reason: str
) -> Row:
    """The row of a pair that is well posed but inconsistent."""
    known = len(wide) and pair in wide.index and wide.loc[pair, SOLVABLE] == 1.0
    return V19.row(
        f"{quantity}, {pair}",
        Finding(bound),
        float(wide.loc[pair, measured]) if known else float("nan"),
        source="M lemma 1, section 5",
        setup=f"{pair}; {KINDS}",
        claimed="well-posed if and only if it is able to solve the free particle equations: true "
        "of a unique motion, and no more is claimed",
        reason=reason,
    )


V19 = Claim(
    "V19",
    "Well posed iff a free particle has a unique motion",
    study,
    judge,
    source="ours",
    reference="M's problem (9) in monomials, sines and cosines, by numpy",
    statement="M lemma 1: a step is well posed if and only if the equations of a free particle "
    "have a unique solution. Ours: the method is consistent if and only if this solution is a "
    "straight line.",
)

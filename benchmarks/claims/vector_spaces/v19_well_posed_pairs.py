"""V19: well posed iff the free particle has a unique motion (M lemma 1), and what that leaves."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.measures.independent_functions import Functions, broken_powers, powers, table, waves
from benchmarks.measures.independent_space import gauss_points, lobatto_points
from benchmarks.store.frames import frame, row
from galvi.arrays import Array

NORM, SOLVABLE = "|.|_{X,N} is a norm", "free particle has a unique motion"
DEFECT, END = "free particle off the straight line", "displacement over a step h v0"
ACCEPTED, AS_ILL_POSED = "accepted", "refused as ill-posed"
TABLE_DEFECT, SAID = "defect of the table", "galvi.theory agrees"
STRAIGHT = 1e-13  # of a step; 2e-14 and 3e-11 were the nearest measured by numpy
CLEAR = 1e-9  # least singular value over the largest; 1e-16 and 8e-8 were the nearest measured
PERIODIC, MIXED = "{1, Fourier 2}, Gauss 16", "{1, t, Fourier 2}, Gauss 5"


def spaces() -> Mapping[str, tuple[Any, Functions, int]]:
    """Name: galvi's space, the same functions by hand, pieces."""
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
    """Name: galvi's rule, and nodes and weights by numpy."""
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
    """For each pair, one row a quantity, its name in ``label``."""
    rows = []
    for name, (space, functions, pieces) in spaces().items():
        report(name)
        for rule_name, (rule, points) in rules(pieces).items():
            found = {**_by_hand(functions, *points), **_by_galvi(make_method, space, rule)}
            found[SAID] = _agrees(space, rule, found)
            pair = f"{name}, {rule_name}"
            rows += [row(study="pairs", label=pair, quantity=quantity, value=value)
                     for quantity, value in found.items()]  # fmt: skip
    return frame(rows)


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
        return {ACCEPTED: 0.0, AS_ILL_POSED: float("is ill-posed" in str(refusal)),
                TABLE_DEFECT: float("nan")}  # fmt: skip
    known = method.table
    lead = known.velocity_coefficients
    stages = np.max(abs(known.psi @ lead - known.c))
    return {ACCEPTED: 1.0, AS_ILL_POSED: 0.0,
            TABLE_DEFECT: float(max(stages, abs(known.end @ lead - 1.0)))}  # fmt: skip


def _agrees(space: Any, rule: Any, found: Mapping[str, float]) -> float:
    said = galvi.theory(space, rule)
    straight = bool(found[DEFECT] <= STRAIGHT)
    return float(said.well_posed == bool(found[SOLVABLE]) and said.consistent == straight)


def judge(found: pd.DataFrame) -> list[Row]:
    """Both sides of the lemma, what galvi makes of the pairs, and two that are not enough."""
    wide = found.pivot(index="label", columns="quantity", values="value") if len(found) else found
    count = len(wide)
    if count:
        straight = wide[DEFECT] <= STRAIGHT
        lemma = float((wide[NORM] != wide[SOLVABLE]).sum())
        ill = float(((wide[AS_ILL_POSED] > 0) != (wide[SOLVABLE] == 0)).sum())
        bent = float(((wide[ACCEPTED] > 0) != straight).sum())
        both = float(min((wide[SOLVABLE] == 0).sum(), (~straight & (wide[SOLVABLE] > 0)).sum()))
        said = float((wide[SAID] == 0).sum())
        defects = wide[TABLE_DEFECT].dropna()
        worst = float(defects.max()) if len(defects) else float("nan")
    else:
        lemma = ill = bent = both = said = worst = float("nan")
    pairs = f"{count} pairs"
    return [
        _row("pairs in which the two sides of the lemma differ", pairs, "M lemma 1",
             "unique solution iff a norm", "0", lemma, bounds.HOLDS,
             "Necessary and sufficient.", bounds.bound(lemma, 0.0)),
        _row("pairs refused as ill-posed without being so, or not refused", pairs, "M lemma 1",
             "well posed iff the free particle has a unique motion", "0", ill, bounds.HOLDS,
             "galvi eliminates in 60 digits, or 16 for spaces in floats.",
             bounds.bound(ill, 0.0)),
        _row("pairs accepted with a bent free motion, or refused with a straight one", pairs,
             "ours", "consistent iff alpha = c, beta_p = 1 to 1e-13", "0", bent, bounds.HOLDS,
             "A method of any order moves a free particle in a straight line.",
             bounds.bound(bent, 0.0)),
        _row("pairs of each refused kind, the fewer", pairs, "ours",
             "neither criterion is empty", "at least 5", both, bounds.HOLDS,
             "Rules with few points; Fourier spaces, and rules that are not exact for them.",
             bounds.within(both, 5.0, np.inf)),
        _row("largest |alpha - c|, |beta_p - 1| in the tables of accepted pairs", pairs, "ours",
             "straight to 1e-13", f"at most {STRAIGHT:g}", worst, bounds.HOLDS,
             "Rounded once.", bounds.bound(worst, STRAIGHT)),
        _row("pairs that galvi.theory judges otherwise", pairs, "M lemma 1, ours",
             "well posed, consistent", "0", said, bounds.HOLDS, "The same elimination.",
             bounds.bound(said, 0.0)),
        _two(wide, PERIODIC, END, "how far a free particle comes in a step, over h v0",
             "1 -+ 1e-13 for a method of any order",
             "M's words for lemma 1, which holds: the motion is unique. But it is no solution: "
             "beta_p = 0, what has the step as its period is where it was, and q never moves.",
             lambda value: abs(value - 1.0) <= STRAIGHT),
        _two(wide, MIXED, DEFECT, "how far a free particle is off a straight line, over h v0",
             "at most 1e-13 for a method of any order",
             "The motion is unique, but bent: Gauss 5 does not integrate cos 4 pi t. The error is "
             "a part of every step, however short: order 0.", lambda value: value <= STRAIGHT),
    ]  # fmt: skip


def _two(
    wide: pd.DataFrame, pair: str, quantity: str, words: str, bound: str, reason: str, enough: Any,
) -> Row:  # fmt: skip
    known = len(wide) and pair in wide.index and wide.loc[pair, SOLVABLE] == 1.0
    measured = float(wide.loc[pair, quantity]) if known else float("nan")
    verdict = bounds.NOT_RUN
    if np.isfinite(measured):
        verdict = bounds.HOLDS if enough(measured) else bounds.CONTRADICTED
    return _row(
        f"{words}, {pair}", pair, "M lemma 1, section 5",
        "well-posed if and only if it is able to solve the free particle equations", bound,
        measured, bounds.CONTRADICTED, reason, verdict,
    )  # fmt: skip


def _row(
    quantity: str, setup: str, source: str, claimed: str, bound: str, measured: float,
    expected: str, reason: str, verdict: str,
) -> Row:  # fmt: skip
    return Row(
        id="V19",
        quantity=quantity,
        source=source,
        setup=f"{setup}; polynomials, Fourier, both, piecewise and Hermite, with Gauss, Lobatto "
        "and repeated Gauss rules",
        claimed=claimed,
        bound=bound,
        measured=measured,
        uncertainty=None,
        expected=expected,
        reason=reason,
        reference="M's problem (9) in monomials, sines and cosines, by numpy",
        verdict=verdict,
    )


V19 = Claim("V19", "Well posed iff a free particle has a unique motion", study, judge)

"""V19: well posed iff the free particle has a unique motion (M lemma 1); consistent pairs."""

from __future__ import annotations

from benchmarks.claims.kit import *
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
LEMMA = "pairs in which the two sides of the lemma differ"
ILL_POSED = "pairs refused as ill-posed without being so, or not refused"
BENT = "pairs accepted with a bent free motion, or refused with a straight one"
FEWER = "pairs of each refused kind, the fewer"
TABLES = "largest |alpha - c|, |beta_p - 1| in the tables of accepted pairs"
OTHERWISE = "pairs that galvi.theory judges otherwise"
FAR = "how far a free particle comes in a step, over h v0"
OFF = "how far a free particle is off a straight line, over h v0"
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


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Both sides of the lemma and galvi's decisions over all pairs, and two that are no methods."""
    pairs: dict[str, dict[str, float]] = {}
    for name, (space, functions, pieces) in spaces().items():
        report(name)
        for rule_name, (rule, points) in rules(pieces).items():
            found = {**_by_hand(functions, *points), **_by_galvi(make_method, space, rule)}
            found[SAID] = _agrees(space, rule, found)
            pairs[f"{name}, {rule_name}"] = found
    wide = DataFrame.from_dict(pairs, orient="index")
    straight, unsolved = wide[DEFECT] <= STRAIGHT, wide[SOLVABLE] == 0
    return {
        LEMMA: (wide[NORM] != wide[SOLVABLE]).sum(),
        ILL_POSED: ((wide[AS_ILL_POSED] > 0) != unsolved).sum(),
        BENT: ((wide[ACCEPTED] > 0) != straight).sum(),
        FEWER: min(unsolved.sum(), (~straight & ~unsolved).sum()),
        TABLES: readings.largest(wide[TABLE_DEFECT].dropna().to_numpy()),
        OTHERWISE: (wide[SAID] == 0).sum(),
        **{
            f"{quantity}, {pair}": wide.loc[pair, part] if wide.loc[pair, SOLVABLE] else math.nan
            for pair, part, quantity in ((PERIODIC, END, FAR), (MIXED, DEFECT, OFF))
        },
    }


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
        ill_posed = float(isinstance(refusal, IllPosed))
        return {ACCEPTED: 0.0, AS_ILL_POSED: ill_posed, TABLE_DEFECT: float("nan")}
    known = method.table
    stages = np.max(abs(known.psi @ known.velocity_coefficients - known.c))
    defect = float(max(stages, abs(known.end @ known.velocity_coefficients - 1.0)))
    return {ACCEPTED: 1.0, AS_ILL_POSED: 0.0, TABLE_DEFECT: defect}


def _agrees(space: Any, rule: Any, found: Mapping[str, float]) -> float:
    said = galvi.theory(space, rule)
    straight = bool(found[DEFECT] <= STRAIGHT)
    return float(said.well_posed == bool(found[SOLVABLE]) and said.consistent == straight)


NOT_METHODS = {
    "source": "M lemma 1, section 5",
    "claimed": "well-posed if and only if it is able to solve the free particle equations: true "
    "of a unique motion, and no more is claimed",
}
CHECKS = (
    check(
        LEMMA,
        Exactly(0),
        source="M lemma 1",
        claimed="unique solution iff a norm",
        reason="Necessary and sufficient.",
    ),
    check(
        ILL_POSED,
        Exactly(0),
        source="M lemma 1",
        claimed="well posed iff the free particle has a unique motion",
        reason="galvi eliminates in 60 digits, or 16 for spaces in floats.",
    ),
    check(
        BENT,
        Finding(Exactly(0)),
        claimed="consistent iff alpha = c, beta_p = 1 to 1e-13",
        reason="A method of any order moves a free particle in a straight line.",
    ),
    check(
        FEWER,
        Finding(AtLeast(5)),
        claimed="neither criterion is empty",
        reason="Rules with few points; Fourier spaces, and rules that are not exact for them.",
    ),
    check(
        TABLES,
        Finding(AtMost(STRAIGHT)),
        claimed="straight to 1e-13",
        reason="Rounded once.",
    ),
    check(
        OTHERWISE,
        Finding(Exactly(0)),
        source="M lemma 1, ours",
        claimed="well posed, consistent",
        reason="The same elimination.",
    ),
    check(
        f"{FAR}, {PERIODIC}",
        Finding(AtMost(STRAIGHT)),
        setup=f"{PERIODIC}; {KINDS}",
        reason="The motion is unique, as lemma 1 says, but beta_p = 0: what has the step as its "
        "period is where it was, and q never moves. A method of any order comes to 1.",
        **NOT_METHODS,
    ),
    check(
        f"{OFF}, {MIXED}",
        Finding(Above(STRAIGHT)),
        setup=f"{MIXED}; {KINDS}",
        reason="The motion is unique, as lemma 1 says, but bent: Gauss 5 does not integrate "
        "the cosines exactly. The error is a part of every step, however short: order 0.",
        **NOT_METHODS,
    ),
)


def _unchecked(space: Any, rule: Any) -> Any:
    """Takes an inconsistent pair for a method."""
    try:
        return galvi.Galerkin(space, rule)
    except IllPosed:
        raise
    except ValueError:
        return galvi.Galerkin(galvi.Polynomials(1), galvi.gauss(2))


def _too_strict(space: Any, rule: Any) -> Any:
    """Refuses what has fewer points than functions: sufficient, as in H, and not necessary."""
    if rule.points < space.dimension:
        raise IllPosed(f"{space} with {rule.name}")
    return galvi.Galerkin(space, rule)


V19 = scalars(
    "V19",
    "Well posed iff a free particle has a unique motion",
    measure,
    CHECKS,
    source="ours",
    setup=f"{sum(len(rules(pieces)) for *_, pieces in spaces().values())} pairs; {KINDS}",
    reference="M's problem (9) in monomials, sines and cosines, by numpy",
    statement="M lemma 1: a step is well posed if and only if the equations of a free particle "
    "have a unique solution. Ours: the method is consistent if and only if this solution is a "
    "straight line.",
    caught=(
        of_table(TABLES, velocity_coefficients=1.0 + 1e-12),
        Fault("inconsistent pairs taken", {BENT}, _unchecked),
        Fault("fewer points than functions refused", {ILL_POSED}, _too_strict),
        Fault(
            "a theory that takes every pair for consistent",
            {OTHERWISE},
            wrong={
                "galvi.theory": lambda sound: lambda *pair: replace(sound(*pair), consistent=True)
            },
        ),
    ),
)

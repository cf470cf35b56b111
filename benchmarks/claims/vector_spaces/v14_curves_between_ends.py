"""V14: Galerkin curves against exact motions with the same end points (H thms. 2.3.6, 2.3.7)."""

from __future__ import annotations

from benchmarks.checks.series_bounds import FactorPerN
from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.kepler_orbit import (
    METHOD,
    ORBIT,
    convergence_of_polynomials,
    oracles,
    problem,
    truths,
)
from benchmarks.measures.boundary_motion import CURVE, ENDS, IN_H, IN_N, BoundaryValueMotion
from references.closed_forms.kepler import KEPLER
from references.closed_forms.oscillator import OSCILLATOR

LARGEST = "distance of the curve in L^infinity"
STEP, GAIN = 2.0, 0.4  # each n multiplies the error by 0.33 to 0.35
RESOLUTION = 0.005  # of a base, as for those that H prints
NS = (3, 4, 5, 6)
FLOOR = {ENDS: 5e-15, CURVE: 3e-14, LARGEST: 3e-14}

# q has a branch point (t - t*)^(1/2) at -1 + 0.2986 i of the step [-1, 1], so that the Legendre
# coefficients of q' are of size n^0 r^-n (Darboux). The curve leaves out those from P_(n - 1) on:
# its velocity errs by n^(-1/2) r^-n in the mean, the curve by the integral of P_(n - 1), n^(-3/2)
# r^-n, and the end of the step by n^0 r^-2n, see V3.
POWERS = {ENDS: 0.0, CURVE: 0.5, LARGEST: 1.5}
ROOT = convergence_of_polynomials(0.0, STEP)  # 1/r = 0.5717
PLACE = (
    "The orbit's nearest branch point (t - t*)^(1/2) lies at -1 + 0.2986 i of the step [-1, 1]: "
    f"Bernstein's ellipse gives sqrt(K) = {ROOT:.4f}, K = {ROOT**2:.4f}"
)
SETUP = (
    f"{ORBIT}; {METHOD}; one step%s; the exact motion between the same points by shooting; "
    "W^{1,1}: integral of |q - q_exact| + |q' - q'_exact| over the step; L^infinity: largest "
    "|q - q_exact|"
)
IN_STEPS = " of h = 2^(-j/2), j = 0, 1, ... (3 to 12 in the quick form)"

# H's theorem 2.3.8, on the oscillator: C_f = min(m / 4h, (m pi^2 / 2h^2 - k) / 2h), m / 4h for h
# below pi / sqrt(3) = 1.81.
COERCIVE, STARTS = "oscillator, h-refinement, one step", 8
COERCIVE_STEPS = tuple(2.0 ** (-j / 4) for j in range(-3, 25))
COERCIVE_SETUP = (
    f"harmonic oscillator, m = k = 1; {METHOD}, exact for it, n = {NS[0]} to {NS[-1]}; one step of "
    "h = 2^(-j/4), j = -3, -2, ...; error of a step in (q, p), distance from the exact motion "
    f"between the same points in W^{{1,1}}, each the largest over {STARTS} starts round half the "
    "orbit; C_f = m / (4 h)"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """The three quantities for one step, against n at h = 2 and against h for n = 3 to 6; the
    first two against h on the oscillator, the largest over starts."""
    ns = range(6, 31, 4) if quick else range(5, 34)
    report(IN_N)
    found = _steps(IN_N, make_method, ns, STEP)
    for j in range(3, 13) if quick else range(15):
        h = 2.0 ** (-j / 2)
        report(f"{IN_H}, h = {h:.4g}")
        found += _steps(IN_H, make_method, NS, h)
    report(COERCIVE)
    found += _oscillator_steps(make_method)
    return frame([*found, *oracles("oracles", STEP, 1)])


def _steps(
    study: str, make_method: MakeMethod, ns: Iterable[int], h: float
) -> list[dict[str, Any]]:
    exact = BoundaryValueMotion(problem(), h, KEPLER)
    found = []
    for n in ns:
        run = galvi.integrate(problem(), method_of(make_method, n), h, 1)
        values = [float("nan")] * 3
        if run.success:
            values = [exact.error(run), *exact.distances(run)]
        named = dict(zip((ENDS, CURVE, LARGEST), values, strict=True))
        found += rows(named, study=study, n=n, step=h, steps=1, status=failure(run))
    return found


def _oscillator_steps(make_method: MakeMethod) -> list[dict[str, Any]]:
    spring = galvi.problems.harmonic_oscillator()
    angles = np.pi * np.arange(STARTS) / STARTS
    starts = [spring.with_initial_state([np.cos(a)], [-np.sin(a)]) for a in angles]
    found = []
    for h in COERCIVE_STEPS:
        motions = [BoundaryValueMotion(start, h, OSCILLATOR) for start in starts]
        ends = [OSCILLATOR.run(start, h, {"samples": 1}) for start in starts]
        for n in NS:
            method = method_of(make_method, n)
            runs = [galvi.integrate(start, method, h, 1) for start in starts]
            missed = [
                np.abs([run.q[-1] - end.q[-1], run.p[-1] - end.p[-1]])
                for run, end in zip(runs, ends, strict=True)
            ]
            apart = [to.distances(run)[0] for to, run in zip(motions, runs, strict=True)]
            named = {ENDS: float(np.max(missed)), CURVE: float(np.max(apart))}
            failed = next((run for run in runs if not run.success), runs[0])
            found += rows(named, study=COERCIVE, n=n, step=h, steps=1, status=failure(failed))
    return found


def judge(table: DataFrame) -> list[Row]:
    """The bases of steps and curve against the theory's; the curve's order against half the
    step's, with C_f constant and not."""
    steps = readings.decay(table, FLOOR[ENDS], study=IN_N, quantity=ENDS)
    reference = truths(table)
    judged = [
        V14.row(
            "base of the step's error",
            FactorPerN(GAIN),
            steps,
            source="H thm. 2.3.6",
            setup=SETUP % f" of h = {STEP:g}",
            claimed="geometric convergence, O(K^n)",
            reason=f"The motion is analytic in t. {PLACE}.",
        ),
        V14.row(
            "base of the step's error, against K",
            Finding(Base(ROOT**2, RESOLUTION)),
            steps.fit,
            source="H thm. 2.3.6",
            setup=SETUP % f" of h = {STEP:g}",
            claimed="H gives no K",
            reason=f"{PLACE}.",
        ),
        _base(table, CURVE, "H thm. 2.3.6"),
        _base(table, LARGEST, "H thm. 2.3.6, lemma 2.3.5"),
        *(_order(table, n) for n in NS),
        *(_largest(table, n) for n in NS),
        _lemma(table),
    ]
    return [*(replace(one, reference=reference) for one in judged), *_coercive(table)]


def _base(table: DataFrame, quantity: str, source: str) -> Row:
    power = POWERS[quantity]
    fit = readings.base(table, FLOOR[quantity], power=(power, 0.0), study=IN_N, quantity=quantity)
    return V14.row(
        f"base of the {quantity}",
        Base(ROOT, RESOLUTION),
        fit,
        source=source,
        setup=SETUP % f" of h = {STEP:g}" + f"; times n^({-power:g})",
        claimed=f"O(sqrt(K)^n), K the step's base, sqrt(K) = {ROOT:.4f}",
        reason=f"{PLACE}. The curve is the polynomial of degree n - 1 nearest in energy, with the "
        f"factor n^({-power:g}), and the error of a step end is the square of its distance.",
    )


def _largest(table: DataFrame, n: int) -> Row:
    return V14.row(
        f"order of the {LARGEST}, n = {n}",
        Finding(Order(n)),
        _fit(table, n, LARGEST),
        source="H thm. 2.3.7, lemma 2.3.5",
        setup=SETUP % IN_STEPS + f"; n = {n}",
        claimed="|q|_inf is at most max(1 / h, 1) |q|_W11. H prints no order in L^infinity: with "
        f"thm. 2.3.7 and C_f constant the lemma gives (p + 1) / 2 - 1 = {n - 1.5:g} at least; our "
        f"value: {n}",
        reason="Both ends are met, so that half the integral of |q'| bounds |q|, without 1 / h: "
        f"order n = {n}, as in W^{{1,1}}.",
    )


def _lemma(table: DataFrame) -> Row:
    both = pick(table, quantity=LARGEST).merge(
        pick(table, quantity=CURVE), on=["study", "n", "step"], suffixes=("", "_whole")
    )
    both = both[both["step"] != 1.0]  # where the step of n = 3 has no solution
    ratios = (both["value"] / both["value_whole"] * both["step"].clip(upper=1.0)).to_numpy(float)
    return V14.row(
        f"largest {LARGEST}, over max(1 / h, 1) of that in W^{{1,1}}",
        AtMost(0.5),
        readings.largest(ratios),
        source="H lemma 2.3.5",
        setup=SETUP % f" of h = {STEP:g} or of h = 2^(-j/2), below 1" + "; all n",
        claimed="|q|_inf is at most max(1 / h, 1) |q|_W11",
        reason="Both ends are met: a curve that leaves 0 and comes back covers its largest "
        "distance twice.",
    )


def _fit(table: DataFrame, n: int, quantity: str, study: str = IN_H) -> Fit:
    return readings.order(table, FLOOR[quantity], study=study, quantity=quantity, n=n)


def _order(table: DataFrame, n: int) -> Row:
    """The theorem with C_f constant."""
    return V14.row(
        f"order of the {CURVE}, n = {n}",
        Order(n - 0.5),
        _fit(table, n, CURVE),
        source="H thm. 2.3.7",
        setup=SETUP % IN_STEPS + f"; n = {n}",
        claimed="O(h^((p + 1) / 2)), C_f a constant, p + 1 the order of a step's error, "
        f"2 n - 1 = {2 * n - 1} (V26)",
        expected=EXCEEDS,
        reason=f"Over one step the curve is of order n = {n}: near the orbit V'' is bounded, so "
        "that C_f can be of size 1 / h for short steps; its root gives the half an order more.",
    )


def _coercive(table: DataFrame) -> list[Row]:
    """The theorem with the C_f of theorem 2.3.8, which grows like 1 / h, and with its root."""
    whole, root = ([_over_bound(table, n, power) for n in NS] for power in (1.0, 0.5))
    proof = (
        "The proof ends with C_f |distance|^2 at most the error of the action, of the order of the "
        "step's"
    )
    return [
        V14.row(
            "order of distance / (C_f^-1 sqrt(error of one step)), oscillator, largest over n",
            AtLeast(0.0, uncertainty=0.0, most=ORDER_RESOLUTION),
            _extreme(whole, lambda order: order),
            source="H thm. 2.3.7, thm. 2.3.8",
            setup=COERCIVE_SETUP,
            claimed="thm. 2.3.7, last sentence: O(C_f(h)^-1 h^((p+1)/2)); here with the C_f at the "
            "end of the proof of thm. 2.3.8, m / (4 h) for short steps, and p + 1 = 2 n - 1, the "
            "order of a step's error; H does not combine the two",
            expected=CONTRADICTED,
            reason=f"{proof}: C_f^(-1/2) follows, see the next row, and C_f^-1 is smaller by "
            "(4 h)^(1/2), so that the order is -1/2. True where C_f stays bounded as h tends to 0; "
            "H itself uses C_f constant (sec. 2.4.2).",
            reference=OSCILLATOR.name,
        ),
        V14.row(
            "order of distance / (C_f^(-1/2) sqrt(error of one step)), oscillator, farthest from 0 "
            "over n",
            Finding(Order(0.0)),
            _extreme(root, abs),
            source="H thm. 2.3.7, thm. 2.3.8",
            setup=COERCIVE_SETUP,
            claimed="H prints C_f^-1",
            reason=f"{proof}: the root of both sides has C_f^(-1/2).",
            reference=OSCILLATOR.name,
        ),
    ]


def _over_bound(table: DataFrame, n: int, power: float) -> Estimate:
    """Order in h of the distance over C_f^-power sqrt(error of one step), C_f of order -1; NaN
    where either has no order."""
    curve, steps = (estimate(_fit(table, n, quantity, COERCIVE)) for quantity in (CURVE, ENDS))
    if curve.refuted or steps.refuted:
        return Estimate(math.nan)
    scatter = math.hypot(curve.uncertainty or 0.0, 0.5 * (steps.uncertainty or 0.0))
    return Estimate(curve.value - 0.5 * steps.value - power, scatter)


def _extreme(orders: list[Estimate], size: Callable[[float], float]) -> Estimate:
    """That of the largest size; one that is NaN, if there is one."""
    lost = (one for one in orders if math.isnan(one.value))
    return next(lost, max(orders, key=lambda one: size(one.value)))


V14 = Claim(
    "V14",
    "Galerkin curves between the same points: at least half the rate of the steps",
    study,
    judge,
    ("H thm. 2.3.6", "H thm. 2.3.7"),
    reference=f"{KEPLER.name}; REBOUND IAS15 (A9)",
    statement="H thm. 2.3.6, 2.3.7: between exact ends the curve converges at half the rate of "
    "the step at least. Measured: at this rate in n, and faster in h; contradicted is only the "
    "last sentence of thm. 2.3.7, with a C_f that depends on h.",
    caught=(
        of_table(
            "base of the step's error",
            *(f"base of the {of}" for of in (CURVE, LARGEST)),
            *(f"order of the {of}, n = 6" for of in (CURVE, LARGEST)),
            beta=1.0 + 1e-9,
            C=1.0 + 1e-4,
        ),
    ),
)

"""How the errors of Galerkin curves and of step ends keep pace: the last rows of V33."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.kepler_orbit import (
    METHOD,
    ORBIT,
    STEP,
    STEPS,
    convergence_of_polynomials,
    fixed_number,
    in_as_many_steps,
    oracles,
    problem,
    truths,
)
from benchmarks.claims.vector_spaces.v04_kepler_curve_error_in_n import FROM, POWER
from references.closed_forms.kepler import KEPLER

IN_N = "Kepler, %d steps"
COUNTS = (1, 10, STEPS)  # steps
FLOORS = dict(zip(COUNTS, (1e-14, 1e-13, 2e-11), strict=True))  # round-off of the step ends
AS_GOOD, SMALL = 0.5, 0.1  # step ends are better than half the curve; errors in the asymptote
RESOLUTION = 0.005  # of a base, as for those that H prints
NS = (3, 4, 5, 6)
IN_H = {10: ENDS_AND_CURVE, STEPS: (ENDS_AND_CURVE[1], "angular momentum error along the curve")}
IN_H_FLOOR = 1e-13  # round-off of the errors in 100 short steps
OWN, SEEN = 2.0, 10.0  # curve over step ends: up to twice is not its own error, ten times is


def errors_of_curves(make_method: MakeMethod, quick: bool, report: Report) -> list[dict[str, Any]]:
    """Both errors of V4 against n by number of steps; against h those of 10 steps (H fig. 2.9), and
    of 100 those of the curve and of the angular momentum along it (H fig. 2.11)."""
    found = []
    for steps in COUNTS:
        cases = [Case(n, STEP, steps) for n in range(12, 51, 2 if quick else 1)]
        study = IN_N % steps
        found += refine(study, problem(), KEPLER, cases, ENDS_AND_CURVE, make_method, report)
    for steps, quantities in IN_H.items():
        cases = in_as_many_steps(NS, steps, quick)
        named = fixed_number(steps)
        found += refine(named, problem(), KEPLER, cases, quantities, make_method, report)
    return [*found, *oracles("oracles", STEP * STEPS, STEPS)]


def curve_rows(table: DataFrame, row: Callable[..., Row]) -> list[Row]:
    """Bases of the step ends' error over the curve's, 1 where both converge at one rate; in h."""
    shared = {
        "source": "H 1.3",
        "claimed": "in practice the curves converge at the same rate as the one-step map, although "
        "their theoretical rate is lower",
        "reference": truths(table),
    }
    setup = f"{ORBIT}; {METHOD}; h = {STEP:g}, %s steps"
    nearest = max((_late(table, steps, 0.0) for steps in COUNTS), key=lambda fit: fit.rate)
    words = ", ".join(map(str, COUNTS))
    plain = max(worst(steps) for steps in COUNTS) * math.exp(POWER[0] / FROM)
    lower = (
        "Step ends converge like r^-2n, the curve like n^(-3/2) r^-n, so that their quotient falls "
        "like n^(3/2) r^-n as soon as the errors that step ends have accumulated are smaller than "
        "the curve's own"
    )
    return [
        row(
            "base of the step ends' error over the curve's, nearest to 1 over the numbers of steps",
            Reported(Base(1.0, RESOLUTION, better=0), AtMost(plain, uncertainty=0.0)),
            nearest,
            setup=f"{setup % words}, from the n on where step ends are better than {AS_GOOD:g} of "
            "the curve",
            expected=NOT_REPRODUCED,
            reason=f"{lower}; a power of n raises a base fitted without it by exp({POWER[0]:g} / "
            f"{FROM}) at most, from n = {FROM} on. H's own figure 2.6 has 0.74^n beside 0.56^n. "
            f"Scanned: {words} steps.",
            **shared,
        ),
        row(
            f"base of the step ends' error over the curve's before n = {FROM}, {STEPS} steps",
            Finding(Base(1.0, RESOLUTION)),
            _early(table),
            setup=f"{setup % STEPS}, n below {FROM}, from where step ends err by less than {SMALL}",
            reason="Errors of step ends accumulate over 32 revolutions and are those of the curve, "
            "too, until they are small enough: so far H's sentence is true.",
            **shared,
        ),
        *(
            row(
                f"base of the step ends' error over the curve's, {steps} steps",
                Finding(Base(worst(steps), RESOLUTION)),
                _late(table, steps, -POWER[0]),
                setup=f"{setup % steps}, as in the first of these rows, times n^{POWER[0]:g}",
                reason=f"{lower}: r of the step nearest to a pericentre in its middle.",
                **{**shared, "claimed": f"1; our value: 1 / r = {worst(steps):.4f}"},
            )
            for steps in COUNTS
        ),
        *_in_h(table, row),
    ]


def worst(steps: int) -> float:
    """The slowest convergence of polynomials over these steps, by their place on the orbit."""
    starts: Iterable[float] = (math.remainder(k * STEP, 2.0 * math.pi) for k in range(steps))
    return max(convergence_of_polynomials(start, STEP) for start in starts)


def _both(table: DataFrame, steps: int) -> tuple[Array, Array, Array]:
    """(n, error of step ends, their error over the curve's), above round-off."""
    (n, ends), (_, curve) = (
        series(table, "n", study=IN_N % steps, quantity=quantity) for quantity in ENDS_AND_CURVE
    )
    kept = ends > 10.0 * FLOORS[steps]
    return n[kept], ends[kept], ends[kept] / curve[kept]


def _late(table: DataFrame, steps: int, power: float) -> Fit:
    n, _, over = _both(table, steps)
    return convergence_fits.geometric(n, over, floor=0.0, ceiling=AS_GOOD, power=(power, 0.0))


def _early(table: DataFrame) -> Fit:
    n, ends, over = _both(table, STEPS)
    kept = (n < FROM) & (ends < SMALL)
    return convergence_fits.geometric(n[kept], over[kept], floor=0.0, ceiling=2.0)


def _in_h(table: DataFrame, row: Callable[..., Row]) -> list[Row]:
    setup = f"{ORBIT}; {METHOD}; %s steps of h = 2^(-j/2), j = 2, 3, ...; n = {NS[0]} to {NS[-1]}"
    other = (
        "H's step ends converge like h^(2 ceil(n/2)) only, as with rules that are exact to lower "
        "degree (V6)"
    )
    return [
        row(
            "largest curve error over that of step ends in h-refinement, least over n",
            Reported(AtMost(OWN), AtLeast(SEEN)),
            readings.least(np.array([_own(table, n) for n in NS])),
            source="H 2.4.2",
            setup=f"{setup % 10}; where step ends err by {10.0 * IN_H_FLOOR:g} or more",
            claimed="in h, round-off becomes a problem before the curve's own error does for "
            "smaller n",
            expected=NOT_REPRODUCED,
            reason="The curve is of order n, step ends of order 2 n - 1: its own error is seen "
            f"from h = 0.1 on, long before round-off. {other}, which hides the curve's.",
            reference=truths(table),
        ),
        row(
            "order of the angular momentum's error along the curve over the curve's own, largest "
            "over n",
            Reported(
                AtLeast(2.0, round_off=ORDER_RESOLUTION), AtMost(0.0, round_off=ORDER_RESOLUTION)
            ),
            _quotient(table),
            source="H 2.4.2",
            setup=setup % STEPS,
            claimed="the factor C between the Noether quantities' error and the curve's is O(h^2) "
            "for this problem, numerical experiments suggest",
            expected=NOT_REPRODUCED,
            reason="The angular momentum along the curve errs like q', one order less than q: "
            "n - 1, and n at most where that term is odd in time about the pericentre (V7). H "
            "takes the curve's order for n / 2, the bound; it is n.",
            reference=truths(table),
        ),
    ]


def _own(table: DataFrame, n: int) -> float:
    """The largest quotient of both errors above round-off, in 10 steps."""
    (_, ends), (_, curve) = (
        series(table, "step", study=fixed_number(10), quantity=quantity, n=n)
        for quantity in ENDS_AND_CURVE
    )
    kept = ends >= 10.0 * IN_H_FLOOR
    return readings.largest(curve[kept] / ends[kept])


def _quotient(table: DataFrame) -> Estimate:
    """The largest order of the angular momentum's error less that of the curve's."""
    found = []
    for n in NS:
        curve, kept = (
            estimate(
                readings.order(table, IN_H_FLOOR, study=fixed_number(STEPS), quantity=name, n=n)
            )
            for name in IN_H[STEPS]
        )
        found.append(Estimate(kept.value - curve.value, refuted=kept.refuted or curve.refuted))
    lost = (one for one in found if math.isnan(one.value) or one.refuted)
    return next(lost, max(found, key=lambda one: one.value))

"""V3: the Kepler problem, n-refinement of the error at step ends (H figure 2.6)."""

from __future__ import annotations

from benchmarks.claims.kit import (
    ORACLES,
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    number,
    readings,
    refine,
    table_of,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FLOOR,
    IN_N,
    OTHER_MOTIONS,
    STEP,
    STEPS,
    convergence_of_polynomials,
    n_refinement,
    oracles,
    problem,
)
from references.closed_forms.kepler import KEPLER

QUANTITY = "one-step error"
CENTRED = "n-refinement, one step about the pericentre"
FAULTS = OTHER_MOTIONS

# The factor n^-g. The error of a step is the product of two expansions in Legendre polynomials, of
# q', singular like (t - t*)^(-1/2), and of the derivative of a variation of the motion, singular
# like (t - t*)^(-3/2): coefficients n^0 r^-n and n r^-n (Darboux), and 2 / (2n + 1) for the square
# of P_n: n^0 r^-2n for one step. Over many revolutions a step whose centre is d away from the
# pericentre has r(d)^-2n, about r^-2n exp(-0.263 n d^2): those that count become fewer like
# n^(-1/2), and their errors add, mostly with one sign, g = 1/2, or one of them dominates, g = 0,
# or anything between.
POWER = (0.25, 0.25)  # g and its error


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step error, such a series for a single step whose middle is
    the pericentre, and the distance between the two references."""
    ns = range(8, 55, 3) if quick else range(7, 61)
    rows = n_refinement(ns, (QUANTITY,), make_method, report)
    cases = [Case(n, STEP, 1) for n in range(8, 46, 3 if quick else 1)]
    start = problem(-STEP / 2)
    rows += refine(CENTRED, start, KEPLER, cases, (QUANTITY,), make_method, report)
    return table_of(rows + oracles("oracles", STEP * STEPS, STEPS))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The fitted bases for many steps and for one, and the latter by theory."""
    distance = number(table, quantity=ORACLES)
    return {
        "base of the one-step error": readings.base(
            table, FLOOR, study=IN_N, quantity=QUANTITY, power=POWER
        ),
        "base of the error of one step about the pericentre": readings.base(
            table, 2e-14, study=CENTRED, quantity=QUANTITY
        ),
        ORACLES: distance,
        "apart": distance,
        "theory": convergence_of_polynomials(-STEP / 2, STEP) ** 2,
    }

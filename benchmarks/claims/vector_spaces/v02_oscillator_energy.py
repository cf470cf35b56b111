"""V2: energy of the harmonic oscillator, n-refinement and history (H figures 2.4 and 2.5)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.vector_spaces.v01_oscillator_convergence_in_n import SETUP, STEP, STEPS
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import history
from references.closed_forms.oscillator import OSCILLATOR, oscillator_step

QUANTITY = "energy error"
WATCHED = 14  # the n of H figure 2.5
LONG = 4000  # steps of its history; H shows 100
FLOOR = 1e-11
REFERENCE = "exact energy 1/2; the form that the step's matrix, in rational arithmetic, conserves"
OF_FORM = f"largest energy error over that of the conserved form, n = {WATCHED}"


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the largest relative energy error at step ends; for n = 14 also
    'history', the error at each step end."""
    problem = galvi.problems.harmonic_oscillator()
    cases = [Case(n, STEP, STEPS) for n in (range(12, 27) if quick else range(8, 31))]
    rows = refine("n-refinement", problem, OSCILLATOR, cases, [QUANTITY], make_method, report)
    watched = Case(WATCHED, STEP, LONG)
    rows += history("history", problem, watched, {QUANTITY: energy_errors}, make_method)
    return frame(rows)


def round_off() -> float:
    """What rounding can add to the energy error in LONG steps, to first order, all of one sign.

    The terms of the stages' equations (1 + h^2 A) Q = q + c h v are rounded by 2^-53 of their
    sizes, as is the table; their inverse carries this into Q, and the sums p - h b.Q and
    q + h v - h^2 beta.Q into the state, which is rounded too. q and p are at most 1.
    """
    table = galvi.Galerkin(galvi.Polynomials(WATCHED - 1), galvi.gauss(2 * WATCHED)).table
    inverse = np.linalg.inv(np.eye(len(table.c)) + STEP**2 * table.A)
    q_stages, v_stages = inverse @ np.ones(len(table.c)), inverse @ (STEP * table.c)
    Q = np.abs(q_stages) + np.abs(v_stages)
    terms = Q + STEP**2 * np.abs(table.A) @ Q + 1.0 + STEP * table.c
    off = np.abs(inverse) @ terms
    kick, bend = STEP * table.b @ (off + Q), STEP**2 * table.beta @ (off + Q)
    return float(LONG * 2.0**-53 * 2.0 * ((1.0 + kick) + (1.0 + STEP + bend)))


def judge(table: DataFrame) -> list[Row]:
    """Whether the error decays geometrically, and for n = 14 is as predicted, without drift."""
    form = oscillator_step(WATCHED - 1, round(STEP))
    limit = form.largest_energy_error
    predicted = float(np.max(np.abs(form.energy_errors(LONG))))
    drift = readings.drift(table, study="history", quantity=QUANTITY)
    setup = f"{SETUP}, and on to {LONG}; n = {WATCHED}, |H - 1/2| / (1/2) at step ends"
    return [
        V2.row(
            "base of the energy error",
            Geometric(),
            readings.decay(table, FLOOR, study="n-refinement", quantity=QUANTITY),
            source="H fig. 2.4",
            setup=f"{SETUP}; |H - 1/2| / (1/2), largest over step ends",
            claimed="geometric convergence",
            reason="The solution is entire: as in V1, faster than any geometric rate.",
        ),
        V2.row(
            f"energy error, n = {WATCHED}",
            NoGrowth(limit + round_off()),
            drift,
            source="H fig. 2.5",
            setup=setup,
            claimed="does not grow",
            reason="A step is a linear symplectic map, at n = 14 with a trace in (-2, 2): it "
            "conserves p^2 + w^2 q^2 exactly, so that the energy error oscillates and |w^2 - 1| "
            "is its supremum over all time.",
            reference=REFERENCE,
        ),
        V2.row(
            OF_FORM,
            Near(1.0, round_off() / predicted),
            drift.largest / predicted,
            source="H fig. 2.5",
            setup=setup,
            claimed="does not grow",
            reason="After k steps the form predicts the energy error (w^2 - 1) sin^2(k theta), "
            "2 cos(theta) the trace; of these the largest.",
            reference=REFERENCE,
        ),
    ]


V2 = Claim(
    "V2",
    "Oscillator at h = 20: the energy error falls geometrically with n and does not grow",
    study,
    judge,
    ("H fig. 2.4", "H fig. 2.5"),
    reference="exact energy 1/2",
    statement="H fig. 2.4, 2.5: the energy error falls geometrically with n and, at n = 14, does "
    "not grow with time.",
    caught=(of_table("base of the energy error", "energy error, n = 14", OF_FORM, b=1.0 + 1e-3),),
)

"""V8: the Kepler problem, energy and angular momentum over 10000 steps (H figures 2.12, 2.13)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.claims.short_runs import PLACES, SHORT, short_runs
from benchmarks.claims.short_runs import STEPS as FEW
from benchmarks.claims.vector_spaces.kepler_orbit import METHOD, ORBIT, STEP, problem
from benchmarks.measures.errors import angular_momentum_errors, energy_errors
from benchmarks.measures.refinement import history
from references.closed_forms.kepler import KEPLER

N, STEPS = 8, 10000
# q and p rounded once a step change L = q x p by at most 2^-52 |q| |p|, and |q| |p| <= 1 = L / 0.8
# on this orbit: the sum, should all roundings have one sign
ROUND_OFF = STEPS * 2.0**-52 / 0.8
SETUP = f"{ORBIT}; {METHOD}, n = {N}; h = {STEP:g}, {STEPS} steps; relative, at step ends"
ENERGY, ANGULAR = "energy error", "angular momentum error"
MEASURES = {ENERGY: energy_errors, ANGULAR: angular_momentum_errors}


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'history' of both relative errors at step ends, from (q, p); the largest energy errors
    of short runs from all over the orbit."""
    report(f"n = {N}, {STEPS} steps of {STEP:g}")
    rows = history("history", problem(), Case(N, STEP, STEPS), MEASURES, make_method)
    method = method_of(make_method, N)
    return frame([*rows, *short_runs(ENERGY, problem(), KEPLER, math.tau, method, STEP)])


def judge(table: DataFrame) -> list[Row]:
    """Bounded and without drift."""
    energy, angular = (readings.drift(table, study="history", quantity=name) for name in MEASURES)
    limit = readings.largest_of(table, study=SHORT, quantity=ENERGY)
    return [
        V8.row(
            f"{ENERGY}, n = {N}",
            NoGrowth(limit),
            energy,
            source="H fig. 2.12",
            setup=f"{SETUP}; limit: the largest error of {FEW} steps from any of {PLACES} "
            "places on the exact orbit",
            reference="exact energy -1/2",
            reason="The method is symplectic and the step is constant: a step that passes the "
            "pericentre misses the energy by up to 7 %, and the next ones give it back. The sum "
            "stays within what few steps show, wherever on the orbit they start.",
        ),
        V8.row(
            f"{ANGULAR}, n = {N}",
            NoGrowth(ROUND_OFF, ROUND_OFF),
            angular,
            source="H fig. 2.13",
            reference="exact angular momentum 0.8",
            reason="Rotations leave the discrete Lagrangian as it is, so (q, p) at step ends "
            "conserves angular momentum exactly; what is seen is round-off, which does add up, to "
            "less than one rounding a step.",
        ),
    ]


V8 = Claim(
    "V8",
    f"Kepler, n = {N}, {STEPS} steps: energy and angular momentum do not grow",
    study,
    judge,
    ("H fig. 2.12", "H fig. 2.13"),
    setup=SETUP,
    claimed="does not grow",
    statement="H fig. 2.12, 2.13: the errors of energy and angular momentum do not grow in long "
    "runs.",
    caught=(of_table("energy error, n = 8", "angular momentum error, n = 8", b=1.0 + 1e-3),),
)

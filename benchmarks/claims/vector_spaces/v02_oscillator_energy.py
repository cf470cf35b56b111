"""V2: energy of the harmonic oscillator, n-refinement and history (H figures 2.4 and 2.5)."""

from __future__ import annotations

import numpy as np

import galvi
from benchmarks.claims.kit import (
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    readings,
    refine,
    table_of,
)
from benchmarks.claims.vector_spaces.v01_oscillator_convergence_in_n import STEP, STEPS
from benchmarks.measures.errors import energy_errors
from benchmarks.measures.refinement import history
from references.closed_forms.oscillator import OSCILLATOR, oscillator_step

QUANTITY = "energy error"
HISTORY_N = 14  # the n of H figure 2.5
HISTORY_STEPS = 4000  # steps of its history; H shows 100
FLOOR = 1e-11


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the largest relative energy error at step ends; for n = 14 also
    'history', the error at each step end."""
    problem = galvi.problems.harmonic_oscillator()
    cases = [Case(n, STEP, STEPS) for n in (range(12, 27) if quick else range(8, 31))]
    rows = refine("n-refinement", problem, OSCILLATOR, cases, [QUANTITY], make_method, report)
    watched = Case(HISTORY_N, STEP, HISTORY_STEPS)
    rows += history("history", problem, watched, {QUANTITY: energy_errors}, make_method)
    return table_of(rows)


def round_off() -> float:
    """The energy error that rounding can add in HISTORY_STEPS steps, to first order, if all
    roundings have the same sign.

    The terms of the stages' equations (1 + h^2 A) Q = q + c h v and the table are rounded by 2^-53
    of their sizes. The inverse carries this into Q, and the sums p - h b.Q and q + h v - h^2 beta.Q
    carry it into the state, which is rounded, too. q and p are at most 1.
    """
    table = galvi.Galerkin(galvi.Polynomials(HISTORY_N - 1), galvi.gauss(2 * HISTORY_N)).table
    inverse = np.linalg.inv(np.eye(len(table.c)) + STEP**2 * table.A)
    Q = np.abs(np.sum(inverse, axis=1)) + np.abs(inverse @ (STEP * table.c))
    terms = Q + STEP**2 * np.abs(table.A) @ Q + 1.0 + STEP * table.c
    stage_errors = np.abs(inverse) @ terms + Q
    kick, bend = STEP * table.b @ stage_errors, STEP**2 * table.beta @ stage_errors
    return float(HISTORY_STEPS * 2.0**-53 * 2.0 * ((1.0 + kick) + (1.0 + STEP + bend)))


def read(table: DataFrame) -> dict[str, Measurement]:
    """The decay of the error, and for n = 14 its drift and its size over the prediction of the
    quadratic form that the step's matrix conserves."""
    form = oscillator_step(HISTORY_N - 1, round(STEP))
    predicted = float(np.max(np.abs(form.energy_errors(HISTORY_STEPS))))
    drift = readings.drift(table, study="history", quantity=QUANTITY)
    return {
        "base of the energy error": readings.decay(
            table, FLOOR, study="n-refinement", quantity=QUANTITY
        ),
        "energy error, n = 14": drift,
        "largest energy error over that of the conserved form, n = 14": drift.largest / predicted,
        "limit": form.largest_energy_error + round_off(),
        "resolution": round_off() / predicted,
    }

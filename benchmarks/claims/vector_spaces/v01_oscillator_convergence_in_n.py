"""V1: the harmonic oscillator, n-refinement at a step of three periods (H figure 2.3)."""

from __future__ import annotations

import galvi
from benchmarks.claims.kit import (
    ENDS_AND_CURVE,
    Case,
    DataFrame,
    MakeMethod,
    Measurement,
    Report,
    readings,
    refine,
    table_of,
)
from references.closed_forms.oscillator import OSCILLATOR

STEP, STEPS = 20.0, 100
FLOOR = 1e-11  # round-off of a phase of 2000 radians; 5e-12 in a prototype


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series 'n-refinement' of the one-step and the curve error."""
    cases = [Case(n, STEP, STEPS) for n in range(14 if quick else 8, 31)]
    problem = galvi.problems.harmonic_oscillator()
    return table_of(
        refine("n-refinement", problem, OSCILLATOR, cases, ENDS_AND_CURVE, make_method, report)
    )


def read(table: DataFrame) -> dict[str, Measurement]:
    """The decay and the smallest value of both errors."""
    decays = {name: readings.decay(table, FLOOR, quantity=name) for name in ENDS_AND_CURVE}
    return {
        **{f"base of the {name}": decay for name, decay in decays.items()},
        **{f"smallest {name}": decay.smallest for name, decay in decays.items()},
    }

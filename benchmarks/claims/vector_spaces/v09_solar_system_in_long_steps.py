"""V9: the solar system in steps longer than Mercury's year (H figure 2.14)."""

from __future__ import annotations

import pandas as pd

import galvi
from benchmarks.checks import bounds
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.studies.long_steps import (
    CHANGE,
    DIFFERENCE,
    TURN,
    LongSteps,
    distance_at_end,
    energy_error,
    worst_shape,
)
from references.rebound import ias15

STEP, STEPS = 100.0, 100
N, HIGHER = 25, 41
SAMPLES = 5000  # of the orbits, every 2 days
INNER = ("Mercury", "Venus", "Earth", "Mars")  # those of H figure 2.14
SETUP = (
    "Sun, 8 planets, Pluto; JPL DE421 states of 2000-01-01 (JD 2451544.5 TDB), au and days; "
    f"Polynomials(n - 1), gauss(2 n), n = %d; h = {STEP:g} d, {STEPS} steps"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series of `LongSteps` for n = 25 and 41, the inner planets watched."""
    problem = galvi.problems.solar_system()
    return LongSteps(problem, STEP, STEPS, (N, HIGHER), INNER, SAMPLES).study(make_method, report)


def judge(table: pd.DataFrame) -> list[Row]:
    """Near IAS15, energy kept, orbits closed and in place; the same again with n = 41."""
    long_step = (
        "In a step of 100 days Mercury does more than a revolution; 25 basis functions resolve it "
        "to about 1e-4, and slower planets far better."
    )
    closed = (
        "The radii of the inner planets return to within what the other planets change them, in "
        "IAS15's orbits as in these; the method adds no visible precession."
    )
    higher = "Mercury's error falls geometrically with n; at n = 41 it is resolved to 1e-9."
    return [
        _row("Mercury, distance to IAS15 at the end [au]", N, 2e-4, long_step,
             distance_at_end(table, N, "Mercury")),
        _row("Earth, distance to IAS15 at the end [au]", N, 1e-9, long_step,
             distance_at_end(table, N, "Earth")),
        _row("energy error", N, 1e-9, "The method is symplectic; what is left is Mercury's "
             "truncation error, weighted by its small mass.", energy_error(table, N)),
        _row("change of the inner orbits' extent, first to last revolution [mean distance]", N,
             1e-3, closed, worst_shape(table, CHANGE, INNER)),
        _row("extent of the inner orbits in the last revolution, against IAS15 [au]", N, 1e-4,
             closed, worst_shape(table, DIFFERENCE, INNER)),
        _row("direction of the inner perihelia at the end, against IAS15 [rad]", N, 5e-3, closed,
             worst_shape(table, TURN, INNER)),
        _row("Mercury, distance to IAS15 at the end [au]", HIGHER, 1e-8, higher,
             distance_at_end(table, HIGHER, "Mercury")),
        _row("energy error", HIGHER, 1e-13, "With Mercury resolved, energy is kept to round-off.",
             energy_error(table, HIGHER)),
    ]  # fmt: skip


def _row(quantity: str, n: int, limit: float, reason: str, measured: float) -> Row:
    return Row(
        id="V9",
        quantity=f"{quantity}, n = {n}",
        source="H fig. 2.14",
        setup=SETUP % n,
        claimed="closed, stable orbits although h exceeds Mercury's period",
        bound=f"at most {limit:g}",
        measured=measured,
        uncertainty=None,
        expected=bounds.HOLDS,
        reason=reason,
        reference="initial energy" if "energy" in quantity else ias15.IAS15.name,
        verdict=bounds.bound(measured, limit),
    )


V9 = Claim(
    "V9",
    "Solar system at h = 100 d: closed, stable orbits beyond Mercury's period",
    study,
    judge,
    ("H fig. 2.14",),
)

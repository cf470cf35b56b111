"""V9: the solar system in steps longer than Mercury's year (H figure 2.14)."""

from __future__ import annotations

import pandas as pd

import galvi
from benchmarks.checks.bounds import AtMost
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
    """Distance to IAS15, energy, and shape of the orbits, for n = 25 and 41."""
    long_step = (
        "In a step of 100 days Mercury does more than a revolution; 25 basis functions resolve it "
        "to about 1e-4, and slower planets far better."
    )
    closed = (
        "The radii of the inner planets return to within what the other planets change them, in "
        "IAS15's orbits as in these; the method adds no visible precession."
    )
    higher = "Mercury's error falls geometrically with n; at n = 41 it is resolved to 1e-9."
    mercury, earth = (f"{body}, distance to IAS15 at the end [au]" for body in ("Mercury", "Earth"))
    change = "change of the inner orbits' extent, first to last revolution [mean distance]"
    extent = "extent of the inner orbits in the last revolution, against IAS15 [au]"
    direction = "direction of the inner perihelia at the end, against IAS15 [rad]"
    return [
        _row(N, mercury, 2e-4, distance_at_end(table, N, "Mercury"), long_step),
        _row(N, earth, 1e-9, distance_at_end(table, N, "Earth"), long_step),
        _energy(
            table,
            N,
            1e-9,
            "The method is symplectic; what is left is Mercury's truncation error, weighted by its "
            "small mass.",
        ),
        _row(N, change, 1e-3, worst_shape(table, CHANGE, INNER), closed),
        _row(N, extent, 1e-4, worst_shape(table, DIFFERENCE, INNER), closed),
        _row(N, direction, 5e-3, worst_shape(table, TURN, INNER), closed),
        _row(HIGHER, mercury, 1e-8, distance_at_end(table, HIGHER, "Mercury"), higher),
        _energy(table, HIGHER, 1e-13, "With Mercury resolved, energy is kept to round-off."),
    ]


def _row(n: int, quantity: str, limit: float, measured: float, reason: str, **own: str) -> Row:
    name = f"{quantity}, n = {n}"
    return V9.row(name, AtMost(limit), measured, setup=SETUP % n, reason=reason, **own)


def _energy(table: pd.DataFrame, n: int, limit: float, reason: str) -> Row:
    measured = energy_error(table, n)
    return _row(n, "energy error", limit, measured, reason, reference="initial energy")


V9 = Claim(
    "V9",
    "Solar system at h = 100 d: closed, stable orbits beyond Mercury's period",
    study,
    judge,
    ("H fig. 2.14",),
    claimed="closed, stable orbits although h exceeds Mercury's period",
    reference=ias15.IAS15.name,
)

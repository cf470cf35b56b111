"""V10: the outer solar system in steps of five years (H figure 2.15)."""

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
    energy_error,
    farthest_at_end,
    worst_shape,
)
from references.rebound import ias15

STEP, STEPS, N = 1825.0, 100, 25
SAMPLES = 5000  # of the orbits, every 36.5 days
OUTER = ("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto")  # those of H figure 2.15
MANY_TURNS = OUTER[:3]  # 42, 17 and 6 revolutions; Neptune and Pluto do three and two
SETUP = (
    "Sun and inner planets as one body, Jupiter to Neptune, Pluto; JPL DE421 states of 2000-01-01 "
    f"(JD 2451544.5 TDB), au and days; Polynomials(n - 1), gauss(2 n), n = {N}; h = {STEP:g} d, "
    f"{STEPS} steps"
)


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series of `LongSteps` for n = 25, the outer planets watched."""
    problem = galvi.problems.outer_solar_system()
    return LongSteps(problem, STEP, STEPS, (N,), OUTER, SAMPLES).study(make_method, report)


def judge(table: pd.DataFrame) -> list[Row]:
    """Near IAS15, energy kept, orbits closed and in place."""
    resolved = (
        "A step is less than half a revolution of Jupiter: 25 basis functions resolve it to "
        "round-off, and IAS15 with its two step criteria differs by as much."
    )
    closed = (
        "Distances change from one revolution to the next by what the planets do to each other, "
        "in IAS15's orbits to the same digits."
    )
    return [
        _row("farthest planet from IAS15 at the end [au]", 1e-9, resolved,
             farthest_at_end(table, N, OUTER)),
        _row("energy error", 2e-13, "The method is symplectic and the orbits are resolved: what "
             "is left is round-off.", energy_error(table, N)),
        _row("change of extent of Jupiter, Saturn, Uranus, first to last revolution "
             "[mean distance]", 3e-3, closed, worst_shape(table, CHANGE, MANY_TURNS)),
        _row("extent of the orbits in the last revolution, against IAS15 [au]", 1e-9,
             f"{closed} This is the measure for Neptune and Pluto too, which do three and two "
             "revolutions in 500 years.", worst_shape(table, DIFFERENCE, OUTER)),
        _row("direction of the perihelia at the end, against IAS15 [rad]", 1e-9,
             "The perihelia of the elliptic orbits about the first body swing with it; the method "
             "adds no precession to that.", worst_shape(table, TURN, OUTER)),
    ]  # fmt: skip


def _row(quantity: str, limit: float, reason: str, measured: float) -> Row:
    return Row(
        id="V10",
        quantity=f"{quantity}, n = {N}",
        source="H fig. 2.15",
        setup=SETUP,
        claimed="closed, stable, precession-free orbits in steps of five years",
        bound=f"at most {limit:g}",
        measured=measured,
        uncertainty=None,
        expected=bounds.HOLDS,
        reason=reason,
        reference="initial energy" if "energy" in quantity else ias15.IAS15.name,
        verdict=bounds.bound(measured, limit),
    )


V10 = Claim(
    "V10",
    "Outer solar system at h = 1825 d: closed, stable orbits without precession",
    study,
    judge,
    ("H fig. 2.15",),
)

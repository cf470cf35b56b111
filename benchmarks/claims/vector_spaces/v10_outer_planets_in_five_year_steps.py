"""V10: the outer solar system in steps of five years (H figure 2.15)."""

from __future__ import annotations

from benchmarks.claims.kit import *
from benchmarks.studies.long_steps import (
    CHANGE,
    DIFFERENCE,
    TURN,
    LongSteps,
    energy_error,
    energy_in_frame,
    farthest_at_end,
    farthest_in_frame,
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

IN_FRAME = SETUP.replace("gauss(2 n)", "gauss(n - 1), KeplerFrame()")


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series of `LongSteps` for n = 25, the outer planets watched."""
    problem = galvi.problems.outer_solar_system()
    return LongSteps(problem, STEP, STEPS, (N,), OUTER, SAMPLES).study(make_method, report)


def judge(table: DataFrame) -> list[Row]:
    """Distance to IAS15, energy, and shape of the orbits."""
    closed = (
        "Distances change from one revolution to the next by what the planets do to each other, "
        "in IAS15's orbits to the same digits."
    )
    return [
        V10.row(
            f"farthest planet from IAS15 at the end [au], n = {N}",
            AtMost(1e-9),
            farthest_at_end(table, N, OUTER),
            reason="A step is less than half a revolution of Jupiter: 25 basis functions resolve "
            "it to round-off, and IAS15 with its two step criteria differs by as much.",
        ),
        V10.row(
            f"energy error, n = {N}",
            AtMost(2e-13),
            energy_error(table, N),
            reason="The method is symplectic and the orbits are resolved: what is left is "
            "round-off.",
            reference="initial energy",
        ),
        V10.row(
            "change of extent of Jupiter, Saturn, Uranus, first to last revolution "
            f"[mean distance], n = {N}",
            AtMost(3e-3),
            worst_shape(table, CHANGE, MANY_TURNS),
            reason=closed,
        ),
        V10.row(
            f"extent of the orbits in the last revolution, against IAS15 [au], n = {N}",
            AtMost(1e-9),
            worst_shape(table, DIFFERENCE, OUTER),
            reason=f"{closed} This is the measure for Neptune and Pluto too, which do three and "
            "two revolutions in 500 years.",
        ),
        V10.row(
            f"direction of the perihelia at the end, against IAS15 [rad], n = {N}",
            AtMost(1e-9),
            worst_shape(table, TURN, OUTER),
            reason="The perihelia of the elliptic orbits about the first body swing with it; the "
            "method adds no precession to that.",
        ),
        V10.row(
            "farthest planet from IAS15 at step ends, in the Kepler frame [au]",
            Finding(AtMost(1e-9)),
            farthest_in_frame(table, OUTER),
            setup=IN_FRAME,
            claimed="none: galvi's own frame",
            reason="24 stages resolve the whole attraction to round-off, and the frame leaves a "
            "thousandth of it.",
        ),
        V10.row(
            "energy error in the Kepler frame",
            Finding(AtMost(2e-13)),
            energy_in_frame(table),
            setup=IN_FRAME,
            claimed="none: galvi's own frame",
            reason="Converged passes are symplectic: what is left is round-off.",
            reference="initial energy",
        ),
    ]


V10 = Claim(
    "V10",
    "Outer solar system at h = 1825 d: closed, stable orbits without precession",
    study,
    judge,
    ("H fig. 2.15",),
    setup=SETUP,
    claimed="closed, stable, precession-free orbits in steps of five years",
    reference=ias15.IAS15.name,
    statement="H fig. 2.15: orbits are closed, stable and free of precession in steps of five "
    "years.",
    caught=(
        of_table("farthest planet from IAS15 at the end [au], n = 25", beta=1.0 + 1e-6),
        of_table("energy error, n = 25", b=1.0 + 1e-3),
        of_table(
            "energy error in the Kepler frame",
            "farthest planet from IAS15 at step ends, in the Kepler frame [au]",
            integral=1.5,
        ),
        of_motion("clock reversed", bool, reversed_clock),
        of_motion("Sun heavier", bool, heavier),
    ),
)

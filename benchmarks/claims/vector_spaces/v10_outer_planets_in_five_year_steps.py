"""V10: the outer solar system in steps of five years (H figure 2.15)."""

from __future__ import annotations

import galvi
from benchmarks.claims.kit import (
    DataFrame,
    MakeMethod,
    Report,
    heavier,
    number,
    of_motion,
    reversed_clock,
)
from benchmarks.studies.long_steps import (
    AT_END,
    CHANGE,
    DIFFERENCE,
    DISTANCE,
    ENERGY,
    IN_FRAME,
    TURN,
    LongSteps,
    worst,
)

STEP, STEPS, N = 1825.0, 100, 25
SAMPLES = 5000  # of the orbits, every 36.5 days
OUTER = ("Jupiter", "Saturn", "Uranus", "Neptune", "Pluto")  # those of H figure 2.15


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series of `LongSteps` for n = 25 and the outer planets."""
    problem = galvi.problems.outer_solar_system()
    return LongSteps(problem, STEP, STEPS, (N,), OUTER, SAMPLES).study(make_method, report)


def read(table: DataFrame) -> dict[str, float]:
    """Distances to IAS15, energy, and the shape of the orbits; its change over 42, 17 and 6
    revolutions of Jupiter, Saturn and Uranus (Neptune and Pluto complete only three and two)."""
    of_25 = {
        "farthest planet from IAS15 at the end [au]": worst(table, OUTER, AT_END, "n = 25"),
        "energy error": number(table, quantity=ENERGY),
        "change of extent of Jupiter, Saturn, Uranus, first to last revolution [mean distance]": (
            worst(table, OUTER[:3], CHANGE)
        ),
        "extent of the orbits in the last revolution, against IAS15 [au]": worst(
            table, OUTER, DIFFERENCE
        ),
        "direction of the perihelia at the end, against IAS15 [rad]": worst(table, OUTER, TURN),
    }
    return {
        **{f"{name}, n = 25": size for name, size in of_25.items()},
        "farthest planet from IAS15 at step ends, in the Kepler frame [au]": worst(
            table, OUTER, DISTANCE + IN_FRAME, "frame"
        ),
        "energy error in the Kepler frame": number(table, quantity=ENERGY + IN_FRAME),
    }


FAULTS = {
    "clock reversed": of_motion(reversed_clock),
    "Sun heavier": of_motion(heavier),
}

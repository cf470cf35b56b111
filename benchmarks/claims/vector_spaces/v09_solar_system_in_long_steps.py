"""V9: the solar system in steps longer than Mercury's year (H figure 2.14)."""

from __future__ import annotations

import math
from functools import partial
from typing import Any

import numpy as np
import pandas as pd

import galvi
from benchmarks.claims.kit import (
    ORACLES,
    OTHER_TRUTH,
    DataFrame,
    Fault,
    MakeMethod,
    Measurement,
    Report,
    heavier,
    number,
    of_motion,
    readings,
    reversed_clock,
    row,
    table_of,
    times,
)
from benchmarks.measures.independent_invariants import energy
from benchmarks.studies import long_steps
from benchmarks.studies.long_steps import ALONG, DISTANCE, ENERGY, IN_FRAME, LongSteps, worst
from references.rebound.ias15 import IAS15
from references.stored.planets import STORED_TRUTH

STEP, STEPS = 100.0, 100
N, NS = 25, (21, 29, 33, 37, 41)  # H's n, and others for the rate
SAMPLES = 5000  # of the orbits, every 2 days
INNER = ("Mercury", "Venus", "Earth", "Mars")  # those of H figure 2.14
MERCURY = 1  # index among the bodies
VISIBLE = 1e-3  # of an orbit's size: 0.1 mm, the width of a line, in a figure 10 cm across


def study(make_method: MakeMethod, quick: bool, report: Report) -> DataFrame:
    """Series of `LongSteps` for the inner planets, with shapes for n = 25; and the largest distance
    of Mercury between the two references at ten times."""
    problem = galvi.problems.solar_system()
    table = LongSteps(problem, STEP, STEPS, (N, *NS), INNER, SAMPLES).study(make_method, report)
    runs = [oracle.run(problem, STEP * STEPS, {"samples": 10}) for oracle in (IAS15, STORED_TRUTH)]
    distances = np.linalg.norm(runs[0].q[:, MERCURY] - runs[1].q[:, MERCURY], axis=-1)
    both = row(quantity=f"{ORACLES} [au], Mercury", value=float(np.max(distances)))
    return pd.concat([table, table_of([both])], ignore_index=True)


def bounds() -> dict[str, float]:
    """Bounds by name: visible errors, errors that the Kepler frame leaves, and the base of
    Mercury's error in n.

    An error dE of Mercury's own energy E_M, constant over all N revolutions, changes its mean
    motion by 3/2 dE / E_M and so moves it by 3 pi N dE / E_M mean distances.

    The pull on the inner planets of bodies other than the Sun is assumed to be less than the ratio
    of the heaviest planet's mass to the Sun's, relative to the Sun's pull.

    Kepler's orbit is singular where 1 = e cos E: at the complex time i t* from the perihelion, t* =
    (P / 2 pi) (arcosh 1/e - sqrt(1 - e^2)). In a step about the perihelion, which is [-1, 1], this
    is i y with y = 2 t* / h; polynomials converge like rho^-n with rho = y + sqrt(1 + y^2), and
    step ends like its square.
    """
    problem: Any = galvi.problems.solar_system()
    masses, G = problem.system.masses, problem.system.G
    gm = G * (masses[0] + masses[MERCURY])
    q, v = (x[MERCURY] - x[0] for x in (problem.q0, problem.v0))
    axis = 1.0 / (2.0 / np.linalg.norm(q) - v @ v / gm)
    radian = math.sqrt(axis**3 / gm)
    e = float(np.linalg.norm(np.cross(v, np.cross(q, v)) / gm - q / np.linalg.norm(q)))
    y = 2.0 * radian * (math.acosh(1.0 / e) - math.sqrt(1.0 - e * e)) / STEP
    base = (y + math.sqrt(1.0 + y * y)) ** -2
    total = abs(energy(problem, problem.q0[None], problem.v0[None])[0])
    mercury_energy = 0.5 * gm * masses[MERCURY] / axis
    visible = VISIBLE / (1.5 * STEP * STEPS / radian) * float(mercury_energy / total)
    left = np.max(masses[1:]) / masses[0]
    return {
        "visible_energy": visible,
        "part_left": left,
        "visible_in_frame": left * VISIBLE,
        "visible_energy_in_frame": left * visible,
        "mercury_base": base,
        "thirtieth_part": base / 30.0,
    }


def read(table: DataFrame) -> dict[str, Measurement]:
    """Distances to IAS15, shape and energy for n = 25, their rates in n, and the Kepler frame."""
    relative = partial(worst, table, INNER, relative=True)
    both = f"{ORACLES} [au], Mercury"
    of_25 = {
        "largest distance to IAS15 at step ends of the inner planets [mean distance]": relative(
            DISTANCE, "n = 25"
        ),
        "largest distance to IAS15 on the curve of the inner planets [mean distance]": relative(
            ALONG
        ),
        "change of the inner orbits' extent, first to last revolution [mean distance]": worst(
            table, INNER, long_steps.CHANGE
        ),
        "extent of the inner orbits in the last revolution, against IAS15 [mean distance]": (
            relative(long_steps.DIFFERENCE)
        ),
        "turn of the inner ellipses at the end, against IAS15 [rad], times the eccentricity": (
            worst(table, INNER, long_steps.SHIFT)
        ),
        "energy error": number(table, quantity=ENERGY, study="n = 25"),
    }
    return {
        **bounds(),
        **{f"{name}, n = 25": size for name, size in of_25.items()},
        "largest distance to IAS15 at step ends of the inner planets, in the Kepler frame "
        "[mean distance]": relative(DISTANCE + IN_FRAME, "frame"),
        "energy error in the Kepler frame": number(table, quantity=ENERGY + IN_FRAME),
        "base of Mercury's largest distance to IAS15": readings.base(
            table, 1e-9, quantity=DISTANCE, label="Mercury"
        ),
        "base of the energy error": readings.base(table, 3e-15, quantity=ENERGY),
        both: number(table, quantity=both),
    }


def slower(table: DataFrame) -> None:
    """Change errors as by a base in n that is larger by 8 %, for a planted fault."""
    errors = table["quantity"].isin([DISTANCE, ENERGY])
    table.loc[errors, "value"] *= 1.08 ** table.loc[errors, "n"]


FAULTS = {
    "another truth": OTHER_TRUTH,
    "an error that falls more slowly": Fault(table=slower),
    "a curve twice as far": Fault(table=times(2.0, quantity=ALONG)),
    "a frame that gains too little": Fault(table=times(100.0, study="frame")),
    "clock reversed": of_motion(reversed_clock),
    "Sun heavier": of_motion(heavier),
}

"""The figures of V1 to V11: 1.1 and 2.3 to 2.15 of H, each as data."""

from __future__ import annotations

import math

from benchmarks.claims.vector_spaces import v01_oscillator_convergence_in_n as v01
from benchmarks.claims.vector_spaces import v02_oscillator_energy as v02
from benchmarks.claims.vector_spaces import v03_kepler_step_error_in_n as v03
from benchmarks.claims.vector_spaces import v04_kepler_curve_error_in_n as v04
from benchmarks.claims.vector_spaces import v06_kepler_order as v06
from benchmarks.claims.vector_spaces import v07_momentum_along_curve as v07
from benchmarks.claims.vector_spaces import v09_solar_system_in_long_steps as v09
from benchmarks.claims.vector_spaces import v10_outer_planets_in_five_year_steps as v10
from benchmarks.claims.vector_spaces.euler_readings import ENERGY, EXPLICIT, IMPLICIT, SYMPLECTIC
from benchmarks.claims.vector_spaces.implicit_euler_orbit import (
    DAYS_PER_YEAR,
    DURATION_YEARS,
    INNER,
    PRINTED_STEP,
)
from benchmarks.claims.vector_spaces.kepler_orbit import (
    FIXED_TIME,
    FLOOR,
    INVARIANTS,
    SINGULARITY,
    fixed_number,
)
from benchmarks.studies.long_steps import CURVE, ENDS
from reports.figures.plots.convergence import Rate, convergence, in_h
from reports.figures.plots.lines import energies, history
from reports.figures.plots.paths import Panel, paths
from reports.results.section import Figure

N_REFINEMENT = "n-refinement"
ORBIT = "orbit"  # study of the runs in long steps
HALF_WIDTH = 3.0  # au, half the width of the panels of H's figure 1.1
HOLLOW_TEXT = (
    "Solid line: fit over the filled points; hollow points: pre-asymptotic, unstable or round-off"
)
DASHED_TEXT = f"{HOLLOW_TEXT}; dashed, offset upwards: the claimed rate."
POSITION_ERROR = "largest error of the position [unit of length]"
ENERGY_ERROR = "largest relative energy error [1]"
MOMENTUM_ERROR = "largest relative error of angular momentum [1]"


def _in_h(name: str, number: str, subject: str, claim: str, how: str, ylabel: str, rates: tuple):
    return Figure(
        name=name,
        source=f"H fig. {number}",
        title=f"{subject}, {how}",
        claims=(claim,),
        draw=convergence,
        options={"rates": rates, "ylabel": ylabel},
        caption="Kepler, e = 0.6, h-refinement. "
        f"{DASHED_TEXT if rates[0].claimed else HOLLOW_TEXT + '.'}",
        size=(6.4, 4.4),
    )


OSCILLATOR_AND_PLANETS: tuple[Figure, ...] = (
    Figure(
        name="fig-1-01",
        source="H fig. 1.1",
        title="Inner planets by three methods of order 1",
        claims=("V11",),
        draw=paths,
        options={
            "panels": (
                Panel(EXPLICIT, EXPLICIT, half=HALF_WIDTH),
                Panel(IMPLICIT, IMPLICIT, half=HALF_WIDTH, stops=True),
                Panel(SYMPLECTIC, SYMPLECTIC, half=HALF_WIDTH),
            ),
            "bodies": INNER,
        },
        caption=f"{DURATION_YEARS:g} years in steps of {PRINTED_STEP:g} years, relative to the "
        "Sun, in the "
        "equatorial plane of the ICRF; explicit Euler leaves the frame. "
        "Implicit Euler ends at the crosses, where its solver stops converging.",
        size=(9.6, 3.5),
    ),
    Figure(
        name="fig-1-01-energy",
        source="H fig. 1.1",
        title="Solar system: energy by three methods of order 1",
        claims=("V11",),
        draw=energies,
        options={
            "quantity": ENERGY,
            "labels": {
                EXPLICIT: "explicit Euler: rises",
                SYMPLECTIC: "symplectic Euler: stays",
                IMPLICIT: "implicit Euler: falls, then stops",
            },
            "unit": DAYS_PER_YEAR,
        },
        caption="Relative change of the energy; logarithmic outside the shaded band. Implicit "
        "Euler ends at the cross, where its solver stops converging.",
    ),
    Figure(
        name="fig-2-03",
        source="H fig. 2.3",
        title="Harmonic oscillator, 100 steps of h = 20",
        claims=("V1",),
        draw=convergence,
        options={
            "rates": (
                Rate(N_REFINEMENT, "one-step error", "one-step", v01.FLOOR),
                Rate(N_REFINEMENT, "curve error", "curve", v01.FLOOR),
            ),
            "ylabel": POSITION_ERROR,
            "top": 1e2,
        },
        caption=f"A step is about three periods long. {HOLLOW_TEXT}.",
    ),
    Figure(
        name="fig-2-04",
        source="H fig. 2.4",
        title="Harmonic oscillator: energy error, 100 steps of h = 20",
        claims=("V2",),
        draw=convergence,
        options={
            "rates": (Rate(N_REFINEMENT, v02.QUANTITY, "energy", v02.FLOOR),),
            "ylabel": ENERGY_ERROR,
            "top": 1e2,
        },
        caption=f"{HOLLOW_TEXT}.",
    ),
    Figure(
        name="fig-2-05",
        source="H fig. 2.5",
        title=f"Harmonic oscillator: energy error in time, n = {v02.HISTORY_N}, h = 20",
        claims=("V2",),
        draw=history,
        options={"quantity": v02.QUANTITY, "ylabel": "relative energy error [1]"},
        caption="At step ends. An error that grows with time leaves the band.",
    ),
    Figure(
        name="fig-2-06",
        source="H fig. 2.6",
        title="Kepler, e = 0.6, 100 steps of h = 2",
        claims=("V4", "V3"),
        draw=convergence,
        options={
            "rates": (
                Rate(N_REFINEMENT, "one-step error", "one-step", FLOOR, claimed=0.56,
                     power=v03.POWER),
                Rate(N_REFINEMENT, "curve error", "curve", FLOOR, claimed=0.74, start=v04.FROM,
                     power=v04.POWER),
            ),
            "ylabel": POSITION_ERROR,
        },
        caption=f"{DASHED_TEXT} The curve's own, slower rate appears once the error accumulated "
        "at step "
        "ends is smaller.",
        size=(6.4, 4.4),
    ),
    *(
        Figure(
            name=f"fig-2-0{number}",
            source=f"H fig. 2.{number}",
            title=f"Kepler, e = 0.6: {quantity}, 100 steps of h = 2",
            claims=("V5",),
            draw=convergence,
            options={
                "rates": (Rate(N_REFINEMENT, quantity, "curve", FLOOR, claimed=0.74),),
                "ylabel": ylabel,
            },
            caption=DASHED_TEXT,
        )
        for quantity, number, ylabel in zip(
            INVARIANTS, (7, 8), (ENERGY_ERROR, MOMENTUM_ERROR), strict=True
        )
    ),
    *(
        _in_h(name, "2.9", "Kepler: one-step error", "V6", how, POSITION_ERROR,
              in_h(study, "one-step error", v06.NS, v06.FLOOR, lambda n: 2.0 * math.ceil(n / 2)))
        for name, how, study in (
            ("fig-2-09", "10 steps", v06.FIXED_NUMBER),
            ("fig-2-09-fixed-time", "fixed final time T = 2", FIXED_TIME),
        )
    ),
    *(
        _in_h(name, "2.10", "Kepler: energy along the curve", "V7", how, ENERGY_ERROR,
              in_h(study, v07.ENERGY, v07.NS, v07.FLOOR, start=start))
        for name, how, study, start in (
            ("fig-2-10", "10 steps", fixed_number(10), SINGULARITY / 10),
            ("fig-2-10-fixed-time", "fixed final time T = 2", FIXED_TIME, 0.0),
        )
    ),
    *(
        _in_h(name, "2.11", "Kepler: angular momentum along the curve", "V7", how,
              MOMENTUM_ERROR,
              in_h(study, v07.ANGULAR, v07.NS, v07.FLOOR, claimed, start=start))
        for name, how, study, claimed, start in (
            ("fig-2-11", "100 steps", fixed_number(100), lambda n: n / 2 + 2, SINGULARITY / 100),
            ("fig-2-11-fixed-time", "fixed final time T = 2", FIXED_TIME, lambda n: None, 0.0),
        )
    ),
    *(
        Figure(
            name=f"fig-2-{number}",
            source=f"H fig. 2.{number}",
            title=f"Kepler: {quantity} in time, n = 8, h = 2, 10000 steps",
            claims=("V8",),
            draw=history,
            options={
                "quantity": quantity,
                "ylabel": f"relative {quantity} [{'eps' if number == 13 else '1'}]",
                "rounding": number == 13,
            },
            caption="At step ends, from (q, p). "
            + ("In units of the machine epsilon. Independent roundings grow like the dashed "
               "line, biased ones like the dotted one."
               if number == 13 else "An error that grows with time leaves the band for good."),
        )
        for quantity, number in (("energy error", 12), ("angular momentum error", 13))
    ),
    Figure(
        name="fig-2-14",
        source="H fig. 2.14",
        title=f"Inner planets from 2000-01-01, {v09.STEPS} steps of {v09.STEP:g} days, n = {v09.N}",
        claims=("V9",),
        draw=paths,
        options={
            "panels": (Panel("", ORBIT, CURVE, ends=ENDS),),
            "bodies": v09.INNER,
        },
        caption="Lines: the Galerkin curves; dots: the ends of the steps, farther apart than a "
        "year of Mercury. Positions relative to the Sun, in the equatorial plane of the ICRF.",
        size=(6.0, 6.0),
    ),
    Figure(
        name="fig-2-15",
        source="H fig. 2.15",
        title=f"Outer planets from 2000-01-01, {v10.STEPS} steps of five years, n = {v10.N}",
        claims=("V10",),
        draw=paths,
        options={
            "panels": (Panel("", ORBIT, CURVE, ends=ENDS),),
            "bodies": v10.OUTER,
        },
        caption="Lines: the Galerkin curves over 500 years; dots: the ends of the steps. Positions "
        "relative to the Sun and the inner planets, merged into one body here, in the equatorial "
        "plane of the ICRF.",
        size=(6.0, 6.0),
    ),
)  # fmt: skip

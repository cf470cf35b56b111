"""V9: the solar system in steps longer than Mercury's year (H figure 2.14)."""

from __future__ import annotations

import pandas as pd

from benchmarks.claims.kit import *
from benchmarks.measures.independent_invariants import energy
from benchmarks.measures.orbit_shape import perihelion, period
from benchmarks.studies.long_steps import (
    ALONG,
    CHANGE,
    DIFFERENCE,
    DISTANCE,
    ENERGY,
    FRAME_DISTANCE,
    SHIFT,
    LongSteps,
    energy_error,
    energy_in_frame,
    worst_relative,
    worst_shape,
)
from references.as_trajectory import as_trajectory
from references.rebound.ias15 import IAS15
from references.stored.planets import STORED_TRUTH

STEP, STEPS = 100.0, 100
N, NS = 25, (21, 29, 33, 37, 41)  # H's n, and others for the rate
SAMPLES = 5000  # of the orbits, every 2 days
INNER = ("Mercury", "Venus", "Earth", "Mars")  # those of H figure 2.14
MERCURY = 1  # its place among the bodies
VISIBLE = 1e-3  # of an orbit's size: 0.1 mm, the width of a line, in a figure 10 cm across
FLOORS = {DISTANCE: 1e-9, ENERGY: 3e-15}  # au, relative
ORACLES = "distance between the two references [au]"
SETUP = (
    "Sun, 8 planets, Pluto; JPL DE421 states of 2000-01-01 (JD 2451544.5 TDB), au and days; "
    f"Polynomials(n - 1), gauss(2 n), n = %s; h = {STEP:g} d, {STEPS} steps"
)

IN_FRAME = (SETUP % N).replace("gauss(2 n)", "gauss(n - 1), KeplerFrame()")


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """Series of `LongSteps`, the inner planets watched and the shapes those of n = 25.

    'distance between the two references [au]'  of Mercury, at ten times
    """
    problem = galvi.problems.solar_system()
    found = LongSteps(problem, STEP, STEPS, (N, *NS), INNER, SAMPLES).study(make_method, report)
    both = [oracle.run(problem, STEP * STEPS, {"samples": 10}) for oracle in (IAS15, STORED_TRUTH)]
    apart = np.linalg.norm(both[0].q[:, MERCURY] - both[1].q[:, MERCURY], axis=-1)
    return pd.concat([found, frame([row(quantity=ORACLES, value=float(np.max(apart)))])])


def mercury_base() -> float:
    """The factor of Mercury's error for each n, from the singularity of its orbit.

    Kepler's orbit is singular where 1 = e cos E: at the complex time i t*, t* = (P / 2 pi)
    (arcosh 1/e - sqrt(1 - e^2)), from the perihelion. With that in the middle of a step, on
    [-1, 1] at i y, y = 2 t* / h, polynomials converge by 1 / rho, rho = y + sqrt(1 + y^2), and step
    ends by its square.
    """
    problem = galvi.problems.solar_system()
    start = as_trajectory(
        problem, "start", np.zeros(1), problem.q0[None], problem.v0[None], counts={}
    )
    e = float(np.linalg.norm(perihelion(start, MERCURY)[0]))
    t = period(problem, MERCURY) / (2.0 * math.pi) * (math.acosh(1.0 / e) - math.sqrt(1.0 - e * e))
    y = 2.0 * t / STEP
    return (y + math.sqrt(1.0 + y * y)) ** -2


def visible_energy(problem: Problem) -> float:
    """The relative error of the total energy that moves Mercury by VISIBLE along its orbit.

    An error dE of Mercury's own energy E_M, kept for all N revolutions, changes its mean motion by
    3/2 dE / E_M and so moves it by 3 pi N dE / E_M mean distances.
    """
    masses, year = problem.system.masses, period(problem, MERCURY)
    gm = float(problem.system.G * (masses[0] + masses[MERCURY]))
    axis = (gm * (year / (2.0 * math.pi)) ** 2) ** (1.0 / 3.0)
    own = 0.5 * gm * masses[MERCURY] / axis
    total = abs(float(energy(problem, problem.q0[None], problem.v0[None])[0]))
    return VISIBLE / (3.0 * math.pi * STEP * STEPS / year) * own / total


def part_left(problem: Problem) -> float:
    """The heaviest planet's mass over the Sun's: what pulls the inner planets, besides the Sun, is
    less than that part of its pull."""
    masses = problem.system.masses
    return float(np.max(masses[1:]) / masses[0])


SEEN = f"A difference of {VISIBLE:g} of an orbit's size is a line's width in H's figure"
LONG_STEP = (
    f"{SEEN}. In a step of 100 days Mercury does more than a revolution; 25 basis functions "
    "resolve it to less than that, and slower planets far better."
)
CLOSED = (
    f"{SEEN}. The radii return to within what the other planets change them, in IAS15's orbits "
    "as in these."
)


def judge(table: pd.DataFrame) -> list[Row]:
    """Distance to IAS15, shape and energy for n = 25, their rates in n, and the Kepler frame."""
    visible = visible_energy(galvi.problems.solar_system())
    return [
        *_orbits(table),
        _row(
            "energy error",
            AtMost(visible),
            energy_error(table, N),
            "An energy error of this size, all of it Mercury's and kept for the whole run, would "
            f"move it along its orbit by {VISIBLE:g} of its size.",
            reference="initial energy",
        ),
        *_rates(table),
        *_in_the_frame(table, visible),
        V9.row(
            f"{ORACLES}, Mercury",
            Finding(AtMost(0.1 * FLOORS[DISTANCE])),
            readings.largest_of(table, quantity=ORACLES),
            setup=SETUP.split("; Poly")[0],
            claimed="no claim: check of the reference",
            reason="At most a tenth of the smallest error that a row rests on.",
        ),
    ]


def _orbits(table: pd.DataFrame) -> list[Row]:
    """Distances of the inner planets to IAS15, and the shapes of their orbits."""
    turned = f"{SEEN}, and an ellipse turned by an angle moves by its eccentricity times the angle."
    closest = "of the inner planets"
    return [
        _row(
            f"largest distance to IAS15 at step ends {closest} [mean distance]",
            AtMost(VISIBLE),
            worst_relative(table, INNER, DISTANCE, f"n = {N}"),
            LONG_STEP,
        ),
        _row(
            f"largest distance to IAS15 on the curve {closest} [mean distance]",
            AtMost(VISIBLE),
            worst_relative(table, INNER, ALONG),
            LONG_STEP,
        ),
        _row(
            "change of the inner orbits' extent, first to last revolution [mean distance]",
            AtMost(VISIBLE),
            worst_shape(table, CHANGE, INNER),
            CLOSED,
        ),
        _row(
            "extent of the inner orbits in the last revolution, against IAS15 [mean distance]",
            AtMost(VISIBLE),
            worst_relative(table, INNER, DIFFERENCE),
            CLOSED,
        ),
        _row(
            "turn of the inner ellipses at the end, against IAS15 [rad], times the eccentricity",
            AtMost(VISIBLE),
            worst_shape(table, SHIFT, INNER),
            turned,
            claimed='almost none of the "precession" effects of symplectic integrators',
        ),
    ]


def _rates(table: pd.DataFrame) -> list[Row]:
    """Bases of the errors in n."""
    base = mercury_base()
    rate = (
        f"Mercury's motion is singular near the real axis: {base:.3f}^n at step ends when the "
        "perihelion is in the middle of a step, times a power of n of at most 1, which at n = 30 "
        "changes the base by its thirtieth part."
    )
    return [
        V9.row(
            f"base of {words}",
            Finding(Base(base, resolution=base / 30.0)),
            readings.base(table, FLOORS[quantity], quantity=quantity, **of),
            setup=SETUP % f"{min(NS)} to {max(NS)}",
            claimed="none for this figure; H thm. 2.3.4: O(K^n)",
            reason=rate,
            **own,
        )
        for words, quantity, of, own in (
            ("Mercury's largest distance to IAS15", DISTANCE, {"label": "Mercury"}, {}),
            ("the energy error", ENERGY, {}, {"reference": "initial energy"}),
        )
    ]


def _in_the_frame(table: pd.DataFrame, visible: float) -> list[Row]:
    """Distances and energy in the Kepler frame, where an energy error of `visible` would show."""
    left = part_left(galvi.problems.solar_system())
    in_frame = (
        "The frame does Kepler's orbits exactly; a step of 1.14 revolutions of Mercury is within "
        "its limit of 1.27. What it leaves to collocation, the planets' pull, is less than "
        f"{left:.1e} of the Sun's, and so must be its error of what as many points may err by "
        "without the frame: "
    )
    return [
        V9.row(
            "largest distance to IAS15 at step ends of the inner planets, in the Kepler frame "
            "[mean distance]",
            Finding(AtMost(left * VISIBLE)),
            worst_relative(table, INNER, FRAME_DISTANCE, "frame"),
            setup=IN_FRAME,
            claimed="none: galvi's own frame",
            reason=f"{in_frame}{VISIBLE:g} of the orbit's size.",
        ),
        V9.row(
            "energy error in the Kepler frame",
            Finding(AtMost(left * visible)),
            energy_in_frame(table),
            setup=IN_FRAME,
            claimed="none: galvi's own frame",
            reason=f"{in_frame}an energy that moves Mercury by {VISIBLE:g} of its orbit's size.",
            reference="initial energy",
        ),
    ]


def _row(quantity: str, bound: Bound, measured: Measurement, reason: str, **own: str) -> Row:
    return V9.row(f"{quantity}, n = {N}", bound, measured, setup=SETUP % N, reason=reason, **own)


V9 = Claim(
    "V9",
    "Solar system at h = 100 d: closed, stable orbits beyond Mercury's period",
    study,
    judge,
    ("H fig. 2.14",),
    claimed="closed, stable orbits although h exceeds Mercury's period",
    reference=f"{IAS15.name}; heyoka in quadruple precision, stored, agrees to 6e-13 au",
    statement="H fig. 2.14: orbits are closed and stable although the step exceeds Mercury's "
    "period.",
    caught=(
        OTHER_TRUTH,
        of_table("base of Mercury's largest distance to IAS15", beta=1.0 + 1e-6),
        of_table("energy error, n = 25", b=1.0 + 1e-3),
        of_motion("clock reversed", bool, reversed_clock),
        of_motion("Sun heavier", bool, heavier),
    ),
)

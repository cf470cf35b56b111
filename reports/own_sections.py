"""The studies with sections of their own: round-off, and the number of bodies."""

from __future__ import annotations

from benchmarks import long_brouwer
from benchmarks.brouwer import brouwer
from benchmarks.scaling import scaling
from reports.brouwer_table import brouwer_table
from reports.figures.energy_growth import energy_growth
from reports.figures.figure import Figure
from reports.figures.scaling import seconds_per_orbit, share_of_limit
from reports.scaling_table import scaling_table
from reports.study import Study

ROUND_OFF = Study(
    name="brouwer",
    title="Round-off",
    text="The outer solar system from 32 starts that differ by 1e-12 (8 in the quick setting). "
    "Unbiased rounding moves the energy at random: its RMS over the runs grows as t^(1/2), and its "
    "mean does not drift. Exponents are fitted over the later two decades of time, with the "
    "standard error over ensembles drawn anew from the same runs; a drift is what the scatter of "
    "the runs would give less than once in 10000 times. Energies are computed with 32 digits, "
    "galvi's with what the rounding of its state lost, which it keeps; REBOUND hands out rounded "
    "states, and times at which that rounding hides its error are left out of its fit.",
    measure=brouwer,
    figures=(
        Figure(
            name="brouwer",
            title="Energy error of long runs",
            draw=energy_growth,
            caption="RMS over the runs; faint, the size of each run's error. Blue: galvi.",
            size=(6.0, 4.4),
        ),
    ),
    table=brouwer_table,
    parts=long_brouwer.parts,
    stored=long_brouwer.stored,
)

NUMBER_OF_BODIES = Study(
    name="scaling",
    title="Number of bodies",
    text="A Sun and light planets on orbits that are each a tenth wider than the last. Each "
    "contender runs at several settings; compared are the fastest whose worst body is within 1e-8 "
    "au of the truth after 30 orbits of the innermost planet (12 in the quick setting). P is that "
    "planet's period. The truth is REBOUND IAS15 at its default, against which its own looser "
    "settings are judged too. The limit is what a kernel that only divides and takes square roots "
    "reaches, in the same vector instructions and the same run; a pair needs one of each.",
    measure=scaling,
    figures=(
        Figure(
            name="scaling",
            title="Cost against the number of bodies",
            draw=seconds_per_orbit,
            caption="Medians, with the fastest and the slowest round, at matched error. "
            "Blue: galvi; dashed: peers.",
        ),
        Figure(
            name="scaling-share",
            title="Share of the machine's limit",
            draw=share_of_limit,
            caption="Pairs of bodies that galvi evaluates in a second, over those whose divisions "
            "and square roots this machine could do.",
            size=(6.4, 3.2),
        ),
    ),
    table=scaling_table,
)

STUDIES = (ROUND_OFF, NUMBER_OF_BODIES)

"""The studies with sections of their own: round-off, many bodies, free spin, MuJoCo, a million
steps.
"""

from __future__ import annotations

from benchmarks.studies import (
    engine_versions,
    free_body_drift,
    free_body_drift_long,
    round_off_long,
    so3_drift,
    taxonomy,
)
from benchmarks.studies.round_off import brouwer
from benchmarks.studies.scaling import scaling
from reports.figures.figure import Figure
from reports.figures.plots.energy_growth import energy_growth
from reports.figures.plots.free_body_drift import free_spin as errors_over_turns
from reports.figures.plots.scaling import seconds_per_orbit, share_of_limit
from reports.figures.plots.so3_drift import turning_growth
from reports.figures.plots.taxonomy_matrix import taxonomy_matrix
from reports.results.study import Study
from reports.tables.engine_versions_table import engine_versions_table
from reports.tables.free_body_drift_table import free_spin_table
from reports.tables.round_off_table import brouwer_table
from reports.tables.scaling_table import scaling_table
from reports.tables.so3_drift_table import turning_table
from reports.tables.taxonomy_table import taxonomy_table

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
    parts=round_off_long.parts,
    stored=round_off_long.stored,
    open=True,
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
            caption="Pairs of bodies that are evaluated in a second, by whom counts them, over "
            "those whose divisions and square roots this machine could do.",
            size=(6.4, 3.2),
        ),
    ),
    table=scaling_table,
    open=True,
)

FREE_SPIN = Study(
    name="free-spin",
    title="Energy and angular momentum of long spins",
    text="H's free body over 1000 turns, a hundred in the quick setting and 100,000 in the long "
    "form, a turn being what the first angular velocity takes for one; MuJoCo in steps of 0.01. "
    "And the free box of MuJoCo's own tests: 500 steps of 0.01 from an angular velocity of (1, 2, "
    "3). MuJoCo's implicitfast and discrete turn a body otherwise on a ball joint than on a free "
    "one, where they are damped as implicit is. Energy errors are E / E0 - 1 with their sign, "
    "those of momentum the length of the change in space; both are the largest since the mark "
    "before (turns 1, 2, 5, 10 and so on). Attitudes are compared with the closed form at the end.",
    measure=free_body_drift.free_spin,
    figures=(
        Figure(
            name="free-spin",
            title="Free rigid body: energy and angular momentum over many turns",
            draw=errors_over_turns,
            options={"problem": "free rigid body"},
            caption="Blue: galvi, dash-dotted in the exponential chart; dashed: peers, MuJoCo on a "
            "free joint, where some of its lines lie upon each other. A cross: the run failed "
            "after it.",
            size=(9.6, 4.2),
        ),
    ),
    table=free_spin_table,
    parts=free_body_drift_long.parts,
    stored=free_body_drift_long.stored,
    open=True,
)

ENGINE_VERSIONS = Study(
    name="engine-versions",
    title="Versions of MuJoCo",
    text="How MuJoCo turns a free body depends on its version. H's free body for 10 units of time, "
    "on a ball joint and, drifting, on a free one, by every integrator that a version offers: the "
    "order of the attitude, fitted over steps from 0.1 to 0.0004, and, at a step of 0.0125, the "
    "largest error of the attitude matrix, against the closed form, and of the energy, relative to "
    "its start. The energy does not tell how good the attitude is.",
    measure=engine_versions.engine_versions,
    figures=(),
    table=engine_versions_table,
    parts=engine_versions.parts,
    stored=engine_versions.stored,
)

A_MILLION_STEPS = Study(
    name="turning",
    title="A million steps on SO(3)",
    text="H's free body from 8 starts that differ by 1e-12 (4 in the quick setting). Its exact "
    "motion keeps R a rotation and R mu constant; rounding may move them like the square root "
    "of the steps. The first two methods, with as many stages as their degree, run in the "
    "packed kernel. It carries a quaternion, divided by its length wherever it becomes R, and "
    "the momentum in space, which a free body's step leaves alone, both with what rounding "
    "takes from them: R and R mu stay by construction, and the energy is the test. The third "
    "method runs in the general kernel, which carries R and the momentum in space without what "
    "rounding takes, and after each step brings R back by R <- R (3 I - R^T R) / 2. Exponents "
    "of the RMS over the runs are fitted over the later two decades, and compared with 1/2 by "
    "three standard errors; the long form has a hundred times the steps.",
    measure=so3_drift.turning,
    figures=(
        Figure(
            name="turning",
            title="Rotations, momenta and energies of long runs",
            draw=turning_growth,
            caption="RMS over the runs. Dashed: growth like the square root of the steps.",
            size=(9.6, 3.4),
        ),
    ),
    table=turning_table,
    parts=so3_drift.parts,
    stored=so3_drift.stored,
    open=True,
)

TAXONOMY = Study(
    name="taxonomy",
    title="Spaces and rules",
    text="Every space with every rule, and what comes of it. A pair is ill-posed when a free "
    "particle has no unique motion, because the rule does not see some function of the space, and "
    "inconsistent when its unique motion is not a straight line. The picture has every pair. The "
    "table has polynomials with every family of rules and the other spaces with Gauss's; all pairs "
    "with all their numbers are in taxonomy.csv. Read a line from left to right: with "
    "too few points there is no method, then the rule limits the order, and from some number of "
    "points on the order is twice the largest degree of the polynomials in the space, and stays. "
    "Slopes that jump between "
    "pieces want rules without a node there; waves, of frequency ω in radians a step, want many "
    "points and leave the order as it is. Orders are measured on the Kepler problem, e = 0.3, "
    "against its closed form; C_N is the constant of M (11); symplectic to is the largest defect "
    "of DF^T J DF = J, and there and back what is left after eight steps of 0.25 forwards and as "
    "many backwards, which is round-off for a symmetric method.",
    measure=taxonomy.taxonomy,
    figures=(
        Figure(
            name="taxonomy",
            title="Measured order of the method that a space and a rule make",
            draw=taxonomy_matrix,
            caption="Below the order, methods that are known by a name: IM implicit midpoint, SV "
            "Stormer-Verlet, SE symplectic Euler, G Gauss collocation, L Lobatto IIIA-IIIB, R "
            "Radau IIA-II; 3IM, 3G: three steps of it in one.",
            size=(11.0, 5.8),
        ),
    ),
    table=taxonomy_table,
)

STUDIES = (ROUND_OFF, NUMBER_OF_BODIES, FREE_SPIN, ENGINE_VERSIONS, A_MILLION_STEPS, TAXONOMY)

"""The figures of L6 to L9, L14 and L15: 3.5 to 3.9 of H, other charts and groups, curves."""

from __future__ import annotations

import math

from benchmarks.claims.lie_groups import l06_pendulum_convergence_in_n as l06
from benchmarks.claims.lie_groups import l07_pendulum_order as l07
from benchmarks.claims.lie_groups import l08_pendulum_energy as l08
from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.lie_groups import l14_other_charts_and_groups as l14
from benchmarks.claims.lie_groups import l15_curves_between_ends as l15
from benchmarks.claims.lie_groups import pendulum_motion, steps_near_the_limit
from galvi.charts import CHARTS
from reports.figures.plots.convergence import Rate, convergence_in_h, convergence_in_n
from reports.figures.plots.energies import history
from reports.figures.plots.jumps import jumps
from reports.figures.plots.limits import limits
from reports.figures.plots.paths import sphere
from reports.results.section import Figure

SOLID = "Solid line: fit over the filled points; hollow points: pre-asymptotic or round-off"
DASHED = f"{SOLID}; dashed, offset upwards: the claimed rate."
ATTITUDE = "largest error of the attitude [1]"


def _orders(study: str, quantity: str, ns: tuple[int, ...], floor: float) -> tuple[Rate, ...]:
    return tuple(Rate(study, quantity, f"$n={n}$", floor, n=n) for n in ns)


PENDULUM_FIGURES: tuple[Figure, ...] = (
    Figure(
        name="fig-3-05",
        source="H fig. 3.5",
        title="3D pendulum, h = 0.5, T = 5",
        claims=("L6",),
        draw=convergence_in_n,
        options={
            "rates": tuple(
                Rate("n-refinement", quantity, label, pendulum_motion.FLOOR, start=l06.FROM)
                for quantity, label in (("one-step error", "one-step"), ("curve error", "curve"))
            ),
            "ylabel": ATTITUDE,
        },
        caption=f"{SOLID}. Step ends have about the square of the curve's error. H sees one error "
        "for both, as it is for small n in runs a hundred times as long.",
    ),
    Figure(
        name="fig-3-06",
        source="H fig. 3.6",
        title="3D pendulum: one-step error, fixed final time T = 5",
        claims=("L7",),
        draw=convergence_in_h,
        options={
            "rates": tuple(
                Rate(l07.FIXED_TIME, "one-step error", f"$n={n}$", l07.FLOOR, claimed=float(n), n=n)
                for n in l07.NS
            ),
            "ylabel": ATTITUDE,
        },
        caption=DASHED,
        size=(6.4, 4.4),
    ),
    Figure(
        name="fig-3-07",
        source="H fig. 3.7",
        title=f"3D pendulum: energy error in time, n = {l08.N}, h = {l08.STEP:g}, "
        f"{l08.STEPS} steps",
        claims=("L8",),
        draw=history,
        options={
            "quantity": l08.QUANTITY,
            "ylabel": "relative energy error [1]",
            "xlabel": "time $t$",
        },
        caption="At step ends. An error that grows with time leaves the band.",
    ),
    Figure(
        name="fig-3-08",
        source="H fig. 3.8",
        title=f"3D pendulum from upside down, n = {l09.N}, h = {l09.STEP:g}",
        claims=("L9",),
        draw=sphere,
        options={
            "panels": {
                l09.named(l09.DRAWN, "Cayley"): f"$m g = {l09.DRAWN:g}$, Cayley chart",
                l09.named(l09.HEAVY, "exponential"): "$m g = 29.43$, exponential chart",
            },
            "curve": l09.CURVE,
            "ends": l09.ENDS,
        },
        caption=f"The centre of mass over the first {l09.SHOWN} steps, from the top (orange); "
        "dots: the ends of the steps, lines: the Galerkin curves between them. H gives no m g: "
        "with 22 some steps are almost through an angle of pi, as H's are; the heavier body's "
        "exceed it.",
        size=(9.0, 4.6),
    ),
    Figure(
        name="fig-3-09",
        source="H fig. 3.9",
        title=f"3D pendulum from upside down: energy, n = {l09.N}, h = {l09.STEP:g}",
        claims=("L9",),
        draw=jumps,
        options={
            "quantity": l09.ENERGY,
            "runs": {
                l09.named(l09.DRAWN, "Cayley"): f"$m g = {l09.DRAWN:g}$,\nCayley",
                l09.named(l09.HEAVY, "exponential"): "$m g = 29.43$,\nexponential",
                l09.named(l09.HEAVY, "Cayley"): "$m g = 29.43$,\nCayley",
            },
            "steps": {
                steps_near_the_limit.one_step(chart.name): f"{chart.name} chart"
                for chart in reversed(CHARTS)
            },
            "turn": steps_near_the_limit.TURN,
            "change": steps_near_the_limit.CHANGE,
            "limit": (math.pi, "limit of the Cayley chart"),
        },
        caption="First, runs for two weights m g; a cross marks an early end. Second, single steps "
        "from states of DOP853 runs with m g from 20 to 30; in the Cayley chart the energy jumps "
        "the more the nearer a step is to a rotation by pi (dashed), in the other charts it does "
        "not. Steps that were not solved are omitted; changes of 0 are drawn at 1e-17.",
        size=(9.6, 3.8),
    ),
    *(
        Figure(
            name=name,
            source="H 3.6.1",
            title=f"one-step error, {motion}, {chart.name} chart",
            claims=("L14",),
            draw=convergence_in_h,
            options={
                "rates": _orders(
                    f"{motion}, {chart.name} chart", l14.QUANTITY, l14.NS[motion][chart], l14.FLOOR
                ),
                "ylabel": "largest error of $q$ [1]",
            },
            caption=f"T = {l14.DURATION:g}. {SOLID}.",
        )
        for name, motion, chart in (
            ("exponential-chart", "3D pendulum", l14.EXPONENTIAL),
            ("modified-rodrigues-chart", "3D pendulum", l14.RODRIGUES),
            ("se3", "SE(3)", l14.EXPONENTIAL),
            ("se2", "SE(2)", l14.EXPONENTIAL),
            ("product-group", "SO(3) x SO(3)", l14.EXPONENTIAL),
        )
    ),
    Figure(
        name="chart-limits",
        source="H 3.6.1",
        title="limits of the charts",
        claims=("L14",),
        draw=limits,
        options={
            "quantity": l14.TURNED,
            "charts": {
                chart.name: (chart.limit, "$\\pi$" if chart.limit < 4.0 else "$2 \\pi$")
                for chart in CHARTS
            },
        },
        caption=f"One step of a body in steady rotation, n = {l14.SPIN}; crosses above: the "
        "run failed; errors of 0 are drawn at 1e-17. Vertical lines: the limits.",
    ),
    Figure(
        name="curve-between-same-ends",
        source="H thm. 3.3.3",
        title=f"one step of the 3D pendulum, h = {l15.STEP:g}",
        claims=("L15",),
        draw=convergence_in_n,
        options={
            "rates": (
                Rate(l15.IN_N, l15.ENDS, "end", l15.FLOOR[l15.ENDS], power=l15.POWER),
                Rate(l15.IN_N, l15.CURVE, "curve", l15.FLOOR[l15.CURVE], power=l15.POWER),
            ),
            "ylabel": "error at the end, distance of the curve",
        },
        caption=f"{SOLID}. The curve against the exact motion between the same attitudes.",
    ),
    Figure(
        name="curve-between-same-ends-h",
        source="H thm. 3.3.4",
        title="one step of the 3D pendulum: distance of the curve",
        claims=("L15",),
        draw=convergence_in_h,
        options={
            "rates": _orders(l15.IN_H, l15.CURVE, l15.NS, l15.FLOOR[l15.CURVE]),
            "ylabel": "distance in $W^{1,1}$",
        },
        caption=f"{SOLID}. Against the exact motion between the same attitudes.",
    ),
)

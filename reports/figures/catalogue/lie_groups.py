"""The figures of L1 to L9, L14 and L15: 1.2 and chapter 3 of H, other charts and groups, curves."""

from __future__ import annotations

import math

from benchmarks.claims.lie_groups import l01_methods_without_a_group as l01
from benchmarks.claims.lie_groups import l02_free_body_convergence_in_n as l02
from benchmarks.claims.lie_groups import l03_free_body_order as l03
from benchmarks.claims.lie_groups import l04_free_body_energy as l04
from benchmarks.claims.lie_groups import l06_pendulum_convergence_in_n as l06
from benchmarks.claims.lie_groups import l07_pendulum_order as l07
from benchmarks.claims.lie_groups import l08_pendulum_energy as l08
from benchmarks.claims.lie_groups import l09_pendulum_near_chart_limit as l09
from benchmarks.claims.lie_groups import l14_other_charts_and_groups as l14
from benchmarks.claims.lie_groups import l15_curves_between_ends as l15
from benchmarks.claims.lie_groups import pendulum_motion, steps_near_the_limit
from benchmarks.claims.lie_groups.free_body import FLOOR
from galvi.charts import CHARTS
from galvi.problems.rigid_bodies import INERTIA
from reports.figures.plots.convergence import Rate, convergence, in_h
from reports.figures.plots.lines import departures, history, jumps, limits
from reports.figures.plots.spheres import Sphere, momentum_spheres, pendulum_spheres
from reports.figures.style.identities import COLOURS
from reports.results.section import Figure

POINTS_TEXT = "Solid line: fit over the filled points; hollow points: pre-asymptotic or round-off"
ATTITUDE_ERROR = "largest error of an entry of $R$ [1]"
LABELS = {
    l01.EULER: "explicit Euler, $h=0.01$",
    l01.ODE45: "RK45 (ode45) on matrices",
    l01.GALERKIN: f"galvi, $n={l01.N}$, $h=0.5$",
}

POLE_BASES = {"Cayley": "0.156", "modified Rodrigues": "0.066"}  # see L2
LONGEST_RUN = max(l01.MOMENTUM, key=lambda label: l01.MOMENTUM[label])

DASHED_TEXT = f"{POINTS_TEXT}; dashed, offset upwards: the claimed rate."
COLOUR_OF_CHART = {  # those of the runs beside them; the last is drawn in front
    "modified Rodrigues": COLOURS[3],
    "exponential": COLOURS[1],
    "Cayley": COLOURS[0],
}
PENDULUM_ERROR = "largest error of the attitude [1]"

LIE_GROUPS: tuple[Figure, ...] = (
    Figure(
        name="fig-1-02",
        source="H fig. 1.2",
        title="Free rigid body: body momentum by methods on R^n, and by one on the group",
        claims=("L1",),
        draw=momentum_spheres,
        options={
            "panels": (
                Sphere("explicit Euler, h = 0.01", l01.EULER, lines=True),
                Sphere("RK45 (ode45), y' = y x w alone", LONGEST_RUN, lines=True),
                Sphere(f"galvi, n = {l01.N}, h = 0.5", l01.GALERKIN),
            ),
            "inertia": INERTIA,
        },
        caption="Momenta divided by their initial length, to t = 100, in the second panel to "
        "1000. Grey: the exact curve, from which explicit Euler spirals outwards and RK45 "
        "drifts, by 0.03 of the radius. Solved together with the matrix, in shorter steps, RK45's "
        "momentum leaves the sphere by a millionth, which only the next figure shows.",
        size=(9.6, 3.5),
    ),
    Figure(
        name="fig-1-02-departures",
        source="H fig. 1.2",
        title="Free rigid body: departure from the momentum sphere and from SO(3)",
        claims=("L1",),
        draw=departures,
        options={"quantities": (l01.SPHERE, l01.GROUP), "labels": LABELS},
        caption="First | |y| / |y(0)| - 1 |, then the largest entry of |R^T R - I|.",
        size=(9.6, 3.6),
    ),
    *(
        Figure(
            name="fig-3-01" if chart == "Cayley" else f"fig-3-01-{chart.replace(' ', '-').lower()}",
            source="H fig. 3.1",
            title=f"Free rigid body, h = 0.5, T = 5, {chart} chart",
            claims=("L2",),
            draw=convergence,
            options={
                "rates": (
                    Rate(f"n-refinement, {chart}", l02.ENDS, "one-step", FLOOR),
                    Rate(f"n-refinement, {chart}", l02.CURVE, "curve", FLOOR, start=start),
                ),
                "ylabel": ATTITUDE_ERROR,
            },
            caption=f"{POINTS_TEXT}. The curve's own rate is half that of the step ends"
            + (f": its pole gives {POLE_BASES[chart]}^n." if chart in POLE_BASES else "."),
            size=(6.4, 4.4),
        )
        for chart, start in l02.FROM.items()
    ),
    Figure(
        name="fig-3-02",
        source="H fig. 3.2",
        title="Free rigid body: one-step error, T = 5, Cayley chart",
        claims=("L3",),
        draw=convergence,
        options={
            "rates": in_h("n", l03.ERROR, l03.NS, l03.FLOOR, lambda n: 2 * (n // 2)),
            "ylabel": ATTITUDE_ERROR,
        },
        caption=f"{POINTS_TEXT}; dashed, offset upwards: the claimed rate. H reports the optimal "
        "rate "
        "for even n, which we read as n, and n - 1 for odd.",
        size=(6.4, 4.4),
    ),
    Figure(
        name="fig-3-02-pendulum",
        source="H fig. 3.2",
        title=f"3D pendulum, m g = {l03.WEIGHT:g}: error at T = 5, Cayley chart",
        claims=("L3",),
        draw=convergence,
        options={
            "rates": in_h(l03.PENDULUM, l03.ERROR, l03.NS, l03.END_FLOOR),
            "ylabel": ATTITUDE_ERROR,
        },
        caption=f"{POINTS_TEXT}. Small rotations, whose errors show order 2 (n - 1) above "
        "round-off.",
        size=(6.4, 4.4),
    ),
    *(
        Figure(
            name="fig-3-03" if n == l04.N else f"fig-3-03-n-{n}",
            source="H fig. 3.3",
            title=f"Free rigid body: energy error in time, n = {n}, h = 0.5, {l04.STEPS} steps",
            claims=("L4",),
            draw=history,
            options={
                "quantity": quantity,
                "ylabel": f"relative energy error [{'eps' if n == l04.N else '1'}]",
                "xlabel": "time $t$",
                "rounding": n == l04.N,
            },
            caption="At every second step end, from (R, p). "
            + (
                "In units of the machine epsilon, below which the truncation error is. Independent "
                "roundings grow like the dashed line, biased ones like the dotted one: the checks "
                "say which."
                if n == l04.N
                else "An error that grows leaves the band; this is the truncation error."
            ),
        )
        for n, quantity in l04.QUANTITIES.items()
    ),
    Figure(
        name="fig-3-04",
        source="H fig. 3.4",
        title="Free rigid body: body momenta from 12 starts, n = 8, h = 0.5, 800 steps",
        claims=("L5",),
        draw=momentum_spheres,
        options={
            "panels": (
                Sphere("12 starts on the sphere", "sphere"),
                Sphere("sphere and ellipsoid of one energy", "sphere", ellipsoid="2"),
            ),
            "inertia": INERTIA,
        },
        caption="Dots: momenta at every eighth step end; lines: the exact intersections of the "
        "momentum sphere with the energy ellipsoids, which come in pairs. Second: the sphere "
        "(blue), one ellipsoid (yellow), each where it is outermost, and the momenta of its "
        "energy.",
        size=(9.6, 4.8),
    ),
    Figure(
        name="fig-3-05",
        source="H fig. 3.5",
        title="3D pendulum, h = 0.5, T = 5",
        claims=("L6",),
        draw=convergence,
        options={
            "rates": tuple(
                Rate("n-refinement", quantity, label, pendulum_motion.FLOOR, start=l06.FROM)
                for quantity, label in (("one-step error", "one-step"), ("curve error", "curve"))
            ),
            "ylabel": PENDULUM_ERROR,
        },
        caption=f"{POINTS_TEXT}. Step ends have about the square of the curve's error. H sees one "
        "error "
        "for both, as it is for small n in runs a hundred times as long.",
    ),
    Figure(
        name="fig-3-06",
        source="H fig. 3.6",
        title="3D pendulum: one-step error, fixed final time T = 5",
        claims=("L7",),
        draw=convergence,
        options={
            "rates": in_h(l07.FIXED_TIME, "one-step error", l07.NS, l07.FLOOR, float),
            "ylabel": PENDULUM_ERROR,
        },
        caption=DASHED_TEXT,
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
        draw=pendulum_spheres,
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
                l09.named(l09.HEAVY, "Cayley"): "$m g = 29.43$, Cayley",
                l09.named(l09.HEAVY, "exponential"): "$m g = 29.43$, exponential",
                l09.named(l09.DRAWN, "Cayley"): f"$m g = {l09.DRAWN:g}$, Cayley",
            },
            "steps": {
                steps_near_the_limit.one_step(chart): (f"{chart} chart", color)
                for chart, color in COLOUR_OF_CHART.items()
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
            draw=convergence,
            options={
                "rates": in_h(
                    f"{motion}, {chart.name} chart", l14.QUANTITY, l14.NS[motion][chart], l14.FLOOR
                ),
                "ylabel": "largest error of $q$ [1]",
            },
            caption=f"T = {l14.DURATION:g}. {POINTS_TEXT}.",
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
        caption=f"One step of a body in steady rotation, n = {l14.ROTATION_N}; crosses above: the "
        "run failed; errors of 0 are drawn at 1e-17. Vertical lines: the limits.",
    ),
    Figure(
        name="curve-between-same-ends",
        source="H thm. 3.3.3",
        title=f"one step of the 3D pendulum, h = {l15.STEP:g}",
        claims=("L15",),
        draw=convergence,
        options={
            "rates": (
                Rate(l15.IN_N, l15.ENDS, "end", l15.FLOOR[l15.ENDS], power=l15.POWER),
                Rate(l15.IN_N, l15.CURVE, "curve", l15.FLOOR[l15.CURVE], power=l15.POWER),
            ),
            "ylabel": "error at the end, distance of the curve",
        },
        caption=f"{POINTS_TEXT}. The curve against the exact motion between the same attitudes.",
    ),
    Figure(
        name="curve-between-same-ends-h",
        source="H thm. 3.3.4",
        title="one step of the 3D pendulum: distance of the curve",
        claims=("L15",),
        draw=convergence,
        options={
            "rates": in_h(l15.IN_H, l15.CURVE, l15.NS, l15.FLOOR[l15.CURVE]),
            "ylabel": "distance in $W^{1,1}$",
        },
        caption=f"{POINTS_TEXT}. Against the exact motion between the same attitudes.",
    ),
)

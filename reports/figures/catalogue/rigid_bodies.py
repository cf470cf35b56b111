"""The figures of L1 to L5: 1.2 and 3.1 to 3.4 of H, each as data."""

from __future__ import annotations

from benchmarks.claims.lie_groups import l01_methods_without_a_group as l01
from benchmarks.claims.lie_groups import l02_free_body_convergence_in_n as l02
from benchmarks.claims.lie_groups import l03_free_body_order as l03
from benchmarks.claims.lie_groups import l04_free_body_energy as l04
from benchmarks.claims.lie_groups.free_body import FLOOR
from galvi.problems.rigid_bodies import INERTIA
from reports.figures.plots.convergence import Rate, convergence_in_h, convergence_in_n
from reports.figures.plots.energies import departures, history
from reports.figures.plots.momentum_spheres import Sphere, momentum_spheres
from reports.results.section import Figure

POINTS = "Solid line: fit over the filled points; hollow points: pre-asymptotic or round-off"
ATTITUDE = "largest error of an entry of $R$ [1]"
LABELS = {
    l01.EULER: "explicit Euler,\n$h=0.01$",
    l01.ODE45: "RK45 (ode45)\non matrices",
    l01.GALERKIN: f"galvi, $n={l01.N}$,\n$h=0.5$",
}

POLES = {"Cayley": "0.156", "modified Rodrigues": "0.066"}  # see L2
LONGEST = max(l01.MOMENTUM, key=lambda label: l01.MOMENTUM[label])

RIGID_BODIES: tuple[Figure, ...] = (
    Figure(
        name="fig-1-02",
        source="H fig. 1.2",
        title="Free rigid body: body momentum by methods on R^n, and by one on the group",
        claims=("L1",),
        draw=momentum_spheres,
        options={
            "panels": (
                Sphere("explicit Euler, h = 0.01", l01.EULER, lines=True),
                Sphere("RK45 (ode45), y' = y x w alone", LONGEST, lines=True),
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
            draw=convergence_in_n,
            options={
                "rates": (
                    Rate(f"n-refinement, {chart}", l02.ENDS, "one-step", FLOOR),
                    Rate(f"n-refinement, {chart}", l02.CURVE, "curve", FLOOR, start=start),
                ),
                "ylabel": ATTITUDE,
            },
            caption=f"{POINTS}. The curve's own rate is half that of the step ends"
            + (f": its pole gives {POLES[chart]}^n." if chart in POLES else "."),
            size=(6.4, 4.4),
        )
        for chart, start in l02.FROM.items()
    ),
    Figure(
        name="fig-3-02",
        source="H fig. 3.2",
        title="Free rigid body: one-step error, T = 5, Cayley chart",
        claims=("L3",),
        draw=convergence_in_h,
        options={
            "rates": tuple(
                Rate("n", l03.ERROR, f"$n={n}$", l03.FLOOR, claimed=2 * (n // 2), n=n)
                for n in l03.NS
            ),
            "ylabel": ATTITUDE,
        },
        caption=f"{POINTS}; dashed, offset upwards: the claimed rate. H reports the optimal rate "
        "for even n, which we read as n, and n - 1 for odd.",
        size=(6.4, 4.4),
    ),
    Figure(
        name="fig-3-02-pendulum",
        source="H fig. 3.2",
        title=f"3D pendulum, m g = {l03.WEIGHT:g}: error at T = 5, Cayley chart",
        claims=("L3",),
        draw=convergence_in_h,
        options={
            "rates": tuple(
                Rate(l03.PENDULUM, l03.ERROR, f"$n={n}$", l03.END_FLOOR, n=n)
                for n in l03.NS
            ),
            "ylabel": ATTITUDE,
        },
        caption=f"{POINTS}. Small rotations, whose errors show order 2 (n - 1) above round-off.",
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
            + ("In units of the machine epsilon, below which the truncation error is. Independent "
               "roundings grow like the dashed line, biased ones like the dotted one: the checks "
               "say which."
               if n == l04.N else
               "An error that grows leaves the band; this is the truncation error."),
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
)  # fmt: skip

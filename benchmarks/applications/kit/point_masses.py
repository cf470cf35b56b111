"""Twenty problems of point masses, where their starts come from, and two sources of their truth."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.judging.bodies import shifted
from benchmarks.applications.kit.orders import Convergence, Method, convergence
from benchmarks.applications.kit.truths import (
    SHIFT,
    Source,
    States,
    Truth,
    agreed_truth,
    restarted,
    sampled,
)
from benchmarks.test_problems.planets import PAIR, innermost_period, many_planets
from galvi import Canonical, CentralForce, NBody, Problem, problems
from galvi.arrays import Array
from references.closed_forms.kepler import KEPLER
from references.rebound.ias15 import IAS15
from references.rebound.leapfrog import LEAPFROG
from references.rebound.saba import SABA
from references.rebound.whfast import WHFAST
from references.scipy.ivp import DOP853, TIGHT
from references.stored.planets import CASES, STORED_TRUTH
from references.textbook.euler import STORMER_VERLET
from references.textbook.fourth_order import FOREST_RUTH, RK4

WRITTEN_FOR_GALVI = "written for galvi"
CLOSED = sampled(KEPLER, "Kepler's equation in closed form, in double-double arithmetic")
STORED = sampled(STORED_TRUTH, "heyoka's Taylor series in quadruple precision, stored with galvi")
GAUSS_RADAU = sampled(IAS15, "REBOUND IAS15")
RUNGE_KUTTA = restarted(DOP853, "SciPy DOP853, relative tolerance 3e-14", TIGHT)
CLOSED_PAIR, STORED_PAIR, NUMERICAL_PAIR = (
    (CLOSED, GAUSS_RADAU),
    (STORED, GAUSS_RADAU),
    (GAUSS_RADAU, RUNGE_KUTTA),
)

INTEGRATORS: Mapping[str, tuple[Method, ...]] = {  # each of a tuple must have the order
    "leapfrog": (Method(STORMER_VERLET, {}), Method(LEAPFROG, {})),
    "forest_ruth": (Method(FOREST_RUTH, {}), Method(LEAPFROG, {"order": 4})),
    "rk4": (Method(RK4, {}),),
    "whfast": (Method(WHFAST, {}),),
    "saba_10_6_4": (Method(SABA, {"type": "10_6_4"}),),
}
ADAPTIVE = ("ias15",)  # integrators that choose their steps
DE421 = (
    "JPL DE421 at JD 2451544.5 TDB (Folkner, Williams and Boggs 2009, IPN Progress Report 42-178), "
    "read through the package de421: barycentric, ICRF axes"
)
TILT, NODE = 0.4, 0.7  # of the plane of two bodies, in rad
TRIANGLE_MASSES = (1.0, 2.0, 3.0)
TRIANGLE_SPEED = 0.9  # over the speed on circles
MOON_MASS = 0.012277471
ARENSTORF_PERIOD = 17.0652165601579625588917206249
ARENSTORF_START = (0.994, -2.00158510637908252240537862224)  # x and dy/dt in the turning frame


@dataclass(frozen=True, eq=False)
class PointMasses:
    """A problem of the kit.

    Attributes
    ----------
    name
        name of its files, without suffix
    problem
        a problem of point masses in the plane or in space
    duration
        duration in the problem's unit of time
    sources
        two sources of the truth; states of the first one are written
    start
        origin of the masses and the initial state
    """

    name: str
    problem: Problem
    duration: float
    sources: tuple[Source, Source]
    start: str = WRITTEN_FOR_GALVI

    def truth(self) -> Truth:
        """Positions and velocities (rows, bodies, 2 or 3) on which two sources agree."""
        shifted_problem = shifted(self.problem, SHIFT, np.ones(self.problem.q0.size))
        return agreed_truth(self.problem, self.duration, self.sources, shifted_problem)

    def orders(self, truth: Truth) -> dict[str, Convergence | None]:
        """Measured orders by the names of integrators; None where none was measured."""
        orders = {
            name: convergence(self.problem, truth, methods[0].contender.order, methods)
            for name, methods in INTEGRATORS.items()
        }
        return {**orders, **dict.fromkeys(ADAPTIVE)}


def two_bodies(e: float, anomaly: float = 0.0) -> Problem:
    """Masses 0.75 and 0.25 about their centre of mass on orbits with |a| = 1 in a tilted plane.

    Orbits with e < 1 start at the pericentre, flybys at `anomaly`.

    Parameters
    ----------
    anomaly
        hyperbolic eccentric anomaly at the start of a flyby, e > 1
    """
    if e < 1.0:
        position, speed = (1.0 - e, 0.0), (0.0, math.sqrt((1.0 + e) / (1.0 - e)))
    else:
        c, s, root = math.cosh(anomaly), math.sinh(anomaly), math.sqrt(e * e - 1.0)
        rate = 1.0 / (e * c - 1.0)
        position, speed = (e - c, root * s), (-s * rate, root * c * rate)
    q, v = _tilted(position), _tilted(speed)
    masses = np.array([0.75, 0.25])
    fractions = np.array([-0.25, 0.75])[:, None]
    return Problem(
        NBody(masses), fractions * q, fractions * v, name=f"two bodies, e = {e:g}", units="G = 1"
    )


def _tilted(vector: Sequence[float]) -> Array:
    """The vector (3,) of a vector (2,) in the tilted plane."""
    x, y = vector
    y, z = y * math.cos(TILT), y * math.sin(TILT)
    c, s = math.cos(NODE), math.sin(NODE)
    return np.array([c * x - s * y, s * x + c * y, z])


def figure_eight() -> Problem:
    """Three equal masses that follow each other along a figure eight."""
    x, v = np.array([0.97000436, -0.24308753]), np.array([-0.93240737, -0.86473146])
    positions, velocities = [x, -x, np.zeros(2)], [-0.5 * v, -0.5 * v, v]
    return Problem(
        NBody([1.0, 1.0, 1.0]), positions, velocities, name="figure eight", units="G = 1"
    )


def lagrange_triangle() -> Problem:
    """Unequal masses at the corners of an equilateral triangle of side 1, on ellipses."""
    masses = np.array(TRIANGLE_MASSES)
    corners = np.array([0.0, 1.0, complex(0.5, math.sqrt(0.75))])
    corners = corners - masses @ corners / masses.sum()
    corner_velocities = 1j * TRIANGLE_SPEED * math.sqrt(masses.sum()) * corners
    positions, velocities = (
        np.stack([x.real, x.imag], axis=1) for x in (corners, corner_velocities)
    )
    return Problem(NBody(masses), positions, velocities, name="Lagrange's triangle", units="G = 1")


def _similar_triangles(problem: Problem, duration: float) -> States:
    """States of a triangle that stays similar to itself.

    Its first side moves like a body about a fixed centre with the total mass.
    """
    side, side_velocity = (x[1] - x[0] for x in (problem.q0, problem.v0))
    system: Any = problem.system
    centre = CentralForce(float(system.masses.sum()))
    side_states = CLOSED.states(Problem(Canonical(1.0, centre), side, side_velocity), duration)
    corners = problem.q0 @ (1.0, 1j)
    triangle_states = (
        np.multiply.outer(x @ (1.0, 1j), corners) / (side @ (1.0, 1j)) for x in side_states
    )
    q, v = (np.stack([x.real, x.imag], axis=-1) for x in triangle_states)
    return q, v


def arenstorf() -> Problem:
    """A massless body about Earth and Moon on circles, from behind the Moon, in an inertial frame.

    In the frame that turns with the Moon the body returns to its start after ARENSTORF_PERIOD.
    """
    x, speed = ARENSTORF_START
    positions = [[-MOON_MASS, 0.0], [1.0 - MOON_MASS, 0.0], [x, 0.0]]
    velocities = [[0.0, -MOON_MASS], [0.0, 1.0 - MOON_MASS], [0.0, speed + x]]
    masses = [1.0 - MOON_MASS, MOON_MASS, 0.0]
    return Problem(NBody(masses), positions, velocities, name="Arenstorf's orbit", units="G = 1")


def retrograde_planet() -> Problem:
    """Two planets of a star, the outer one on a retrograde orbit inclined by 150 degrees."""
    masses = np.array([1.0, 1e-3, 5e-4])
    c, s = math.cos(math.radians(150.0)), math.sin(math.radians(150.0))
    q = np.array([[0.0, 0.0, 0.0], [0.95, 0.0, 0.0], [-1.8, 0.0, 0.0]])
    v = np.array([[0.0, 0.0, 0.0], [0.0, 1.05, 0.0], [0.0, -0.78 * c, -0.78 * s]])
    q, v = q - masses @ q / masses.sum(), v - masses @ v / masses.sum()
    return Problem(NBody(masses), q, v, name="a retrograde planet", units="G = 1")


def _stored(name: str, case: str, fraction: float, start: str = WRITTEN_FOR_GALVI) -> PointMasses:
    """A problem with a stored truth, over a fraction of its duration: 1 or 0.1."""
    problem, horizon = CASES[case]
    return PointMasses(name, problem, horizon * fraction, STORED_PAIR, start)


def all_point_masses() -> tuple[PointMasses, ...]:
    """The problems of the kit."""
    turn, planets = 2.0 * math.pi, many_planets(8)
    belt = problems.outer_solar_system(particles=6)
    triangle = Source("similar triangles, whose side is " + CLOSED.label, _similar_triangles)
    return (
        PointMasses("two_bodies_e00", two_bodies(0.0), turn, CLOSED_PAIR),
        PointMasses("two_bodies_e03", two_bodies(0.3), 2.0 * turn, CLOSED_PAIR),
        PointMasses("two_bodies_e06", two_bodies(0.6), 2.0 * turn, CLOSED_PAIR),
        PointMasses("two_bodies_e09", two_bodies(0.9), turn, CLOSED_PAIR),
        PointMasses("hyperbolic_flyby", two_bodies(1.5, -2.0), 10.0, NUMERICAL_PAIR),
        PointMasses("light_body_first", PAIR, 10.0, CLOSED_PAIR),
        PointMasses(
            "figure_eight", figure_eight(), 10.0, NUMERICAL_PAIR,
            "Chenciner and Montgomery, Annals of Mathematics 152 (2000) 881, digits by C. Simo",
        ),
        PointMasses("lagrange_triangle", lagrange_triangle(), 4.0, (triangle, GAUSS_RADAU),
                    "Lagrange, Essai sur le probleme des trois corps (1772); masses "
                    + WRITTEN_FOR_GALVI),
        _stored("pythagorean", "burrau", 1.0,
                "Burrau, Astronomische Nachrichten 195 (1913) 113; Szebehely and Peters, "
                "Astronomical Journal 72 (1967) 876"),
        _stored("outer_solar_system", "outer_solar_system", 0.1, DE421),
        _stored("solar_system", "solar_system", 0.1,
                DE421 + "; Earth is the barycentre of Earth and Moon"),
        _stored("applegate", "applegate", 0.1,
                "Applegate, Douglas, Gursel, Sussman and Wisdom, Astronomical Journal 92 (1986) "
                "176, as in heyoka.py's documentation"),
        _stored("hierarchical_triple", "kozai", 0.1),
        _stored("sitnikov", "sitnikov", 0.1,
                "Sitnikov, Doklady Akademii Nauk 133 (1960) 303; numbers " + WRITTEN_FOR_GALVI),
        PointMasses(
            "arenstorf", arenstorf(), ARENSTORF_PERIOD, NUMERICAL_PAIR,
            "Arenstorf 1963, with the digits of Hairer, Norsett and Wanner, Solving Ordinary "
            "Differential Equations I, II.0; here in an inertial frame",
        ),
        PointMasses("retrograde_planet", retrograde_planet(), 30.0, NUMERICAL_PAIR),
        _stored("binary_meets_star", "binary_meets_star", 1.0),
        _stored("sixteen_stars", "sixteen_stars", 0.1),
        PointMasses("massless_belt", belt, 36525.0, NUMERICAL_PAIR,
                    DE421 + "; massless bodies " + WRITTEN_FOR_GALVI),
        PointMasses("many_planets", planets, 10.0 * innermost_period(planets), NUMERICAL_PAIR,
                    "written for galvi, with the GM of DE421, that of planets times 1e-3"),
    )  # fmt: skip

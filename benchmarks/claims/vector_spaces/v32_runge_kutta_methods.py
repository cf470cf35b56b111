"""V32: a step against those of Runge-Kutta methods, by textbook formulas in numpy (M sec. 1)."""

from __future__ import annotations

from collections import defaultdict
from itertools import product
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, Fault, MakeMethod, Report, always, scaled
from benchmarks.measures.independent_space import (
    all_of_degree,
    gauss_points,
    lobatto_points,
    values,
)

STEP, PASSES = 0.5, 200
ENDS = "distance of q and p at the end"


def two_springs(q: Array) -> Array:
    """The acceleration of Henon and Heiles' problem at q, (..., 2)."""
    x, y = q[..., 0], q[..., 1]
    return np.stack([-x - 2.0 * x * y, -y - x**2 + y**2], axis=-1)


PENDULUM = galvi.Canonical(2.0, galvi.CosinePotential(1.0))
CASES = (  # problem, mass, acceleration
    (galvi.problems.henon_heiles(), 1.0, two_springs),
    (galvi.Problem(PENDULUM, np.ones(1), np.ones(1)), 2.0, lambda q: -0.5 * np.sin(q)),
)
RULES = {  # name -> (rule, the same in numpy, number of points minus N)
    "Gauss N": (galvi.gauss, gauss_points, 0),
    "Lobatto N + 1": (galvi.lobatto, lobatto_points, 1),
}


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """The largest distances over both cases."""
    distances = defaultdict(list)
    for rule, N, (problem, mass, acceleration) in product(RULES, range(1, 5), CASES):
        of, points, offset = RULES[rule]
        c, b = points(N + offset)
        a = collocation(c)
        run = galvi.integrate(problem, make_method(galvi.Polynomials(N), of(N + offset)), STEP, 1)
        motion = acceleration, problem.q0, problem.v0
        q, v, places = runge_kutta(*motion, a, b)
        ends = {f", {rule}, N = {N}": (q, v)}
        if rule == "Gauss N":
            distances["distance of the tableau from its partner, Gauss N, all N"].append(
                abs(partner(a, b) - a)
            )
        elif N == 1:
            ends[" from Stormer-Verlet, Lobatto 2, N = 1"] = verlet(*motion)
            ends[" from Newmark, beta = 0, gamma = 1/2, Lobatto 2, N = 1"] = newmark(*motion)
        for name, (q, v) in ends.items():
            distances[ENDS + name] += [abs(run.q[-1] - q), abs(run.p[-1] - mass * v)]
        distances[f"distance of the curve from the stages, {rule}, N = {N}"].append(
            abs(run(STEP * c) - places)
        )
    return {quantity: np.max([np.max(x) for x in sizes]) for quantity, sizes in distances.items()}


def collocation(c: Array) -> Array:
    """The matrix a_ij: integrals from 0 to c_i of the Lagrange polynomial that is 1 at c_j."""
    functions = all_of_degree(len(c) - 1)
    s, w = gauss_points(len(c))
    within = [values(functions, end * s) @ (end * w) for end in c]
    return np.linalg.solve(values(functions, c), np.array(within).T).T


def partner(a: Array, b: Array) -> Array:
    """The symplectic partner a^ of a, for which b_i a^_ij + b_j a_ji = b_i b_j."""
    return b * (1.0 - a.T / b[:, None])


def runge_kutta(acceleration: Any, q: Array, v: Array, a: Array, b: Array) -> tuple[Any, Any, Any]:
    """q and v after a step, and the positions at the stages, (stages, d); a is the matrix for q,
    its partner that for v."""
    places = np.tile(q, (len(b), 1))
    for _ in range(PASSES):
        velocities = v + STEP * partner(a, b) @ acceleration(places)
        places = q + STEP * a @ velocities
    return q + STEP * b @ velocities, v + STEP * b @ acceleration(places), places


def verlet(acceleration: Any, q: Array, v: Array) -> tuple[Any, Any]:
    """q and v after a step of Stormer-Verlet: half a kick, a drift, half a kick."""
    half = v + 0.5 * STEP * acceleration(q)
    end = q + STEP * half
    return end, half + 0.5 * STEP * acceleration(end)


def newmark(acceleration: Any, q: Array, v: Array) -> tuple[Any, Any]:
    """q and v after a step of Newmark's method (1959), beta = 0 and gamma = 1/2."""
    before = acceleration(q)
    end = q + STEP * v + 0.5 * STEP**2 * before
    return end, v + 0.5 * STEP * (before + acceleration(end))


def one_point_more(space: Any, rule: Any) -> galvi.Galerkin:
    """The method with the next rule of the same kind."""
    rules = galvi.lobatto if "Lobatto" in rule.name else galvi.gauss
    return galvi.Galerkin(space, rules(rule.points + 1))


FAULTS = {
    "a rule of one point more": Fault(make=one_point_more),
    "a wrong partner": Fault(wrong={f"{__name__}.partner": always(lambda a, b: a)}),
    **{
        f"a wrong {name}": Fault(wrong={f"{__name__}.{name}": scaled(1.0 + 1e-11)})
        for name in ("verlet", "newmark", "collocation")
    },
}

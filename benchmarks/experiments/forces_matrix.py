"""Which force works under which integrator: secular rates of a planet's orbit.

    python -m benchmarks.experiments.forces_matrix

A planet of 1e-6 of its star's mass, e = 0.2, 0.3 from the equator, for 50 orbits: the rates of its
node and argument of pericentre by least squares, from states twenty times an orbit. The truth is a
run of SciPy's DOP853 at 1e-13 with formulas of references/forces; theory, to first order in the
force, is shown beside it. REBOUNDx's forces under REBOUND's integrators, 40 steps an orbit where
steps are fixed, less the rates of the same run without the force, and galvi's, of degree 8 with 16.
Two faults are planted in galvi's runs.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

import galvi
from references.forces import celestial
from references.rebound import extras

ORBITS, SAMPLES, STEPS, OURS = 50, 20, 40, 16
MASS, E, TILT, C, J2, RADIUS = 1e-6, 0.2, 0.3, 300.0, 1e-3, 0.1
MU = 1.0 + MASS
PERIOD = 2.0 * np.pi / np.sqrt(MU)
RIGHT = 3e-3  # of a rate
TIMES = PERIOD * np.arange(ORBITS * SAMPLES + 1) / SAMPLES
INTEGRATORS = ("ias15", "bs", "whfast", "saba", "trace", "mercurius", "leapfrog")
FORCES: dict[str, tuple[str, Any]] = {
    "J2": ("gravitational_harmonics", galvi.Oblateness(0, J2, RADIUS)),
    "gr_potential": ("gr_potential", galvi.Relativity(C, form="potential")),
    "gr": ("gr", galvi.Relativity(C)),
    "gr_full": ("gr_full", galvi.Relativity(C, form="EIH")),
}


def problem(forces: Any) -> galvi.Problem:
    """The star and its planet at pericentre, the node and pericentre at 0.5 and 0.7."""
    near, fast = 1.0 - E, np.sqrt(MU * (1.0 + E) / (1.0 - E))
    turn = _about(2, 0.5) @ _about(0, TILT) @ _about(2, 0.7)
    x, v = turn @ [near, 0.0, 0.0], turn @ [0.0, fast, 0.0]
    share = np.array([[-MASS / MU], [1.0 / MU]])
    return galvi.Problem(galvi.NBody([1.0, MASS], forces=forces), share * x, share * v)


def _about(axis: int, angle: float) -> Any:
    c, s = np.cos(angle), np.sin(angle)
    i, j = [k for k in range(3) if k != axis]
    matrix = np.eye(3)
    matrix[i, i] = matrix[j, j] = c
    matrix[i, j], matrix[j, i] = -s, s
    return matrix


def rates(q: Any, v: Any) -> tuple[float, float]:
    """Slopes of node and argument of pericentre, from relative states (n, 3)."""
    h = np.cross(q, v)
    node = np.unwrap(np.arctan2(h[:, 0], -h[:, 1]))
    e = np.cross(v, h) / MU - q / np.linalg.norm(q, axis=1)[:, None]
    n = np.stack([np.cos(node), np.sin(node), 0.0 * node], axis=1)
    across = np.cross(h / np.linalg.norm(h, axis=1)[:, None], n)
    turn = np.unwrap(np.arctan2(np.sum(e * across, axis=1), np.sum(e * n, axis=1)))
    node_rate, turn_rate = (float(np.polyfit(TIMES, x, 1)[0]) for x in (node, turn))
    return node_rate, turn_rate


def theory(name: str) -> tuple[float, float]:
    """To first order: of the node and of the argument of pericentre."""
    n, p = 2.0 * np.pi / PERIOD, 1.0 - E * E
    if name == "J2":
        size = n * J2 * (RADIUS / p) ** 2
        return -1.5 * size * np.cos(TILT), 0.75 * size * (5.0 * np.cos(TILT) ** 2 - 1.0)
    return 0.0, 6.0 * np.pi * MU / (C * C * p) / PERIOD


def of_scipy(force: Any) -> tuple[float, float]:
    given = problem(force)
    plain = galvi.NBody([1.0, MASS])

    def slope(t: float, y: Any) -> Any:
        q, v = y.reshape(2, 2, 3)
        a = plain.acceleration(q, t) + celestial.accelerations(given.system, q, v, t)
        return np.concatenate([v.ravel(), a.ravel()])

    start = np.concatenate([given.q0.ravel(), given.v0.ravel()])
    found = solve_ivp(slope, (0.0, TIMES[-1]), start, "DOP853", TIMES, rtol=1e-13, atol=1e-15)
    states = found.y.T.reshape(-1, 2, 2, 3)
    return rates(*(states[:, k, 1] - states[:, k, 0] for k in range(2)))


def of_galvi(force: Any) -> tuple[float, float]:
    method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    run = galvi.integrate(problem(force), method, PERIOD / OURS, ORBITS * OURS)
    q, p = galvi.states_at(run, TIMES)
    v = p / np.array([[1.0], [MASS]])
    return rates(q[:, 1] - q[:, 0], v[:, 1] - v[:, 0])


def of_reboundx(name: str, integrator: str) -> tuple[float, float]:
    star = {"J2": J2, "R_eq": RADIUS} if name == "gravitational_harmonics" else {}
    own = {"c": C} if name.startswith("gr") and not star else {}
    q, v = extras.states(problem(()), integrator, PERIOD / STEPS, TIMES, name, own, star)
    return rates(q[:, 1] - q[:, 0], v[:, 1] - v[:, 0])


def of_the_force(name: str, integrator: str) -> tuple[float, float]:
    """The rates with a force of REBOUNDx's less those without, which are the integrator's own."""
    one, other = of_reboundx(name, integrator), of_reboundx("", integrator)
    return one[0] - other[0], one[1] - other[1]


def cell(run: Callable[[], tuple[float, float]], true: tuple[float, float]) -> str:
    """Right, wrong by a share of the largest rate, or what was raised."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            found = run()
    except Exception as error:
        return f"refused: {str(error)[:60]}"
    off = float(np.max(np.abs(np.subtract(found, true))) / np.max(np.abs(true)))
    return f"{'right' if off < RIGHT else 'wrong'}, off by {off:.1e}"


def matrix() -> list[tuple[str, str, str]]:
    """(force, integrator, cell)."""
    rows = []
    for name, (theirs, force) in FORCES.items():
        true = of_scipy(force)
        rows.append((name, "theory", cell(lambda name=name: theory(name), true)))
        rows.append((name, "galvi", cell(lambda force=force: of_galvi(force), true)))
        rows += [
            (name, one, cell(lambda one=one, theirs=theirs: of_the_force(theirs, one), true))
            for one in INTEGRATORS
        ]
    true = of_scipy(FORCES["J2"][1])
    rows.append(
        ("J2", "galvi, sign", cell(lambda: of_galvi(galvi.Oblateness(0, -J2, RADIUS)), true))
    )
    rows.append(("J2", "galvi, no kick", cell(lambda: of_galvi(()), true)))
    return rows


if __name__ == "__main__":
    print(extras.versions())
    for row in matrix():
        print("{:14} {:16} {}".format(*row))

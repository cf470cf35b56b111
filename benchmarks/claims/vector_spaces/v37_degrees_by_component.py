"""V37: high degrees for fast components, low ones for slow components (H 2.3.3, 4.2)."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import Array, Fault, MakeMethod, Problem, Report, with_arguments

FREQUENCIES = np.array([10.0, 1.0])
START = np.ones(2)
STEP, STEPS = 0.25, 80
TURNED = 1e-3  # rad


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, float]:
    """Ratios of errors after STEPS steps between different degrees of the components."""
    both, fast, neither = (error(make_method, degrees, 0.0) for degrees in ((8, 8), (8, 4), (4, 4)))
    turned = [error(make_method, degrees, TURNED) for degrees in ((8, 4), (8, 8))]
    return {
        "error with degrees 8 and 4 over that with 8 and 8": fast / both,
        "error with degrees 4 and 4 over that with 8 and 4": neither / fast,
        "error with degrees 8 and 4 over that with 8 and 8, modes turned": turned[0] / turned[1],
    }


def error(make_method: MakeMethod, degrees: tuple[int, int], angle: float) -> float:
    """The largest error of a component at the end; NaN for a failed run."""
    modes = modes_at(angle)
    stiffness = modes @ np.diag(FREQUENCIES**2) @ modes.T

    def potential(q: Array) -> Any:
        return 0.5 * q @ stiffness @ q

    def gradient(q: Array) -> Array:
        return np.asarray(stiffness @ q)

    system = galvi.Canonical(1.0, potential, gradient, lambda q: stiffness)
    method = make_method(galvi.ComponentPolynomials(degrees), galvi.gauss(8))
    run = galvi.integrate(Problem(system, START, np.zeros(2)), method, STEP, STEPS)
    if not run.success:
        return math.nan
    exact = modes @ (np.cos(FREQUENCIES * STEP * STEPS) * (modes.T @ START))
    return float(np.max(abs(run.q[-1] - exact)))


def modes_at(angle: float) -> Array:
    """The fast and the slow mode, as columns, turned by an angle."""
    c, s = math.cos(angle), math.sin(angle)
    return np.array([[c, -s], [s, c]])


def of_one_degree_less(space: Any, rule: Any) -> galvi.Galerkin:
    """A faulty constructor that takes degrees 8 and 3 for 8 and 4."""
    degrees = (8, 3) if space.degrees == (8, 4) else space.degrees
    return galvi.Galerkin(galvi.ComponentPolynomials(degrees), rule)


def of_high_degree(space: Any, rule: Any) -> galvi.Galerkin:
    """A faulty constructor that takes degree 8 for both components."""
    return galvi.Galerkin(galvi.ComponentPolynomials((8, 8)), rule)


FAULTS = {
    "a slow component of a degree less": Fault(of_one_degree_less),
    "one degree for both": Fault(of_high_degree),
    "modes that are not turned": Fault(
        wrong={f"{__name__}.modes_at": with_arguments(lambda angle: (0.0,))}
    ),
}

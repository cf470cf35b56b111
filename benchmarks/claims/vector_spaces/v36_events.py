"""V36: events of a Kepler orbit, a pendulum and a uniform motion, against exact ones."""

from __future__ import annotations

import math
from decimal import Decimal, localcontext
from functools import partial
from typing import Any

import numpy as np
from scipy.optimize import newton

import galvi
from benchmarks.claims.kit import Fault, MakeMethod, Report, collocation, convergence_fits, fewer
from references.closed_forms.double_double import DIGITS
from references.closed_forms.pendulum import Modulus

ECCENTRICITY = 0.3
STEPS_PER_REVOLUTION = (40.3, 50.8, 63.9, 80.6)  # steps per revolution of the Kepler orbit
ANGLES = np.linspace(0.1, 3.1, 16)  # of the normals of lines through its centre
AMPLITUDE = 0.75 * math.pi  # amplitude of the pendulum
STEPS_PER_PERIOD = 16  # steps per period of the pendulum
STEP = 0.25  # of the uniform motion
GAPS = (1e-2, 1e-3, 1e-4, 1e-5)  # distances of the crossings of a pair, in steps


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Orders of the times of events; and counts of crossings of a pendulum, at ends of steps and in
    nearly double pairs."""
    numbers: dict[str, Any] = {}
    sizes = [2.0 * math.pi / parts for parts in STEPS_PER_REVOLUTION]
    for stages in (3, 4):
        errors = np.array([passages(collocation(make_method, stages), h) for h in sizes])
        for k, quantity in enumerate(("times of events", "curve's distance from them")):
            order = convergence_fits.slope(sizes, errors[:, k].tolist())
            numbers[f"order of the {quantity}, {stages} stages"] = order
    numbers |= swings(collocation(make_method, 8), 200 if quick else 10_000)
    return numbers | on_a_line(collocation(make_method, 3))


def passages(method: Any, step: float) -> tuple[float, float]:
    """Errors for the crossings of a Kepler orbit with lines through its centre: the largest error
    of the times of events, and the root mean square of their distances from roots on the run's
    curve.

    The exact times follow from the true anomalies f by Kepler's equation; the orbit starts at its
    pericentre. NaN if the number of events is wrong.
    """
    e, steps = ECCENTRICITY, math.ceil(2.0 * math.pi / step)
    run = galvi.integrate(galvi.problems.kepler(e), method, step, steps)
    time_errors, squares = [], []
    for angle in ANGLES:
        normal = np.array([math.cos(angle), math.sin(angle)])
        t = galvi.find_events(run, galvi.events.plane_crossing(normal)).t
        f = angle + math.pi * (0.5 + np.arange(-2, 4))
        u = f - 2.0 * np.arctan2(e * np.sin(f), 1.0 + math.sqrt(1.0 - e * e) + e * np.cos(f))
        exact = u - e * np.sin(u)
        exact = exact[(exact > 0.0) & (exact < run.t[-1])]
        if len(t) != len(exact):
            return math.nan, math.nan
        time_errors.append(np.max(abs(t - exact)))
        on_curve = newton(lambda x, n=normal: run(x) @ n, t, x1=t + 1e-3 * step, tol=1e-12)
        squares.append(np.mean((on_curve - t) ** 2))
    return max(time_errors), math.sqrt(np.mean(squares))


def swings(method: Any, wanted: int) -> dict[str, Any]:
    """Errors for a pendulum from rest, which passes its lowest position at odd quarters of its
    period 4 K(k)."""
    k = math.sin(0.5 * AMPLITUDE)
    with localcontext(DIGITS):
        square = Decimal(k) ** 2
        quarter = float(Modulus(square, 1 - square).quarter)
    problem = galvi.problems.planar_pendulum(2.0 * math.asin(k))
    steps = math.ceil((0.5 * wanted + 0.1) * STEPS_PER_PERIOD)
    run = galvi.integrate(problem, method, 4.0 * quarter / STEPS_PER_PERIOD, steps)
    t = galvi.find_events(run, galvi.events.angle(0, 0.0)).t
    nearest = np.clip(np.round((t / quarter - 1.0) / 2.0), 0.0, wanted - 1.0)
    late = abs(t - quarter * (1.0 + 2.0 * nearest))
    passed = len(np.unique(nearest[late < quarter]))
    return {
        "crossings of the pendulum that are not found": wanted - passed,
        "crossings that are none": len(t) - passed,
        "largest error of a crossing's time, in periods": np.max(
            late[late < quarter] / (4.0 * quarter), initial=0.0
        ),
    }


def on_a_line(method: Any) -> dict[str, Any]:
    """Counts of crossings of a free body with x(t) = t, whose positions are exact in steps of a
    binary fraction."""
    start, velocity = np.array([[0.0, 1.0, 0.0]]), np.array([[1.0, 0.0, 0.0]])
    problem = galvi.Problem(galvi.NBody(np.ones(1)), start, velocity)
    run = galvi.integrate(problem, method, STEP, 16)
    planes = [galvi.events.plane_crossing((1.0, 0.0, 0.0), k * STEP, body=0) for k in range(17)]
    pairs = [
        galvi.Event(partial(pair, middle=(3.37 + k) * STEP, half=0.5 * gap * STEP))
        for k, gap in enumerate(GAPS)
    ]
    return {
        f"crossings {kind}, found minus true": len(galvi.find_events(run, events)) - true
        for kind, events, true in (
            ("at ends of steps", planes, 16),
            ("in nearly double pairs", pairs, 2 * len(GAPS)),
        )
    }


def pair(q: Any, v: Any, t: float, middle: float, half: float) -> Any:
    """An event function of x with roots at `middle` minus and plus `half`."""
    return (q[0, 0] - middle) ** 2 - half**2


def without(lost: Any) -> Fault:
    """The fault that the roots (rows, x) for which lost(rows, x) is true are not found; x in (-1,
    1] is the position in the step of a row."""

    def wrong(original: Any) -> Any:
        def remaining(*series: Any) -> Any:
            roots = original(*series)
            return tuple(array[~lost(*roots[:2])] for array in roots)

        return remaining

    return Fault(wrong={"galvi.events.search.roots": wrong})


FAULTS = {
    "a root lost at a step's end": without(lambda rows, x: x == 1.0),
    "nearly double roots lost": without(lambda rows, x: np.bincount(rows)[rows] == 2),
    "times of the curve's order only": Fault(wrong=fewer("galvi.events.search", SECANTS=1)),
}

"""V36: events of a Kepler orbit, of a pendulum and of uniform motion, beside known ones."""

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

ECCENTRICITY, PARTS = 0.3, (40.3, 50.8, 63.9, 80.6)  # steps a revolution
ANGLES = np.linspace(0.1, 3.1, 16)  # of lines
SWING, PER_PERIOD = 0.75 * math.pi, 16  # amplitude of the pendulum, steps
STEP, GAPS = 0.25, (1e-2, 1e-3, 1e-4, 1e-5)  # of uniform motion; of pairs of crossings, in steps


def measure(make_method: MakeMethod, quick: bool, report: Report) -> dict[str, Any]:
    """Orders of times; crossings of a pendulum, at ends of steps and in pairs."""
    numbers: dict[str, Any] = {}
    sizes = [2.0 * math.pi / parts for parts in PARTS]
    for stages in (3, 4):
        errors = np.array([passages(collocation(make_method, stages), h) for h in sizes])
        for k, quantity in enumerate(("times of events", "curve's distance from them")):
            order = convergence_fits.slope(sizes, errors[:, k].tolist())
            numbers[f"order of the {quantity}, {stages} stages"] = order
    numbers |= swings(collocation(make_method, 8), 200 if quick else 10_000)
    return numbers | on_a_line(collocation(make_method, 3))


def passages(method: Any, step: float) -> tuple[float, float]:
    """Where a Kepler orbit crosses lines through its centre: the largest error of the times of
    events, and the root mean square of the distances of roots on the curve of the run from these.

    By Kepler's equation from the true anomalies f; the orbit starts at its pericentre."""
    e, steps = ECCENTRICITY, math.ceil(2.0 * math.pi / step)
    run = galvi.integrate(galvi.problems.kepler(e), method, step, steps)
    late, squares = [], []
    for angle in ANGLES:
        normal = np.array([math.cos(angle), math.sin(angle)])
        t = galvi.find_events(run, galvi.events.plane_crossing(normal)).t
        f = angle + math.pi * (0.5 + np.arange(-2, 4))
        u = f - 2.0 * np.arctan2(e * np.sin(f), 1.0 + math.sqrt(1.0 - e * e) + e * np.cos(f))
        exact = u - e * np.sin(u)
        exact = exact[(exact > 0.0) & (exact < run.t[-1])]
        if len(t) != len(exact):
            return math.nan, math.nan
        late.append(np.max(abs(t - exact)))
        on_curve = newton(lambda x, n=normal: run(x) @ n, t, x1=t + 1e-3 * step, tol=1e-12)
        squares.append(np.mean((on_curve - t) ** 2))
    return max(late), math.sqrt(np.mean(squares))


def swings(method: Any, wanted: int) -> dict[str, Any]:
    """A pendulum let go passes the lowest place at odd quarters of its period 4 K(k)."""
    k = math.sin(0.5 * SWING)
    with localcontext(DIGITS):
        square = Decimal(k) ** 2
        quarter = float(Modulus(square, 1 - square).quarter)
    problem = galvi.problems.planar_pendulum(2.0 * math.asin(k))
    steps = math.ceil((0.5 * wanted + 0.1) * PER_PERIOD)
    run = galvi.integrate(problem, method, 4.0 * quarter / PER_PERIOD, steps)
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
    """A free body in steps of a binary fraction, x(t) = t: its places are exact."""
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
    """Two roots of x, in one step."""
    return (q[0, 0] - middle) ** 2 - half**2


def without(lost: Any) -> Fault:
    """Roots (rows, x), x in (-1, 1] of a row's step, are lost."""

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

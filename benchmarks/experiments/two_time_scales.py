"""Compare trigonometric and polynomial spaces on problems with two time scales and with one.

Run as `python -m benchmarks.experiments.two_time_scales`.
Each row has a step, in periods of the fast motion, and the largest position error at the end for
three methods: polynomials of degree 4 with the cosine and sine of that frequency, and 12 + w Gauss
points, rounded up to an even number (w radians a step); polynomials with as many unknowns and the
same points; and polynomials of the degree that uses these points fully (Gauss collocation).

Per unknown the waves win on two time scales. Per force evaluation Gauss collocation wins, with more
unknowns; on an orbit, which has infinitely many harmonics, the waves gain nothing.
"""

from __future__ import annotations

import math

import numpy as np
import pandas as pd

import galvi
from galvi import Problem
from galvi.arrays import Array
from references import DOP853, KEPLER
from references.compiled import njit
from references.scipy.ivp import TIGHT

OMEGA = 50.0
DEGREE, HARMONICS = 4, 1
TURNS = (0.25, 0.5, 1.0, 2.0)
OWN_TURNS = (0.125, 0.25, 0.5)  # of an orbit that has one time scale
ORBITS = 2.0
WAVES, AS_MANY_UNKNOWNS, AS_MANY_POINTS = "waves", "as many unknowns", "as many points"


@njit()
def _potential(q: Array) -> float:
    return 0.5 * OMEGA**2 * q[1] ** 2 + 0.25 * ((q[0] - q[1]) ** 4 + (q[0] + q[1]) ** 4)


@njit()
def _gradient(q: Array) -> Array:
    out = np.empty(2)
    less, more = (q[0] - q[1]) ** 3, (q[0] + q[1]) ** 3
    out[0], out[1] = less + more, OMEGA**2 * q[1] + more - less
    return out


def stiff_pair() -> Problem:
    """One stiff spring, omega = 50, between two soft cubic ones.

    Hairer, Lubich and Wanner, Geometric Numerical Integration, I.5.1 with one pair and its initial
    values: q0 = (1, 1 / omega), v0 = (1, 1); q[0] is slow and q[1] fast.
    """
    return Problem(
        galvi.Canonical(1.0, _potential, _gradient),
        [1.0, 1.0 / OMEGA],
        [1.0, 1.0],
        name="stiff pair",
        parameters={"omega": OMEGA},
        units="none",
    )


def study(problem: Problem, period: float, duration: float, turns: tuple[float, ...], truth: Array
          ) -> pd.DataFrame:  # fmt: skip
    """One row for each step and method: error, unknowns a component, points, evaluations."""
    rows = []
    for turn in turns:
        steps = round(duration / (turn * period))
        h = duration / steps
        w = 2.0 * math.pi * h / period
        points = 2 * math.ceil((12.0 + w) / 2.0)
        waves = galvi.PolynomialFourier(DEGREE, HARMONICS, w)
        unknowns = waves.dimension - 1
        for label, space in (
            (WAVES, waves),
            (AS_MANY_UNKNOWNS, galvi.Polynomials(unknowns)),
            (AS_MANY_POINTS, galvi.Polynomials(points)),
        ):
            run = galvi.integrate(problem, galvi.Galerkin(space, galvi.gauss(points)), h, steps)
            rows.append({
                "problem": problem.name, "turns": turn, "label": label,
                "unknowns": space.dimension - 1, "points": points,
                "error": float(np.max(np.abs(run.q[-1] - truth))),
                "evaluations": run.counts["force_evaluations"], "status": run.status,
            })  # fmt: skip
    return pd.DataFrame(rows)


def stiff_pair_study() -> pd.DataFrame:
    """Two time scales: the stiff pair over 100 turns of its fast spring; truth: DOP853."""
    problem, period = stiff_pair(), 2.0 * math.pi / OMEGA
    duration = 100.0 * period
    truth = DOP853.run(problem, duration, {"samples": 1, **TIGHT}).q[-1]
    return study(problem, period, duration, TURNS, truth)


def orbit_study() -> pd.DataFrame:
    """One time scale: Kepler's ellipse with e = 0.3, whose harmonics do not end; closed form."""
    problem, period = galvi.problems.kepler(0.3), 2.0 * math.pi
    duration = ORBITS * period
    truth = KEPLER.run(problem, duration, {"samples": 1}).q[-1]
    return study(problem, period, duration, OWN_TURNS, truth)


if __name__ == "__main__":
    for table in (stiff_pair_study(), orbit_study()):
        print(table.to_string(index=False, formatters={"error": "{:.1e}".format}))

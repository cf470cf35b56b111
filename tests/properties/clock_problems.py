"""Problems, clocks and methods of the tests of clocks."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from references.stored.encounters import burrau

GAUSS, LOBATTO, MORE_POINTS = "gauss", "lobatto", "more points"


def method(s: int, clock: Any, rule_name: str = GAUSS) -> galvi.Galerkin:
    rules = {GAUSS: galvi.gauss(s), LOBATTO: galvi.lobatto(s + 1), MORE_POINTS: galvi.gauss(s + 1)}
    return galvi.Galerkin(galvi.Polynomials(s), rules[rule_name], clock=clock)


def clock_of_angle(q: Any) -> Any:
    return 1.0 / (1.5 + np.cos(q[0]) * 0.5)


def clock_of_attitude(R: Any) -> Any:
    return 1.0 / (1.5 + 0.5 * R[2, 2])


def three_bodies() -> galvi.Problem:
    """A star, a planet and a moon-like companion, in three dimensions."""
    q = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.1], [-2.0, 0.3, 0.0]]
    v = [[0.0, 0.0, 0.0], [0.0, 0.8, 0.0], [0.1, -0.6, 0.05]]
    return galvi.Problem(galvi.NBody([1.0, 0.02, 0.05]), q, v)


def traced_clock(q: Any) -> Any:
    return 1.0 / (1.5 + 0.5 * q[0, 0])


def untraced_clock(q: Any) -> Any:
    """`traced_clock` behind a branch, which keeps it from being traced."""
    return traced_clock(q) if q[0, 1] < 1e9 else 1.0


# Name -> problem, clock, duration, step.
CASES = {
    "Kepler, Sundman": (galvi.problems.kepler(0.5), galvi.Sundman(), 6.0, 0.4),
    "Kepler, eccentric anomaly": (galvi.problems.kepler(0.5), galvi.Sundman(1.0), 6.0, 0.4),
    "elastic pendulum": (galvi.problems.elastic_pendulum(), galvi.Clock(clock_of_angle), 2.0, 0.2),
    "3D pendulum": (galvi.problems.pendulum_3d(), galvi.Clock(clock_of_attitude), 2.0, 0.2),
    "three bodies": (three_bodies(), galvi.DynamicalTime(), 3.0, 0.4),
}


def pulsing_potential(q: Any, t: Any) -> Any:
    return -(1.0 + 0.1 * np.sin(t)) / np.sqrt(q @ q)


DAMPED = galvi.Canonical(1.0, galvi.CentralForce(1.0), force=lambda q, v: -0.05 * v)
DRIVEN = galvi.Canonical(1.0, pulsing_potential, explicit_time=True)
KEPLER, BURRAU = galvi.problems.kepler(0.5), burrau()
DYNAMICAL, SUNDMAN = galvi.DynamicalTime(), galvi.Sundman()

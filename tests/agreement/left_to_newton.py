"""Runs of which fixed-point iteration cannot solve some steps, and which agree all the same."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
import sympy as sp

import galvi
from tests.agreement.on_groups import OF_FUNCTIONS
from tests.agreement.on_vector_spaces import LAGRANGIANS, vx, vy, x, y
from tests.properties.group_motions import FREE, hall


@dataclass(frozen=True)
class Left:
    """A run of which engines leave some steps to Newton's method.

    make     returns the problem
    method, step, steps
    counted  whether the run counts these steps as newton_steps
    """

    make: Callable[[], galvi.Problem]
    method: galvi.Galerkin
    step: float
    steps: int
    counted: bool = True


def gauss(s: int, **moving: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), **moving)


def without_pivot() -> galvi.Problem:
    """A mass with nothing on its diagonal."""
    L = sp.expand(vx * vy - x * y)
    system = galvi.Lagrangian.from_sympy(L, (x, y), (vx, vy))
    return galvi.Problem(system, [0.4, -0.7], [0.5, 0.2])


def stiff_spring() -> galvi.Problem:
    return galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(30.0)), [0.7], [0.2])


def pair() -> galvi.Problem:
    q, v = np.array([[-0.5, 0.0], [0.5, 0.0]]), np.array([[0.0, -0.5], [0.0, 0.5]])
    return galvi.Problem(galvi.NBody([0.5, 0.5]), q, v)


COUPLED = galvi.Galerkin(galvi.ComponentPolynomials((5, 4)), galvi.gauss(5))
LEFT = {
    "too long a step of a chain": Left(galvi.problems.double_pendulum, gauss(6), 0.25, 8),
    "a mass without a first pivot": Left(without_pivot, gauss(6), 0.05, 20),
    "coupled components of other degrees": Left(
        galvi.problems.double_pendulum, COUPLED, 0.02, 5, counted=False
    ),
    "too stiff a grain": Left(partial(galvi.problems.brownout, 3e-6), gauss(4), 0.05, 60),
    "too stiff a spring": Left(stiff_spring, gauss(4), 1.5, 40, counted=False),
    "too long a step of functions": Left(
        partial(galvi.Problem, *LAGRANGIANS["elastic pendulum"]), gauss(6), 0.9, 8
    ),
    "too long a step of a body": Left(
        partial(galvi.Problem, *OF_FUNCTIONS["a potential"]), gauss(6), 2.0, 4
    ),
    "a turn beyond the series of lanes": Left(lambda: FREE, hall(14, galvi.Exponential()), 0.7, 20),
    "a whole period of a pair": Left(pair, gauss(6), 2.0 * np.pi, 6, counted=False),
}

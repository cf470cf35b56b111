"""Runs with steps that fixed-point iteration cannot solve and Newton's method does."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np
import sympy as sp

import galvi
from tests.agreement.on_groups import BODIES_OF_FUNCTIONS
from tests.agreement.on_vector_spaces import LAGRANGIANS, vx, vy, x, y
from tests.properties.group_motions import FREE, hall


def gauss(s: int, **options: Any) -> galvi.Galerkin:
    return galvi.Galerkin(galvi.Polynomials(s), galvi.gauss(s), **options)


def without_pivot() -> galvi.Problem:
    """A Lagrangian whose mass matrix has a zero diagonal."""
    L = sp.expand(vx * vy - x * y)
    system = galvi.Lagrangian.from_sympy(L, (x, y), (vx, vy))
    return galvi.Problem(system, [0.4, -0.7], [0.5, 0.2])


def stiff_spring() -> galvi.Problem:
    return galvi.Problem(galvi.Canonical(1.0, galvi.LinearSpring(30.0)), [0.7], [0.2])


def pair() -> galvi.Problem:
    q, v = np.array([[-0.5, 0.0], [0.5, 0.0]]), np.array([[0.0, -0.5], [0.0, 0.5]])
    return galvi.Problem(galvi.NBody([0.5, 0.5]), q, v)


COUPLED = galvi.Galerkin(galvi.ComponentPolynomials((5, 4)), galvi.gauss(5))
PENDULUM = partial(galvi.Problem, *LAGRANGIANS["elastic pendulum"])
BODY = partial(galvi.Problem, *BODIES_OF_FUNCTIONS["a potential"])
# function that makes the problem, method, step, number of steps, whether `counts` of the run has
# newton_steps
LEFT_TO_NEWTON: dict[str, tuple[Any, galvi.Galerkin, float, int, bool]] = {
    "too long a step of a chain": (galvi.problems.double_pendulum, gauss(6), 0.25, 8, True),
    "a mass without a first pivot": (without_pivot, gauss(6), 0.05, 20, True),
    "coupled components of other degrees": (
        galvi.problems.double_pendulum,
        COUPLED,
        0.02,
        5,
        False,
    ),
    "too stiff a grain": (partial(galvi.problems.brownout, 3e-6), gauss(4), 0.05, 60, True),
    "too stiff a spring": (stiff_spring, gauss(4), 1.5, 40, False),
    "too long a step of functions": (PENDULUM, gauss(6), 0.9, 8, True),
    "too long a step of a body": (BODY, gauss(6), 2.0, 4, True),
    "a turn beyond the series of lanes": (
        lambda: FREE,
        hall(14, galvi.Exponential()),
        0.7,
        20,
        True,
    ),
    "a whole period of a pair": (pair, gauss(6), 2.0 * np.pi, 6, False),
}

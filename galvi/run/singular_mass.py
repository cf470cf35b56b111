"""Mass matrices of trees of rigid bodies that are nearly singular, as of hinges in gimbal lock."""

from __future__ import annotations

from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.charts.chart import place
from galvi.problem import Problem
from galvi.systems.lagrangian import CHART
from galvi.systems.multibody import Multibody

SMALL = 0.05  # smallest eigenvalue of a mass matrix of unit diagonal, over that at the start
WAY = np.linspace(0.0, 1.0, 9)  # shares of a step
SINGULAR = "the mass matrix is nearly singular, as of three hinges in gimbal lock"
BALL_JOINT = "Use a ball joint in place of the hinges: a smaller step does not help"


def is_singular(problem: Problem, places: Any) -> bool:
    """Whether the mass matrix of a tree is nearly singular at one of the configurations, and is not
    at the problem's start."""
    if not isinstance(problem.system, Multibody):
        return False
    limit = SMALL * _least(problem.system, problem.q0)
    return any(not _least(problem.system, q) > limit for q in places if np.isfinite(q).all())


def is_singular_ahead(problem: Problem, q: Array, v: Array, step: float) -> bool:
    """As `is_singular`, about on the way of a step from a state."""
    if not isinstance(problem.system, Multibody):
        return False
    way = [place(CHART, problem.system.group, q, share * step * v) for share in WAY]
    return is_singular(problem, way)


def _least(system: Multibody, q: Array) -> float:
    mass = system.tree.mass(q)
    size = np.sqrt(np.diag(mass))
    return float(np.linalg.eigvalsh(mass / np.outer(size, size))[0])

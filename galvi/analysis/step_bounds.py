"""The largest steps that the papers' theorems, and the iteration's spectrum, allow."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi.analysis.friedrichs import Z0
from galvi.analysis.stiffness import Stiffness
from galvi.rules.rule import Rule
from galvi.spaces.polynomials import Polynomials
from galvi.spaces.space import Space
from galvi.tableau import assemble

CAUTION = 3.0  # one over the constant of M proposition 1; claim V20 measures sqrt(2)


@dataclass(frozen=True)
class Bound:
    """The largest step, in the problem's unit of time, or None and the reason."""

    step: float | None
    reason: str = ""


def unique_motion(stiffness: Stiffness) -> Bound:
    """M theorem 1: the exact motion is unique while eta = 3 K h^2 / (m z0^2) < 1."""
    return Bound(_divided(Z0 / math.sqrt(CAUTION), stiffness.frequency))


def unique_step(stiffness: Stiffness, friedrichs: float | None) -> Bound:
    """M theorem 2: a step has exactly one solution, and M's iteration finds it, while
    eta C_N^2 < 1."""
    if friedrichs is None:
        return Bound(None, "M theorem 2 needs C_N, which this pair does not have.")
    return Bound(_divided(Z0 / math.sqrt(CAUTION) / friedrichs, stiffness.frequency))


def contracting_stages(space: Space, rule: Rule, stiffness: Stiffness) -> Bound:
    """H theorem 2.3.1, with its 1 / (|A_1^-1| C_L max_j |phi(c_j)|_1 |phi_p(c_j)|) in the norm of
    the largest entry; at most 1, since lemma 2.3.2 asks for h < 1 in the unit of time."""
    if not isinstance(space, Polynomials):
        return Bound(None, "H theorem 2.3.1 is for polynomials on their Chebyshev points.")
    if not assemble(space, rule).well_posed:
        return Bound(None, "H lemma 2.3.1 needs A invertible; this pair is ill-posed.")
    inverse, most = lagrange_constants(space, rule)
    if stiffness.square == 0.0:
        return Bound(1.0)
    return Bound(min(1.0, 1.0 / (inverse * stiffness.square * most)))


def minimal_action(space: Space, rule: Rule, stiffness: Stiffness) -> Bound:
    """H theorem 2.3.5: stationary points are minima while h < pi sqrt(m / (D C_R))."""
    highest = max(getattr(space, "degrees", (space.degree,)))
    if space.dimension != highest + 1:
        return Bound(None, "H theorem 2.3.5 is for spaces of polynomials alone.")
    if rule.degree < 2 * highest:
        return Bound(
            None,
            f"H theorem 2.3.5 asks for a rule of degree 2 s, here {2 * highest}; {rule.name} has "
            f"{rule.degree}.",
        )
    return Bound(_divided(math.pi, _widest(stiffness)))


def coercive_action(stiffness: Stiffness) -> Bound:
    """H theorem 2.3.8: the action is coercive while h < pi sqrt(m / (2 D C_R))."""
    return Bound(_divided(math.pi / math.sqrt(2.0), _widest(stiffness)))


def converging_passes(stiffness: Stiffness, radius: float | None, why: str) -> Bound:
    """Fixed-point iteration contracts near a solution while h^2 rho(A) omega^2 < 1.

    radius  rho(A), the spectral radius of the tableau, or None
    why     the reason when it is None
    """
    if radius is None:
        return Bound(None, why)
    return Bound(_divided(1.0, stiffness.frequency * math.sqrt(radius)))


def lagrange_constants(space: Polynomials, rule: Rule) -> tuple[float, float]:
    """|A_1^-1| of H (2.6)-(2.8) with M = 1, and max_j |phi(c_j)|_1 max_p |phi_p(c_j)|.

    Row 0 is the start; rows i = 1 .. n - 1 test with the basis functions 0 .. n - 2 of the
    Chebyshev points, p over the same (the last gives the momentum at the end).
    """
    nodal: Any = np.linalg.inv(space.basis(space.nodes))
    phi, slope = space.basis(rule.nodes) @ nodal, space.derivative(rule.nodes) @ nodal
    stiff = slope.T @ (rule.weights[:, None] * slope)
    A = np.vstack([np.eye(1, space.dimension), stiff[:-1]])
    inverse = float(np.linalg.norm(np.linalg.inv(A), np.inf))
    sums, largest = np.sum(np.abs(phi), axis=1), np.max(np.abs(phi[:, :-1]), axis=1)
    return inverse, float(np.max(sums * largest))


def _widest(stiffness: Stiffness) -> float:
    return math.sqrt(stiffness.dimension * stiffness.entries)


def _divided(angle: float, frequency: float) -> float:
    return angle / frequency if frequency > 0.0 else math.inf

"""Steps up to which theory holds, for a problem's motion."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

from galvi.analysis.stiffness import Stiffness, estimated, given
from galvi.arrays import Array
from galvi.problem import Problem
from galvi.rules.rule import Rule, gauss
from galvi.spaces.polynomials import Polynomials
from galvi.spaces.space import Space
from galvi.systems.canonical_on_rn import checked_degrees
from galvi.tableau import assemble

Z0 = 0.860333589019379762
"""The smallest positive root of 1 = z tan z, 0.860: the integral of |u|^2 over a step of h is at
most (h / z0)^2 times that of |u'|^2 plus |u(h)|^2 / h, with equality for cos(z0 t / h) (M section
2)."""
FINE = 64  # Gauss points on each part of a step for M's exact integrals: degree 127
PARTS = 4  # parts of each smooth piece
DEPENDENT = 1e11  # condition number of a normalised basis above which constants are not known
BLIND = 1e-12  # eigenvalues below this share of the largest count as 0


@dataclass(frozen=True)
class Norms:
    """Constants of the norm |u|_X^2 = integral of |u'|^2 + |u(h)|^2 / h on a step of length h.

    A subscript N marks the same norm with the integral by the rule.

    unseen    number of independent functions with |u|_{X,N} = 0; 0 iff well posed (M lemma 1)
    C         C_N, the least constant with |u|_{0,N} <= C_N (h / z0) |u|_{X,N} (M 11)
    lowest    lambda_N, least |u|_{X,N} / |u|_X (M 12)
    highest   Lambda_N, largest |u|_{X,N} / |u|_X (M 12)
    seminorm  (least, largest) of |u'|_{0,N} / |u'|_0 (M section 5; claim V21)

    C is infinite for an ill-posed pair. None depends on h.
    """

    unseen: int
    C: float
    lowest: float
    highest: float
    seminorm: tuple[float, float]


@lru_cache(maxsize=128)
def norms(space: Space, rule: Rule) -> Norms | None:
    """The constants of a space and a rule; with one degree per component, the worst of them.

    None when the basis functions are too nearly dependent for float64.
    """
    degrees: Sequence[int] = getattr(space, "degrees", (space.dimension - 1,))
    known = [_norms(space, rule, degree + 1) for degree in sorted(set(degrees))]
    found = [one for one in known if one is not None]
    if len(found) < len(known):
        return None
    return Norms(
        max(one.unseen for one in found),
        max(one.C for one in found),
        min(one.lowest for one in found),
        max(one.highest for one in found),
        (min(one.seminorm[0] for one in found), max(one.seminorm[1] for one in found)),
    )


def _norms(space: Space, rule: Rule, functions: int) -> Norms | None:
    """The constants for the span of the first ``functions`` basis functions."""
    from scipy.linalg import eigh  # with SciPy's other parts, a quarter of galvi's import

    fine = _fine(getattr(space, "pieces", 1))
    phi, end = (space.basis(t)[:, :functions] for t in (rule.nodes, np.ones(1)))
    slope, true = (space.derivative(t)[:, :functions] for t in (rule.nodes, fine[0]))
    last = end.T @ end
    exact_slope = true.T @ (fine[1][:, None] * true)
    exact, size = _scaled(exact_slope + last)
    if not np.linalg.cond(exact) < DEPENDENT:
        return None
    seen_slope = slope.T @ (rule.weights[:, None] * slope) / size
    seen = seen_slope + last / size
    values = phi.T @ (rule.weights[:, None] * phi) / size
    ratios = eigh(seen, exact, eigvals_only=True)
    rates = eigh(seen_slope[1:, 1:], exact_slope[1:, 1:] / size[1:, 1:], eigvals_only=True)
    unseen = int(np.sum(ratios <= BLIND * ratios[-1]))
    C = Z0 * np.sqrt(eigh(values, seen, eigvals_only=True)[-1]) if not unseen else np.inf
    low, high, least, most = np.sqrt(np.clip([ratios[0], ratios[-1], rates[0], rates[-1]], 0, None))
    if unseen:
        low = least = 0.0
    return Norms(unseen, float(C), float(low), float(high), (float(least), float(most)))


def _scaled(gram: Array) -> tuple[Array, Array]:
    """The Gram matrix of functions of norm 1, and the products of their norms."""
    norm = np.sqrt(np.diagonal(gram))
    size = np.outer(norm, norm)
    return gram / size, size


def _fine(pieces: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on every part of every piece of [0, 1]."""
    one, parts = gauss(FINE), pieces * PARTS
    nodes = (np.arange(parts)[:, None] + one.nodes) / parts
    return nodes.ravel(), np.tile(one.weights / parts, parts)


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
    product = inverse * stiffness.square * most  # 0 also with one point, at the step's end
    return Bound(1.0 if product == 0.0 else min(1.0, 1.0 / product))


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


STEPS = 10.0  # number of steps along which K is estimated
BOUNDS = (
    "unique_motion_step",
    "unique_step",
    "stage_step",
    "minimum_step",
    "coercive_step",
    "fixed_point_step",
)
AT_A_STEP = ("contraction", "spectral_contraction", "exists", "minimizes", "coercive", "converges")


def motion_theory(
    space: Space, rule: Rule, pair: Mapping[str, Any], problem: Problem, step: float | None,
    lipschitz: float | None,
) -> dict[str, Any]:  # fmt: skip
    """The fields of a `Theory` that depend on the problem, and the reasons for those that are None.

    pair  the fields that depend on space and rule alone

    Raises ValueError for a space with degrees for components that the problem does not have.
    """
    found: dict[str, Any] = {
        "problem": problem.name or type(problem.system).__name__,
        "units": problem.units,
        "step": None if step is None else float(step),
    }
    checked_degrees(space, problem.system, problem.v0.size)
    changed: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    if pair["symmetric"] and not _commutes(problem.system):
        changed["symmetric"] = None
        reasons["symmetric"] = (
            "on a group a step's chart is based at its start: forward and backward steps differ by "
            "an error of order 2 s + 1."
        )
    stiffness, why = _stiffness(problem, step, lipschitz)
    if stiffness is None:
        none = ("lipschitz", "frequency", *BOUNDS, *AT_A_STEP)
        return {**found, **changed, "reasons": {**reasons, **dict.fromkeys(none, why)}}
    bounds = _bounds(space, rule, pair, stiffness)
    reasons.update({name: bound.reason for name, bound in bounds.items() if bound.step is None})
    found.update({name: bound.step for name, bound in bounds.items()})
    found.update(
        lipschitz=stiffness.lipschitz, source=stiffness.source, frequency=stiffness.frequency
    )
    if step is None:
        reasons.update(dict.fromkeys(AT_A_STEP, "no step was given."))
    else:
        found.update(_at_a_step(abs(float(step)), stiffness, pair, bounds, reasons))
    return {**found, **changed, "reasons": reasons}


def _stiffness(
    problem: Problem, step: float | None, lipschitz: float | None
) -> tuple[Stiffness | None, str]:
    """The stiffness, and why it is None."""
    if not hasattr(problem.system, "acceleration_jacobian"):
        return None, (
            f"the theorems are for L = v.M v / 2 - V on a vector space, not for a "
            f"{type(problem.system).__name__}."
        )
    if getattr(problem.system, "force", None) is not None:
        return None, "the theorems are for forces that have a potential; here is one besides."
    if lipschitz is not None:
        return given(problem, float(lipschitz)), ""
    return estimated(problem, None if step is None else STEPS * float(step))


def _commutes(system: Any) -> bool:
    """Whether the group is commutative, so that a chart's base does not matter."""
    layout = system.group.layout if hasattr(system, "group") else []
    return all(rotations == 0 or d == 1 for _, d, _, rotations in layout)


def _bounds(
    space: Space, rule: Rule, pair: Mapping[str, Any], stiffness: Stiffness
) -> dict[str, Bound]:
    found = (
        unique_motion(stiffness),
        unique_step(stiffness, pair["friedrichs"]),
        contracting_stages(space, rule, stiffness),
        minimal_action(space, rule, stiffness),
        coercive_action(stiffness),
        converging_passes(
            stiffness, pair["spectral_radius"], pair["reasons"].get("spectral_radius", "")
        ),
    )
    return dict(zip(BOUNDS, found, strict=True))


def _at_a_step(
    h: float,
    stiffness: Stiffness,
    pair: Mapping[str, Any],
    bounds: Mapping[str, Bound],
    reasons: dict[str, str],
) -> dict[str, Any]:
    found: dict[str, Any] = {}
    for name, limit in (
        ("exists", "unique_step"),
        ("minimizes", "minimum_step"),
        ("coercive", "coercive_step"),
        ("converges", "fixed_point_step"),
    ):
        bound = bounds[limit]
        found[name] = None if bound.step is None else h < bound.step
        if bound.step is None:
            reasons[name] = bound.reason
    eta = CAUTION * stiffness.square * ((h / Z0) * (h / Z0))  # infinite where it overflows
    C, radius = pair["friedrichs"], pair["spectral_radius"]
    found["contraction"] = None if C is None else eta * C**2
    found["spectral_contraction"] = None if radius is None else h * h * stiffness.square * radius
    for name, constant in (
        ("contraction", "friedrichs"),
        ("spectral_contraction", "spectral_radius"),
    ):
        if found[name] is None:
            reasons[name] = pair["reasons"][constant]
    return found

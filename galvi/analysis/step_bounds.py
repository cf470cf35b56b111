"""Constants of a space and a rule, and steps up to which theory holds, for a problem's force."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import numpy as np

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

    C is infinite for an ill-posed pair. None depends on h.
    """

    unseen: int
    C: float
    lowest: float
    highest: float


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
    )


def _norms(space: Space, rule: Rule, functions: int) -> Norms | None:
    """The constants for the span of the first ``functions`` basis functions."""
    from scipy.linalg import eigh  # with SciPy's other parts, a quarter of galvi's import

    fine = _fine(getattr(space, "pieces", 1))
    phi, end = (space.basis(t)[:, :functions] for t in (rule.nodes, np.ones(1)))
    slope, true = (space.derivative(t)[:, :functions] for t in (rule.nodes, fine[0]))
    last = end.T @ end
    exact = true.T @ (fine[1][:, None] * true) + last
    norm = np.sqrt(np.diagonal(exact))
    exact, seen, values = (
        gram / np.outer(norm, norm)
        for gram in (
            exact,
            slope.T @ (rule.weights[:, None] * slope) + last,
            phi.T @ (rule.weights[:, None] * phi),
        )
    )
    if not np.linalg.cond(exact) < DEPENDENT:
        return None
    ratios = eigh(seen, exact, eigvals_only=True)
    unseen = int(np.sum(ratios <= BLIND * ratios[-1]))
    C = Z0 * np.sqrt(eigh(values, seen, eigvals_only=True)[-1]) if not unseen else np.inf
    low, high = np.sqrt(np.clip([ratios[0], ratios[-1]], 0, None))
    return Norms(unseen, float(C), 0.0 if unseen else float(low), float(high))


def _fine(pieces: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on every part of every piece of [0, 1]."""
    one, parts = gauss(FINE), pieces * PARTS
    nodes = (np.arange(parts)[:, None] + one.nodes) / parts
    return nodes.ravel(), np.tile(one.weights / parts, parts)


CAUTION = 3.0  # one over the constant of M proposition 1; claim V20 measures sqrt(2)
NO_CONSTANT = "M theorem 2 needs C_N, which this pair does not have."
BOUNDS = ("unique_step", "stage_step", "fixed_point_step")
AT_A_STEP = {"exists": "unique_step", "converges": "fixed_point_step"}


def contracting_stages(space: Space, rule: Rule, square: float) -> tuple[float | None, str]:
    """The bound of H theorem 2.3.1, 1 / (|A_1^-1| C_L max_j |phi(c_j)|_1 |phi_p(c_j)|) in the norm
    of the largest entry, and at most 1, since lemma 2.3.2 asks for h < 1 in the unit of time; or
    None and the reason."""
    if not isinstance(space, Polynomials):
        return None, "H theorem 2.3.1 is for polynomials on their Chebyshev points."
    if not assemble(space, rule).well_posed:
        return None, "H lemma 2.3.1 needs A invertible; this pair is ill-posed."
    inverse, most = lagrange_constants(space, rule)
    product = inverse * square * most  # 0 with one point, at the step's end
    return 1.0 if product == 0.0 else min(1.0, 1.0 / product), ""


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


def motion_theory(
    space: Space, rule: Rule, pair: Mapping[str, Any], problem: Problem, step: float | None,
    lipschitz: float | None,
) -> dict[str, Any]:  # fmt: skip
    """The fields of a `Theory` that depend on the problem, and the reasons for those that are None.

    pair  the fields that depend on space and rule alone

    Raises ValueError for a space with degrees for components that the problem does not have.
    """
    checked_degrees(space, problem.system, problem.v0.size)
    found: dict[str, Any] = {}
    reasons: dict[str, str] = {}
    if pair["symmetric"] and not _commutes(problem.system):
        found["symmetric"] = None
        reasons["symmetric"] = (
            "on a group a step's chart is based at its start: forward and backward steps differ by "
            "an error of order 2 s + 1."
        )
    stiffness = _stiffness(problem, lipschitz)
    if isinstance(stiffness, str):
        reasons |= dict.fromkeys(("lipschitz", *BOUNDS, *AT_A_STEP), stiffness)
        return {**found, "reasons": reasons}
    constant, square = stiffness
    C, radius, frequency = pair["friedrichs"], pair["spectral_radius"], math.sqrt(square)
    stage_step, no_stages = contracting_stages(space, rule, square)
    found |= {
        "lipschitz": constant,
        "source": "at the start" if lipschitz is None else "given",
        "unique_step": None if C is None else Z0 / math.sqrt(CAUTION) / C / frequency,
        "stage_step": stage_step,
        "fixed_point_step": None if radius is None else math.inf,
    }
    if radius:
        found["fixed_point_step"] = 1.0 / (frequency * math.sqrt(radius))
    whys = NO_CONSTANT, no_stages, pair["reasons"].get("spectral_radius", "")
    reasons |= {name: why for name, why in zip(BOUNDS, whys, strict=True) if found[name] is None}
    for name, limit in AT_A_STEP.items():
        bound = found[limit]
        found[name] = None if bound is None or step is None else abs(step) < bound
        if found[name] is None:
            reasons[name] = "no step was given." if step is None else reasons[limit]
    return {**found, "reasons": reasons}


def _stiffness(problem: Problem, lipschitz: float | None) -> tuple[float, float] | str:
    """The Lipschitz constant K of dV/dq, given or that of the start, and the square of the largest
    frequency, at most K over the least mass; or why they are not known."""
    system: Any = problem.system
    if not hasattr(system, "acceleration_jacobian"):
        return (
            f"the theorems are for L = v.M v / 2 - V on a vector space, not for a "
            f"{type(system).__name__}."
        )
    if getattr(system, "force", None) is not None:
        return "the theorems are for forces that have a potential; here is one besides."
    d = problem.v0.size
    units = np.eye(d).reshape(-1, *problem.v0.shape)
    mass = np.array([np.ravel(system.momentum(unit)) for unit in units])
    if lipschitz is not None:
        return float(lipschitz), float(lipschitz / np.linalg.eigvalsh(mass)[0])
    jacobian = system.acceleration_jacobian(problem.q0, problem.t0).reshape(d, d)
    if not np.all(np.isfinite(jacobian)):
        return "the derivative of the force is not finite at the start."
    if not np.any(jacobian):
        return "the force does not change with position at the start. Give lipschitz."
    constant, square = (
        float(np.max(np.abs(np.linalg.eigvals(x)))) for x in (mass @ jacobian, jacobian)
    )
    return constant, square


def _commutes(system: Any) -> bool:
    """Whether the group is commutative, so that a chart's base does not matter."""
    layout = system.group.layout if hasattr(system, "group") else []
    return all(rotations == 0 or d == 1 for _, d, _, rotations in layout)

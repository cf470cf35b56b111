"""Order, exactness and symmetry of the method of a space and a rule, and its classical names."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import lru_cache

import numpy as np

from galvi.arrays import Array
from galvi.extended_precision import extended_precision
from galvi.rules.rule import Rule
from galvi.spaces.polynomials import legendre
from galvi.spaces.space import Space
from galvi.tableau import Tableau, assemble

ROUNDING_TOLERANCE = Decimal("1e-13")  # largest difference of equal numbers of about 1
SPACE, FORCE_RULE, KINETIC_RULE = "space", "rule for the force", "rule for the kinetic energy"
# Largest number of stages for which collocation matrices are computed in float64.
MAX_FLOAT_STAGES = 65
VERLET = ("Stormer-Verlet", "velocity Verlet", "leapfrog", "Newmark, beta = 0, gamma = 1/2")


@lru_cache(maxsize=256)
def exactness(space: Space, rule: Rule) -> int:
    """The highest degree, up to the rule's, to which the rule is exact for piecewise polynomials;
    -1 for none.

    For a space of one piece it is the rule's degree. Integrands of a space that is smooth only on
    each of ``pieces`` equal parts of [0, 1] are smooth there too, so moments are computed on each
    part; the weight of a node at a joint is divided such that both sides have the correct sum.
    """
    pieces = getattr(space, "pieces", 1)
    if pieces == 1:
        return rule.degree
    parts = _parts(rule, pieces)
    degree = -1
    with extended_precision():
        while degree < rule.degree and all(_integrates(part, degree + 1) for part in parts):
            degree += 1
    return degree


def _parts(rule: Rule, pieces: int) -> list[list[tuple[Decimal, Decimal]]]:
    """(position in [0, 1], weight) of the nodes on each piece; the weights sum to about 1."""
    parts: list[list[tuple[Decimal, Decimal]]] = [[] for _ in range(pieces)]
    with extended_precision():
        for node, weight in zip(rule.exact_nodes, rule.exact_weights, strict=True):
            position, share = node * pieces, weight * pieces
            joint = int(position.to_integral_value())
            if abs(position - joint) > ROUNDING_TOLERANCE or joint in (0, pieces):
                k = min(int(position), pieces - 1)
                parts[k].append((position - k, share))
                continue
            left = 1 - sum((w for _, w in parts[joint - 1]), Decimal(0))
            parts[joint - 1].append((Decimal(1), left))
            parts[joint].append((Decimal(0), share - left))
    return parts


def _integrates(part: list[tuple[Decimal, Decimal]], degree: int) -> bool:
    terms = (weight * position**degree if degree else weight for position, weight in part)
    moment = sum(terms, Decimal(0))
    exact = Fraction(1, degree + 1)
    return abs(moment - Decimal(exact.numerator) / Decimal(exact.denominator)) < ROUNDING_TOLERANCE


@dataclass(frozen=True)
class Orders:
    """Orders of a consistent method on smooth problems at a fixed final time; 0 for other pairs.

    Attributes
    ----------
    at_steps
        order of positions and momenta at step ends
    on_curve
        order of positions between them
    limit
        what limits at_steps: "space", "rule for the force" or "rule for the kinetic energy", the
        first of these if several do; "" when the order is 0
    """

    at_steps: int
    on_curve: int
    limit: str


@lru_cache(maxsize=256)
def orders(space: Space, rule: Rule) -> Orders:
    """The orders of the method of a space and a rule.

    With s the space's degree and g the rule's on each of its smooth pieces:

    at steps      min(2 s, g + 1, 2 (g - s) + 4): limits of the space, of the rule for the force
                  (Ober-Blobaum and Saake, Adv. Comput. Math. 41 (2015), section 4.2; claims V6,
                  V17, V22), and of the rule for the kinetic energy, whose degree is 2 s - 2; the
                  last is galvi's own result. A symmetric method has an even order, so an odd bound
                  is raised by one.
    on the curve  min(order at steps, s + 1, g - s + 3): the coefficient of degree s + 1 is missing
                  and those above degree g - s + 2 are wrong; galvi's own result.

    Straight lines, which a consistent method moves along, give at least the order 1, and 2 on the
    curve: the other bounds may be lower where a smooth space's pieces are not those of the rule.
    Functions beyond the polynomials of degree s change the constants, not the orders. With
    different degrees for components the order is that of the lowest. Both orders are tested from
    above and below in tests/properties/test_order.py.
    """
    assembly = assemble(space, rule)
    if assembly.table is None or not assembly.consistent:
        return Orders(0, 0, "")
    g = exactness(space, rule)
    degrees: Sequence[int] = getattr(space, "degrees", (space.degree,))
    bounds = {
        SPACE: 2 * min(degrees),
        FORCE_RULE: g + 1,
        KINETIC_RULE: min(2 * (g - s) + 4 for s in degrees),
    }
    limit = min(bounds, key=lambda name: bounds[name])
    order = max(bounds[limit], 1)
    if order % 2 and is_symmetric(assembly.table, rule):
        order += 1
    curve = min(order, *(min(s + 1, max(g - s + 3, 2)) for s in degrees))
    return Orders(order, curve, limit)


def is_symmetric(table: Tableau, rule: Rule) -> bool:
    """Whether a step forward and a step backward cancel on vector spaces.

    The adjoint's matrix A*_kj = A_kj - beta_j + (1 - c_k) b_j equals A with its stages reversed.
    """
    adjoint = table.A - table.beta + np.outer(1.0 - table.c, table.b)
    mirrored = np.allclose(adjoint, table.A[::-1, ::-1], rtol=0.0, atol=1e-13)
    return bool(mirrored and rule.symmetric)


def classical_names(table: Tableau, separable: bool) -> tuple[str, ...]:
    """Names of known methods with this tableau, the best known first.

    Parameters
    ----------
    separable
        whether to assume L = v M v / 2 - V(q, t) with a constant M. For any other L a method is a
        Runge-Kutta pair only if it has as many coefficients as points, since then its stage
        velocities are independent (Hairer, Lubich, Wanner, VI.6.2); with fewer, such as degree s
        with s + 1 Lobatto points, they are those of a curve

    Notes
    -----
    These are partitioned Runge-Kutta pairs a, a^ for positions and velocities, A = a a^: a is
    collocation at the nodes c, a_kj the integral over [0, c_k] of the Lagrange basis on c, and
    a^_kj = b_j (1 - a_jk / b_k) makes the pair symplectic (Hairer, Lubich, Wanner, Geometric
    Numerical Integration, II.1.4, IV.2.1, VI.4.1). At Gauss's nodes a^ = a, at Lobatto's it is
    IIIB. At Radau's it is IA from the left, whose a is Radau I, and II from the right, whose a is
    IIA (Hairer and Wanner, Solving ODEs II, IV.5). One stage at an end is symplectic Euler.
    """
    points, coefficients = table.slope.shape
    if points > coefficients and not separable:
        return ()
    names = _names(table.c, table.b, table.A)
    return names or _in_substeps(table)


def _names(c: Array, b: Array, A: Array) -> tuple[str, ...]:
    """Names of the collocation method with this tableau; () for none."""
    stages = c.size
    if stages > MAX_FLOAT_STAGES:
        return ()
    integrals = _integrals(c)
    partner = b * (1.0 - integrals.T / b[:, None])
    values = legendre(2.0 * c - 1.0, stages)
    P_s, P_below = values[:, stages], values[:, stages - 1]
    collocation = _same(b, _interpolatory(values[:, :stages])) and _same(A, integrals @ partner)
    if not collocation:
        return ()
    count = f"{stages} stages" if stages > 1 else "1 stage"
    if _same(P_s, 0.0 * P_s):
        first = ("implicit midpoint",) if stages == 1 else ()
        return (*first, f"Gauss collocation, {count}")
    if c[0] == 0.0 and c[-1] == 1.0 and _same(b, _lobatto_weights(c)):
        return (*(VERLET if stages == 2 else ()), f"Lobatto IIIA-IIIB, {count}")
    if c[-1] == 1.0 and _same(P_s, P_below):
        first = ("symplectic Euler, position first",) if stages == 1 else ()
        return (*first, f"Radau IIA-II, {count}")
    if c[0] == 0.0 and _same(P_s, -P_below):
        first = ("symplectic Euler, velocity first",) if stages == 1 else ()
        return (*first, f"Radau I-IA, {count}")
    return ()


def _in_substeps(table: Tableau) -> tuple[str, ...]:
    """Names of a method that consists of several equal steps of a known one; () for none."""
    c, b, A = table.c, table.b, table.A
    for steps in range(2, c.size + 1):
        stages = c.size // steps
        if c.size % steps == 0:
            substep = steps * c[:stages], steps * b[:stages], steps**2 * A[:stages, :stages]
            names = _names(*substep) if substep[0][-1] <= 1.0 else ()
            if names and all(map(_same, (c, b, A), _repeated(*substep, steps))):
                return tuple(f"{steps} steps of {name}" for name in names)
    return ()


def _repeated(c: Array, b: Array, A: Array, steps: int) -> tuple[Array, Array, Array]:
    """The tableau of ``steps`` equal steps of a method, with the total length as unit.

    The kick b_j at stage c_j acts on stage c_k of the d-th step after it for d + c_k - c_j steps.
    """
    stages = c.size
    first = np.arange(steps)
    lag = (first[:, None] - first[None, :])[:, None, :, None]
    felt = (lag + c[:, None, None] - c) * b
    blocks = np.where(lag > 0, felt, np.where(lag == 0, A[None, :, None, :], 0.0))
    matrix = blocks.reshape(steps * stages, steps * stages) / steps**2
    return (first[:, None] + c).ravel() / steps, np.tile(b, steps) / steps, matrix


def _integrals(c: Array) -> Array:
    """Integrals over [0, c_k] of the Lagrange basis on c, (s, s)."""
    stages = c.size
    values = legendre(2.0 * c - 1.0, stages)
    integrals = np.column_stack(
        [c] + [(values[:, i + 1] - values[:, i - 1]) / (2 * (2 * i + 1)) for i in range(1, stages)]
    )
    return integrals @ np.linalg.inv(values[:, :stages])


def _interpolatory(values: Array) -> Array:
    """Interpolatory weights at nodes with these values (s, s) of the Legendre polynomials."""
    return np.linalg.inv(values)[0]


def _lobatto_weights(c: Array) -> Array:
    n = c.size - 1
    return 1.0 / (n * (n + 1) * legendre(2.0 * c - 1.0, n)[:, n] ** 2)


def _same(left: Array, right: Array) -> bool:
    return bool(np.allclose(left, right, rtol=0.0, atol=1e-12))

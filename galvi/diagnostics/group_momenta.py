"""Momenta of rotations and translations of space, for bodies and points: factors of a Lie group.

A rotation Q of space takes a body's attitude R to Q R and a position x to Q x; a translation by c
does not change R and takes x to x + c. In the plane, Q is a matrix of SO(2).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from galvi.arrays import Array
from galvi.groups.group import SE2, SE3, SO2, SO3, Group, Rn
from galvi.groups.product import Product

IN_PLANE, IN_SPACE = (SO2(), SE2(), Rn(2)), (SO3(), SE3(), Rn(3))
MATRICES = (SO2, SE2, SO3, SE3)


class Factor(NamedTuple):
    """A factor of a group that is no product.

    Attributes
    ----------
    group
        the factor
    q
        elements (..., *group.shape)
    p
        their left-trivialised momenta (..., group.dimension)
    """

    group: Group
    q: Array
    p: Array


def factors(group: Group, q: Array, p: Array) -> list[Factor]:
    """The factors of a group, from elements q (..., *shape) and momenta p (..., dimension)."""
    if not isinstance(group, Product):
        return [Factor(group, q, p)]
    ends = np.cumsum([factor.dimension for factor in group.factors])[:-1]
    parts = zip(group.factors, group.parts(q), np.split(p, ends, axis=-1), strict=True)
    return [leaf for part in parts for leaf in factors(*part)]


def attitudes(group: Group, q: Array) -> list[Array]:
    """The rotation matrices (..., n, n), n = 2 or 3, of each factor that has rotations."""
    if isinstance(group, Product):
        parts = zip(group.factors, group.parts(q), strict=True)
        return [R for factor, part in parts for R in attitudes(factor, part)]
    n = 2 if group in IN_PLANE else 3
    return [q[..., :n, :n]] if isinstance(group, MATRICES) else []


def angular_momentum(group: Group, q: Array, p: Array) -> Array:
    """Sum over the factors of spin + x cross P about the origin, (...,) in the plane or (..., 3).

    The spin of a body is R mu, with mu the rotational part of its p (in the plane mu itself); that
    of a point is 0. x and P are position and linear momentum, see `linear_momentum`; a body without
    a position has no such term.

    Raises
    ------
    ValueError
        Unless each factor is a body or a point, all in the plane or all in space.
    """
    space = dimension_of_space(group)
    terms = []
    for factor in factors(group, q, p):
        if isinstance(factor.group, MATRICES):
            rotational = factor.p[..., : 2 * space - 3]
            terms.append(
                rotational[..., 0] if space == 2 else rotate_to_space(factor.q, rotational)
            )
        if not isinstance(factor.group, SO2 | SO3):
            terms.append(moment(*place_and_momentum(factor, space)))
    return sum(terms[1:], terms[0])


def linear_momentum(group: Group, q: Array, p: Array) -> Array:
    """The sum (..., 2 or 3) of the linear momenta of bodies and points with a position.

    That of a body is R mu with mu the translational part of its p, that of a point is p. A body on
    SO(2) or SO(3), which has no position, adds nothing.

    Raises
    ------
    ValueError
        Where no factor has a position, and as `angular_momentum`.
    """
    space = dimension_of_space(group)
    terms = [
        place_and_momentum(factor, space)[1]
        for factor in factors(group, q, p)
        if not isinstance(factor.group, SO2 | SO3)
    ]
    if not terms:
        raise ValueError(
            f"{group} has rotations only, on which translations of space do not act; use "
            f"galvi.momentum_map for the angular momentum, or a group with places such as "
            f"galvi.SE{space}()."
        )
    return sum(terms[1:], terms[0])


def place_and_momentum(factor: Factor, space: int) -> tuple[Array, Array]:
    """Position and linear momentum in space, (..., space), of a point, or a body on SE(2) or
    SE(3)."""
    if isinstance(factor.group, Rn):
        return factor.q, factor.p
    return factor.q[..., :space, space], rotate_to_space(factor.q, factor.p[..., 2 * space - 3 :])


def rotate_to_space(g: Array, mu: Array) -> Array:
    """R mu for bodies g (..., m, m) with R in their first rows, from mu (..., n), n = 2 or 3."""
    n = mu.shape[-1]
    return np.einsum("...ij,...j->...i", g[..., :n, :n], mu)


def moment(x: Array, P: Array) -> Array:
    """x cross P, (..., 3) in space; in the plane its component across the plane, (...)."""
    if x.shape[-1] == 2:
        return x[..., 0] * P[..., 1] - x[..., 1] * P[..., 0]
    return np.cross(x, P)


def dimension_of_space(group: Group) -> int:
    """2 or 3, the dimension of the space of all bodies and points of a group; ValueError where they
    do not share one, or where a factor is neither a body nor a point."""
    leaves = _leaves(group)
    for space, members in ((2, IN_PLANE), (3, IN_SPACE)):
        if all(leaf in members for leaf in leaves):
            return space
    unknown_factors = [leaf for leaf in leaves if leaf not in IN_PLANE + IN_SPACE]
    reason = (
        f"on {unknown_factors[0]} nothing says how space acts"
        if unknown_factors
        else "some factors are in the plane and some in space"
    )
    raise ValueError(
        f"momenta of rotations and translations need bodies and points that are all in the plane, "
        f"SO2, SE2 or Rn(2), or all in space, SO3, SE3 or Rn(3); received {group}: {reason}. "
        f"Compute them from run.q and run.p."
    )


def _leaves(group: Group) -> list[Group]:
    if not isinstance(group, Product):
        return [group]
    return [leaf for factor in group.factors for leaf in _leaves(factor)]

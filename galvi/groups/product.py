"""Direct products of groups: several bodies, or a body and a cart."""

from __future__ import annotations

from dataclasses import dataclass
from math import prod

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.groups.group import Group, Layout, is_group


@dataclass(frozen=True)
class Product:
    """factors[0] x factors[1] x ...; an element is a vector of the entries of all factors.

    ``join`` builds an element from one array for each factor, ``parts`` splits it; velocities are
    the concatenated velocities of the factors.

    Raises
    ------
    ValueError
        Unless factors are one or more groups.

    Examples
    --------
    >>> group = galvi.Product((galvi.SO3(), galvi.Rn(1)))
    >>> q = group.join(np.eye(3), np.array([0.5]))
    >>> q.shape, group.dimension, group.parts(q)[1]
    ((10,), 4, array([0.5]))
    """

    factors: tuple[Group, ...]

    def __post_init__(self) -> None:
        factors = self.factors if isinstance(self.factors, tuple | list) else ()
        if not factors or not all(is_group(factor) for factor in factors):
            raise ValueError(
                f"factors must be groups such as (galvi.SO3(), galvi.Rn(1)); received "
                f"{input_checks.shown(self.factors)}."
            )
        object.__setattr__(self, "factors", tuple(factors))

    @property
    def dimension(self) -> int:
        """The sum of the factors' dimensions."""
        return sum(factor.dimension for factor in self.factors)

    @property
    def shape(self) -> tuple[int, ...]:
        """(n,), n the total number of entries of the factors."""
        return (sum(prod(factor.shape) for factor in self.factors),)

    @property
    def layout(self) -> Layout:
        """The factors' layouts, concatenated."""
        return np.concatenate([factor.layout for factor in self.factors])

    def join(self, *parts: Array) -> Array:
        """The element with these parts, one for each factor; all may have the same leading axes.

        Raises
        ------
        ValueError
            For a wrong number of parts or a part of a wrong shape.
        """
        shapes = [factor.shape for factor in self.factors]
        if len(parts) != len(shapes):
            raise ValueError(
                f"join needs one part for each of the {len(shapes)} factors; received {len(parts)}."
            )
        arrays = [np.asarray(part) for part in parts]
        leads = []
        for i, (shape, part) in enumerate(zip(shapes, arrays, strict=True)):
            lead = max(part.ndim - len(shape), 0)
            if part.shape[lead:] != shape:
                raise ValueError(
                    f"part {i} must have shape {shape}, or that after leading axes, as an element "
                    f"of {self.factors[i]}; received shape {part.shape}."
                )
            leads.append(part.shape[:lead])
        if len(set(leads)) > 1:
            raise ValueError(f"parts must have the same leading axes; received {leads}.")
        return np.concatenate([part.reshape(*leads[0], -1) for part in arrays], axis=-1)

    def parts(self, g: Array) -> tuple[Array, ...]:
        """The elements of the factors, from elements with any leading axes."""
        ends = np.cumsum([prod(factor.shape) for factor in self.factors])[:-1]
        return tuple(
            flat.reshape(*flat.shape[:-1], *factor.shape)
            for factor, flat in zip(self.factors, np.split(g, ends, axis=-1), strict=True)
        )

    def check(self, name: str, g: Array) -> None:
        """ValueError unless every part is an element of its factor."""
        if g.shape != self.shape:
            raise ValueError(
                f"{name} must have shape {self.shape}, the entries of all factors; received shape "
                f"{g.shape}. Make it with Product.join."
            )
        for i, (factor, part) in enumerate(zip(self.factors, self.parts(g), strict=True)):
            factor.check(f"part {i} of {name}", part)

    def multiply(self, g: Array, k: Array) -> Array:
        """The products of the parts, factor by factor."""
        pairs = zip(self.factors, self.parts(g), self.parts(k), strict=True)
        return self.join(*(factor.multiply(left, right) for factor, left, right in pairs))

    def inverse(self, g: Array) -> Array:
        """The inverses of the parts, factor by factor."""
        pairs = zip(self.factors, self.parts(g), strict=True)
        return self.join(*(factor.inverse(part) for factor, part in pairs))

    def bracket(self, v: Array, w: Array) -> Array:
        """The brackets of the parts, factor by factor."""
        ends = np.cumsum([factor.dimension for factor in self.factors])[:-1]
        pairs = zip(self.factors, np.split(v, ends), np.split(w, ends), strict=True)
        return np.concatenate([factor.bracket(left, right) for factor, left, right in pairs])

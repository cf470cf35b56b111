"""Polynomials on [0, 1], of one degree or of one for each component."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only

MAX_DEGREE = 64  # also the largest number of pieces of a piecewise space


def legendre(x: Any, degree: int) -> Any:
    """P_0 .. P_degree at x of shape (k,), as an array (k, degree + 1).

    (l + 1) P_{l+1} = (2 l + 1) x P_l - l P_{l-1}; stable for x in [-1, 1].
    """
    columns = [x * 0 + 1, x]
    for n in range(1, degree):
        columns.append(((2 * n + 1) * x * columns[n] - n * columns[n - 1]) / (n + 1))
    return np.stack(columns[: degree + 1], axis=-1)


def integrals(t: Any, count: int) -> Any:
    """The integrals of P_0(2 s - 1) .. P_{count - 1}(2 s - 1) over s in [0, t], (k, count).

    t of shape (k,); the integral of P_l is (P_{l+1} - P_{l-1})(2 t - 1) / (2 (2 l + 1)).
    """
    P = legendre(2 * t - 1, count)
    columns = [t]
    for n in range(1, count):
        columns.append((P[:, n + 1] - P[:, n - 1]) / (2 * (2 * n + 1)))
    return np.stack(columns[:count], axis=-1)


@dataclass(frozen=True)
class Polynomials:
    """Polynomials of at most this degree, 1 to 64, on [0, 1].

    phi_0 = 1 and phi_i(t) = integral of P_{i-1}(2 s - 1) over s in [0, t], so that the derivatives
    are orthogonal. H calls n = degree + 1 the number of basis functions.

    Raises
    ------
    ValueError
        For a degree outside 1 to 64.

    Examples
    --------
    >>> space = galvi.Polynomials(3)
    >>> space.dimension, space.basis(np.array([0.0, 1.0])).round(12)
    (4, array([[1., 0., 0., 0.],
           [1., 1., 0., 0.]]))
    """

    degree: int
    exact: ClassVar[bool] = True  # basis and derivative work in decimals

    def __post_init__(self) -> None:
        object.__setattr__(self, "degree", input_checks.whole("degree", self.degree, 1, MAX_DEGREE))

    @property
    def dimension(self) -> int:
        """degree + 1."""
        return self.degree + 1

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), (k, degree + 1), for t of shape (k,)."""
        return np.concatenate([t[:, None] * 0 + 1, integrals(t, self.degree)], axis=1)

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k) = P_{i-1}(2 t_k - 1), (k, degree + 1)."""
        P = legendre(2 * t - 1, self.degree)
        return np.concatenate([P[:, :1] * 0, P[:, :-1]], axis=1)

    @property
    def nodes(self) -> Array:
        """The degree + 1 Chebyshev points of H 2.2, increasing from 0 to 1."""
        angles = np.arange(self.degree + 1) * (np.pi / self.degree)
        return read_only(np.sin(0.5 * angles) ** 2)

    def lagrange(self, t: Any) -> Array:
        """The Lagrange basis on ``nodes`` at t of shape (k,), as (k, degree + 1).

        Barycentric formula of the second kind (Berrut and Trefethen, SIAM Rev. 46 (2004), 4.2 and
        5.4); it reproduces every polynomial of the space from its nodal values.
        """
        weights = (-1.0) ** np.arange(self.degree + 1)
        weights[[0, -1]] *= 0.5
        gap = np.asarray(t, dtype=np.float64)[:, None] - self.nodes[None, :]
        is_node = (gap == 0.0).astype(np.float64)
        on_node = is_node.any(axis=1, keepdims=True)
        terms = np.where(on_node, is_node, weights / np.where(on_node, 1.0, gap))
        return terms / np.sum(terms, axis=1, keepdims=True)


@dataclass(frozen=True)
class ComponentPolynomials:
    """Component i of a configuration is a polynomial of degree degrees[i] (H after thm 2.3.5).

    Parameters
    ----------
    degrees
        a degree for each component, at least 1

    Raises
    ------
    ValueError
        Unless each degree is a whole number of at least 1; `Galerkin` refuses more than 64.

    Notes
    -----
    Component i uses the first degrees[i] + 1 basis functions of `Polynomials`: the stage equations
    have sum(degrees) unknowns. The method is symplectic; but since a rotation mixes components,
    angular momentum is conserved only approximately where degrees differ.

    Examples
    --------
    >>> space = galvi.ComponentPolynomials((4, 2))
    >>> galvi.Galerkin(space, galvi.gauss(4)).order
    4
    """

    degrees: tuple[int, ...]
    exact: ClassVar[bool] = True

    def __post_init__(self) -> None:
        entries = () if isinstance(self.degrees, str) else self.degrees
        degrees = tuple(entries) if input_checks.has_items(entries) else ()
        if not degrees:
            raise ValueError(
                f"degrees must be whole numbers, one for each component, as in (8, 3); received "
                f"{input_checks.shown(self.degrees)}."
            )
        object.__setattr__(
            self,
            "degrees",
            tuple(input_checks.whole("each of degrees", degree) for degree in degrees),
        )

    @property
    def degree(self) -> int:
        """The lowest of the degrees."""
        return min(self.degrees)

    @property
    def dimension(self) -> int:
        """max(degrees) + 1, the dimension of ``largest``."""
        return self.largest.dimension

    @property
    def largest(self) -> Polynomials:
        """The space of the component with the highest degree."""
        return Polynomials(max(self.degrees))

    def basis(self, t: Any) -> Any:
        """As Polynomials(max(degrees)), (k, max(degrees) + 1)."""
        return self.largest.basis(t)

    def derivative(self, t: Any) -> Any:
        """As Polynomials(max(degrees)), (k, max(degrees) + 1)."""
        return self.largest.derivative(t)

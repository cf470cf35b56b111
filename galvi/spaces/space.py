"""Interface of function spaces."""

from __future__ import annotations

from collections.abc import Hashable
from typing import Any, Protocol


class Space(Hashable, Protocol):
    """Functions on [0, 1]; values are given for t of shape (k,) as arrays (k, dimension).

    The first basis function is the constant 1. When ``exact`` is set, both functions also work on
    arrays of `decimal.Decimal`, and the method's table is then correct to the last bit.
    """

    @property
    def dimension(self) -> int:
        """Number of basis functions, the constant included."""

    @property
    def degree(self) -> int:
        """The highest degree of polynomials that the space contains."""

    @property
    def exact(self) -> bool:
        """Whether basis and derivative work in exact decimals."""

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), shape (k, dimension)."""

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), shape (k, dimension)."""

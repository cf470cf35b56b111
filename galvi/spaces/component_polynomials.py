"""Polynomials with a degree for each component: high where motion is fast, low where it is slow."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from galvi import input_checks
from galvi.spaces.polynomials import Polynomials


@dataclass(frozen=True)
class ComponentPolynomials:
    """Component i of a configuration is a polynomial of degree degrees[i] (H after thm 2.3.5).

    degrees  one for each component, at least 1

    Component i uses the first degrees[i] + 1 basis functions of Polynomials: the stage equations
    have sum(degrees) unknowns. Symplectic like every method; but since a rotation mixes components,
    angular momentum is conserved only approximately when their degrees differ. Raises ValueError
    unless each degree is a whole number of at least 1; `Galerkin` refuses more than 64.
    """

    degrees: tuple[int, ...]

    def __post_init__(self) -> None:
        given = () if isinstance(self.degrees, str) else self.degrees
        degrees = tuple(given) if input_checks.has_items(given) else ()
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
        """max(degrees) + 1, that of the largest component."""
        return self.largest.dimension

    @property
    def exact(self) -> bool:
        """True: basis and derivative work in decimals."""
        return self.largest.exact

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

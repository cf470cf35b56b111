"""The interface of function spaces on [0, 1], and checks of a user's space."""

from __future__ import annotations

from collections.abc import Hashable
from functools import lru_cache
from typing import Any, Protocol, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import decimals, extended_precision
from galvi.kernels.constants import INVERSE_GOLDEN_RATIO
from galvi.spaces.polynomials import legendre

MEMBERS = ("dimension", "degree", "exact", "basis", "derivative")
BASIS_DIFFERENCE = 1e-6  # share of a step over which a basis is differenced
DERIVATIVE_TOLERANCE = 1e-4  # relative to the largest slope; galvi's own spaces need 2.5e-6
DECIMALS_TOLERANCE = 1e-10  # of decimals against floats; galvi's own spaces need 5e-15
POLYNOMIAL_TOLERANCE = 1e-9  # of fitted polynomials; galvi's own spaces need 4e-13


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
        """Whether basis and derivative work on arrays of `decimal.Decimal`."""

    def basis(self, t: Any) -> Any:
        """phi_i(t_k), shape (k, dimension)."""

    def derivative(self, t: Any) -> Any:
        """phi_i'(t_k), shape (k, dimension)."""


def checked(space: Any) -> Space:
    """``space`` itself if it satisfies the protocol; exceptions that its functions raise for floats
    pass through.

    Raises
    ------
    TypeError
        For a missing attribute and for a space that is not hashable.
    ValueError
        For a wrong dimension or degree, for functions of a wrong shape or that are not finite, and
        for a basis that does not match its derivative, degree or ``exact``.
    """
    missing = [name for name in MEMBERS if not hasattr(space, name)]
    if missing:
        raise TypeError(
            f"a space must have {', '.join(MEMBERS)}; {space!r} lacks {', '.join(missing)}. See "
            f"docs/tutorials/own_space.md for a space in twenty lines."
        )
    try:
        hash(space)
    except TypeError as error:
        raise TypeError(
            f"a space must be hashable, since tables are cached by it; {type(space).__name__} is "
            f"not ({error}). Make it a frozen dataclass of numbers."
        ) from error
    _check(space)
    return cast(Space, space)


@lru_cache(maxsize=128)
def _check(space: Any) -> None:
    name = type(space).__name__
    dimension = input_checks.whole(f"dimension of {name}", space.dimension, 2)
    degree = input_checks.whole(f"degree of {name}", space.degree, 0, dimension - 1)
    input_checks.flag(f"exact of {name}", space.exact)
    t = np.append(
        (np.arange(1, 4 * dimension + 1) * INVERSE_GOLDEN_RATIO) % (1 - BASIS_DIFFERENCE),
        [0.0, 1.0],
    )
    basis = _values(space, "basis", t, dimension)
    slopes = _values(space, "derivative", t, dimension)
    if np.max(np.abs(basis[:, 0] - 1)) > 1e-14:
        worst = basis[np.argmax(np.abs(basis[:, 0] - 1)), 0]
        raise ValueError(
            f"the first basis function of a space must be the constant 1; that of {name} takes the "
            f"value {worst:.6g}. Put the constant first."
        )
    _check_derivative(space, name, t[:-2], slopes[:-2])
    _check_degree(name, degree, basis, legendre(2 * t - 1, degree))
    if space.exact:
        indices = [0, 1, 2, -2, -1]  # three inside and both ends
        _check_decimals(space, name, t[indices], basis[indices], slopes[indices])


def _values(space: Any, function: str, t: Array, dimension: int) -> Array:
    for points in (t[:1], t):
        values = np.asarray(getattr(space, function)(points))
        expected = (points.size, dimension)
        if values.shape != expected or values.dtype.kind not in "iuf":
            raise ValueError(
                f"{function} of {type(space).__name__} must return real numbers of shape "
                f"(k, dimension), {expected} for t of shape ({points.size},); received shape "
                f"{values.shape} of type {values.dtype}."
            )
    bad = np.argwhere(~np.isfinite(values))
    if bad.size:
        k, i = bad[0]
        raise ValueError(
            f"{function} of {type(space).__name__} must be finite on [0, 1]; received "
            f"{values[k, i]} for function {i} at t = {t[k]:.6g}."
        )
    return cast(Array, values)


def _check_derivative(space: Any, name: str, t: Array, slopes: Array) -> None:
    rise = np.asarray(space.basis(t + BASIS_DIFFERENCE)) - np.asarray(space.basis(t))
    middle = np.asarray(space.derivative(t + 0.5 * BASIS_DIFFERENCE))
    gap = np.max(np.abs(rise / BASIS_DIFFERENCE - middle), axis=0)
    wrong = np.argwhere(gap > DERIVATIVE_TOLERANCE * max(1.0, float(np.max(np.abs(slopes)))))
    if wrong.size:
        i = wrong[0, 0]
        raise ValueError(
            f"derivative of {name} must be that of its basis; function {i} differs from its "
            f"difference quotient by {gap[i]:.3g}."
        )


def _check_degree(name: str, degree: int, basis: Array, polynomials: Array) -> None:
    fitted = basis @ np.linalg.lstsq(basis, polynomials, rcond=None)[0]
    gap = np.max(np.abs(fitted - polynomials), axis=0)
    beyond = np.argwhere(gap > POLYNOMIAL_TOLERANCE)
    if beyond.size:
        first = int(beyond[0, 0])
        raise ValueError(
            f"{name} must contain all polynomials of its degree, {degree}; it lacks one of degree "
            f"{first}, by {gap[first]:.1e} in floats. Say degree = {first - 1}, add "
            f"functions, or choose a better conditioned basis of them."
        )


def _check_decimals(space: Any, name: str, t: Array, basis: Array, slopes: Array) -> None:
    with extended_precision():
        for function, floats in (("basis", basis), ("derivative", slopes)):
            try:
                values = np.asarray(getattr(space, function)(decimals(t)))
                gap = float(np.max(np.abs(values.astype(np.float64) - floats)))
            except (ArithmeticError, AttributeError, TypeError, ValueError) as error:
                raise ValueError(
                    f"exact of {name} must be False unless its functions work on arrays of "
                    f"decimal.Decimal; {function} does not ({error})."
                ) from error
            if values.dtype != object or not gap <= DECIMALS_TOLERANCE * max(
                1.0, float(np.max(np.abs(floats)))
            ):
                raise ValueError(
                    f"exact of {name} must be False unless its functions keep decimals; {function} "
                    f"returns {values.dtype} and differs by {gap:.1e} from its values for floats."
                )

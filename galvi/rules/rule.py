"""Quadrature rules on [0, 1]: `Rule`, and its families as functions of the number of points."""

from __future__ import annotations

from dataclasses import dataclass
from decimal import Decimal
from fractions import Fraction
from functools import cached_property, lru_cache
from typing import Any

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.extended_precision import PI, cosine, decimals, extended_precision, rounded
from galvi.input_checks import shown
from galvi.spaces.polynomials import legendre

MAX_RULE_POINTS = 1000  # takes 10 s in extended precision
MAX_EQUIDISTANT_POINTS = 8  # with 9 points a weight is negative
MAX_PIECES = 10_000  # takes seconds in extended precision
# Largest error of the integral of a Legendre polynomial; 2e-15 for up to 200 points.
EXACTNESS_TOLERANCE = 1e-12


@dataclass(frozen=True)
class Rule:
    """sum_j weights_j f(nodes_j), exact for polynomials of at most ``degree``.

    Parameters
    ----------
    name
        e.g. "Gauss 4"
    degree
        degree of exactness, at least 0; checked to 1e-12
    exact_nodes
        decimals in [0, 1], increasing (floats are converted exactly)
    exact_weights
        decimals, positive, with sum 1 to 1e-13

    Raises
    ------
    ValueError
        For numbers that are not a rule of this degree; the message names the violated identity.

    Examples
    --------
    >>> rule = galvi.Rule("midpoint", degree=1, exact_nodes=(0.5,), exact_weights=(1.0,))
    >>> rule.points, rule.nodes, rule.symmetric
    (1, array([0.5]), True)
    """

    name: str
    degree: int
    exact_nodes: tuple[Decimal, ...]
    exact_weights: tuple[Decimal, ...]

    def __post_init__(self) -> None:
        if not isinstance(self.name, str):
            raise ValueError(f"name of a rule must be a text; received {shown(self.name)}.")
        object.__setattr__(self, "degree", input_checks.whole("degree of a rule", self.degree, 0))
        for field in ("exact_nodes", "exact_weights"):
            object.__setattr__(self, field, _row(field, getattr(self, field)))
        self._check()
        self._check_degree()

    @property
    def points(self) -> int:
        """Number of nodes."""
        return len(self.exact_nodes)

    @cached_property
    def nodes(self) -> Array:
        """(points,) float64, in [0, 1]."""
        return rounded(self.exact_nodes)

    @cached_property
    def weights(self) -> Array:
        """(points,) float64."""
        return rounded(self.exact_weights)

    @property
    def symmetric(self) -> bool:
        """Whether nodes and weights are mirrored about 1/2."""
        mirrored = np.allclose(self.nodes, 1.0 - self.nodes[::-1], rtol=0.0, atol=1e-15)
        return bool(mirrored and np.allclose(self.weights, self.weights[::-1], atol=1e-15))

    def __repr__(self) -> str:
        return f"Rule({self.name!r})"

    def _check(self) -> None:
        nodes, weights = self.nodes, self.weights
        if nodes.size == 0 or nodes.size != weights.size:
            raise ValueError(
                f"a rule must have one weight for each node, and at least one; received "
                f"{nodes.size} nodes and {weights.size} weights."
            )
        if np.any(np.diff(nodes) <= 0.0) or nodes[0] < 0.0 or nodes[-1] > 1.0:
            raise ValueError(
                f"nodes of a rule must increase inside [0, 1]; received {nodes.tolist()}."
            )
        if np.any(weights <= 0.0):
            raise ValueError(
                f"weights of a rule must be positive; received {float(weights.min())}. "
                f"Choose a rule of another family or with fewer points."
            )
        with extended_precision():
            total = sum(self.exact_weights, Decimal(0))
        if abs(total - 1) > Decimal("1e-13"):
            raise ValueError(f"weights of a rule on [0, 1] must sum to 1; received {total:.16f}.")

    def _check_degree(self) -> None:
        highest = 2 * self.points - 1
        if self.degree > highest:
            raise ValueError(
                f"degree of a rule with {self.points} points must be at most {highest}, which "
                f"Gauss's rule has; received {self.degree}."
            )
        defects = np.abs(self.weights @ legendre(2.0 * self.nodes - 1.0, self.degree)[:, 1:])
        wrong = np.flatnonzero(defects > EXACTNESS_TOLERANCE)
        if wrong.size:
            first = int(wrong[0]) + 1
            raise ValueError(
                f"a rule must integrate all polynomials of its degree, {self.degree}; {self.name} "
                f"misses one of degree {first} by {defects[first - 1]:.1e}. Say degree = "
                f"{first - 1}, or correct the nodes and weights."
            )


def _row(field: str, values: Any) -> tuple[Decimal, ...]:
    """The values as decimals; ValueError unless they are finite numbers in one row."""
    try:
        numbers = np.asarray(values)
        real = numbers.dtype.kind in "iufO"  # O: decimals
        finite = real and bool(np.all(np.isfinite(numbers.astype(np.float64))))
        row = tuple(decimals(numbers)) if finite and numbers.ndim == 1 else None
    except (TypeError, ValueError, OverflowError):  # also of a date, which numpy takes for a number
        row = None
    if row is None:
        raise ValueError(
            f"{field} of a rule must be finite numbers in one row; received {shown(values)}."
        )
    return row


def number_of_points(value: Any, at_least: int = 1) -> int:
    """A number of points as an int; ValueError unless a whole number from ``at_least`` to 1000."""
    number = input_checks.whole("points", value, at_least)
    if number > MAX_RULE_POINTS:
        raise ValueError(
            f"points must be a whole number from {at_least} to {MAX_RULE_POINTS}; "
            f"received {shown(value)}. For "
            f"more points use galvi.composite(galvi.gauss(8), pieces)."
        )
    return number


def from_interval(name: str, degree: int, x: Any, w: Any) -> Rule:
    """The rule on [0, 1] from decimal nodes x and weights w on [-1, 1]."""
    return Rule(name, degree, tuple((1 + x) / 2), tuple(w / 2))


def gauss(points: int) -> Rule:
    """The rule with the highest degree of exactness, 2 points - 1; its nodes are the zeros of P_n.

    Parameters
    ----------
    points : int
        number of nodes, 1 to 1000

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    ValueError
        When points is not a whole number from 1 to 1000.

    Examples
    --------
    >>> rule = galvi.gauss(2)
    >>> rule.degree, float((rule.weights @ rule.nodes**3).round(15))
    (3, 0.25)
    """
    return _gauss(number_of_points(points))


@lru_cache(maxsize=256)
def _gauss(n: int) -> Rule:
    with extended_precision():
        x = decimals(np.polynomial.legendre.leggauss(n)[0])
        for _ in range(3):  # Newton: 16, 32, 64 digits
            P = legendre(x, n)
            slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
            x = x - P[:, n] / slope
        P = legendre(x, n)
        slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
        return from_interval(f"Gauss {n}", 2 * n - 1, x, 2 / ((1 - x * x) * slope * slope))


def lobatto(points: int) -> Rule:
    """The Gauss-Lobatto rule, whose nodes include both ends, of degree 2 points - 3.

    The inner nodes are the zeros of P_n', n = points - 1.

    Parameters
    ----------
    points : int
        number of nodes, 2 to 1000

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    ValueError
        When points is not a whole number from 2 to 1000.

    Examples
    --------
    >>> galvi.lobatto(3).nodes, galvi.lobatto(3).degree
    (array([0. , 0.5, 1. ]), 3)
    """
    return _lobatto(number_of_points(points, at_least=2))


@lru_cache(maxsize=256)
def _lobatto(points: int) -> Rule:
    from scipy.special import roots_jacobi

    n = points - 1
    with extended_precision():
        x = decimals(roots_jacobi(n - 1, 1.0, 1.0)[0] if n > 1 else [])
        for _ in range(3):  # Newton on P_n', with P_n'' from Legendre's equation
            P = legendre(x, n)
            slope = n * (x * P[:, n] - P[:, n - 1]) / (x * x - 1)
            curvature = (2 * x * slope - n * (n + 1) * P[:, n]) / (1 - x * x)
            x = x - slope / curvature
        x = np.concatenate([decimals([-1.0]), x, decimals([1.0])])
        weights = 2 / (n * (n + 1) * legendre(x, n)[:, n] ** 2)
        return from_interval(f"Lobatto {points}", 2 * points - 3, x, weights)


def radau(points: int, left: bool = False) -> Rule:
    """The rule with one end point as a node and degree 2 points - 2; with ``left`` unset its nodes
    are those of Radau IIA.

    Parameters
    ----------
    points : int
        number of nodes, 1 to 1000
    left : bool
        whether the end point is 0 (as in Radau I and IA) instead of 1

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    ValueError
        When points is not a whole number from 1 to 1000.

    Notes
    -----
    The nodes are mirrored zeros of P_{n-1} + P_n, n = points.

    Examples
    --------
    >>> galvi.radau(2).nodes.round(6), galvi.radau(2, left=True).nodes.round(6)
    (array([0.333333, 1.      ]), array([0.      , 0.666667]))
    """
    input_checks.flag("left", left)
    return _radau(number_of_points(points), bool(left))


@lru_cache(maxsize=256)
def _radau(n: int, left: bool) -> Rule:
    from scipy.special import roots_jacobi

    with extended_precision():
        x = decimals(roots_jacobi(n - 1, 0.0, 1.0)[0] if n > 1 else [])
        for _ in range(3):  # Newton on (P_{n-1} + P_n) / (1 + x): 16, 32, 64 digits
            P = legendre(x, n)
            value, slope = P[:, n - 1] + P[:, n], n * (P[:, n - 1] - P[:, n]) / (1 - x)
            x = x - value / (slope - value / (1 + x))
        x = np.concatenate([decimals([-1.0]), x])
        weights = (1 - x) / (n * legendre(x, n)[:, n - 1]) ** 2
        name = f"Radau {n}, from the left" if left else f"Radau {n}"
        if not left:
            x, weights = -x[::-1], weights[::-1]
        return from_interval(name, 2 * n - 2, x, weights)


def clenshaw_curtis(points: int) -> Rule:
    """The interpolatory rule on the Chebyshev points cos(j pi / (points - 1)).

    Its degree is points - 1, one more for an odd number of points; with one point, the midpoint
    rule.

    Parameters
    ----------
    points : int
        number of nodes, 1 to 1000

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    ValueError
        When points is not a whole number from 1 to 1000.

    Examples
    --------
    >>> galvi.clenshaw_curtis(5).degree, galvi.clenshaw_curtis(5).nodes.round(4)
    (5, array([0.    , 0.1464, 0.5   , 0.8536, 1.    ]))
    """
    return _clenshaw_curtis(number_of_points(points))


@lru_cache(maxsize=256)
def _clenshaw_curtis(points: int) -> Rule:
    n = points - 1
    name = f"Clenshaw-Curtis {points}"
    with extended_precision():
        if n == 0:
            return from_interval(name, 1, decimals([0.0]), decimals([2.0]))
        cosines = decimals([float(n)] * (n + 1))
        for j in range(n + 1):  # cos(j pi / n), mirrored so that the rule is symmetric to the bit
            k = min(j, n - j)
            value = cosine(PI * k / n) if 2 * k != n else Decimal(0)
            cosines[j] = value if j == k else -value
        terms = np.arange(1, n // 2 + 1)
        share = decimals(np.where(2 * terms == n, 1.0, 2.0)) / (4 * terms * terms - 1)
        turn = np.outer(np.arange(n + 1), 2 * terms) % (2 * n)
        weights = (1 - cosines[np.where(turn > n, 2 * n - turn, turn)] @ share) * 2 / n
        weights[[0, -1]] /= 2
        degree = n + 1 if n % 2 == 0 else n
        return from_interval(name, degree, -cosines, weights)


def newton_cotes(points: int) -> Rule:
    """The interpolatory rule on ``points`` equally spaced nodes, including both ends.

    Its degree is points - 1, one more for an odd number of points; two points give the trapezoidal
    rule, three Simpson's. With 9 points, and with 11 or more, some weights are negative.

    Parameters
    ----------
    points : int
        number of nodes, 2 to 8

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    ValueError
        When points is not a whole number from 2 to 8.

    Examples
    --------
    >>> (galvi.newton_cotes(3).weights * 6).round(12)  # Simpson's rule
    array([1., 4., 1.])
    """
    number = input_checks.whole("points", points, 2)
    if number > MAX_EQUIDISTANT_POINTS:
        raise ValueError(
            f"points must be a whole number from 2 to {MAX_EQUIDISTANT_POINTS}, since the closed "
            f"Newton-Cotes rule with 9 points is the first with a negative weight; "
            f"received {number}. Use gauss, lobatto or clenshaw_curtis, or "
            f"composite(newton_cotes(5), pieces)."
        )
    return _newton_cotes(number)


@lru_cache(maxsize=16)
def _newton_cotes(points: int) -> Rule:
    n = points - 1
    with extended_precision():
        nodes = tuple(Decimal(j) / n for j in range(points))
        integrals = (_lagrange_integral(j, n) for j in range(points))
        weights = tuple(
            Decimal(integral.numerator) / Decimal(integral.denominator) for integral in integrals
        )
        degree = points if points % 2 else n
        return Rule(f"Newton-Cotes {points}", degree, nodes, weights)


def _lagrange_integral(j: int, n: int) -> Fraction:
    """Integral over x in [0, n], divided by n, of the product of (x - i) / (j - i) over i != j."""
    product = np.array([Fraction(1)])
    for i in range(n + 1):
        if i != j:
            product = np.convolve(product, np.array([Fraction(-i, j - i), Fraction(1, j - i)]))
    total = sum((c * Fraction(n) ** k / (k + 1) for k, c in enumerate(product)), Fraction(0))
    return Fraction(total)


def composite(rule: Rule, pieces: int) -> Rule:
    """``rule`` on each of ``pieces`` equal parts of [0, 1], with the same degree.

    A rule with both end points has ``pieces * (points - 1) + 1`` nodes: at a joint the last node of
    one piece is the first of the next, and their weights are added. One piece is the rule itself.

    Parameters
    ----------
    rule : galvi.Rule
        the rule on one piece
    pieces : int
        number of equal parts, at least 1

    Returns
    -------
    galvi.Rule
        nodes and weights on [0, 1]

    Raises
    ------
    TypeError
        When rule is not a `Rule`.
    ValueError
        When pieces is not a whole number from 1 to 10,000.

    Examples
    --------
    >>> galvi.composite(galvi.gauss(1), 4).nodes
    array([0.125, 0.375, 0.625, 0.875])
    """
    if not isinstance(rule, Rule):
        raise TypeError(f"rule must be a rule such as galvi.gauss(8); received {shown(rule)}.")
    number = input_checks.whole("pieces", pieces, 1, MAX_PIECES)
    return rule if number == 1 else _composite(rule, number)


@lru_cache(maxsize=256)
def _composite(rule: Rule, pieces: int) -> Rule:
    nodes: list[Decimal] = []
    weights: list[Decimal] = []
    closed = rule.exact_nodes[0] == 0 and rule.exact_nodes[-1] == 1
    with extended_precision():
        scaled_weights = tuple(weight / pieces for weight in rule.exact_weights)
        for piece in range(pieces):
            first = 1 if closed and piece > 0 else 0
            if first:
                weights[-1] += scaled_weights[0]
            nodes += [(piece + node) / pieces for node in rule.exact_nodes[first:]]
            weights += scaled_weights[first:]
    name = f"{rule.name} on {pieces} pieces"
    return Rule(name, rule.degree, tuple(nodes), tuple(weights))

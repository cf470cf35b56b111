"""Polynomials, quadrature rules and norms on a step, from numpy alone, for claims on theory.

Functions are rows of coefficients of Legendre polynomials in 2 t - 1, t in [0, 1].
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from galvi.arrays import Array


def gauss_points(n: int) -> tuple[Array, Array]:
    """Nodes and weights of Gauss's rule on [0, 1]."""
    x, w = legendre.leggauss(n)
    return 0.5 * (1.0 + x), 0.5 * w


def lobatto_points(n: int) -> tuple[Array, Array]:
    """Nodes and weights of Lobatto's rule on [0, 1], n at least 2."""
    last = np.eye(n)[n - 1]
    x = np.concatenate([[-1.0], np.sort(legendre.legroots(legendre.legder(last)).real), [1.0]])
    w = 2.0 / (n * (n - 1) * legendre.legval(x, last) ** 2)
    return 0.5 * (1.0 + x), 0.5 * w


def values(functions: Array, t: Array) -> Array:
    """Values at t, (functions, times)."""
    return np.asarray(legendre.legval(2.0 * t - 1.0, functions.T))


def slopes(functions: Array, t: Array) -> Array:
    """Their derivatives by t, (functions, times)."""
    return np.asarray(2.0 * legendre.legval(2.0 * t - 1.0, legendre.legder(functions.T)))


def all_of_degree(degree: int) -> Array:
    """Legendre polynomials up to this degree, as functions."""
    return np.eye(degree + 1)


def lagrange_at_chebyshev(degree: int) -> Array:
    """H's basis: Lagrange polynomials on the Chebyshev points of [0, 1], from 0 to 1."""
    points = 0.5 * (1.0 - np.cos(np.pi * np.arange(degree + 1) / degree))
    return np.linalg.inv(values(all_of_degree(degree), points)).copy()


@dataclass(frozen=True, eq=False)
class Grams:
    """Gram matrices of functions u_i on a step of length 1, by a quadrature rule.

    place   sum_j b_j u_i u_l
    slope   sum_j b_j u_i' u_l'
    energy  slope plus u_i(1) u_l(1): M's |u|_X^2
    """

    place: Array
    slope: Array
    energy: Array


def grams(functions: Array, t: Array, b: Array) -> Grams:
    """The Gram matrices with a rule's nodes t and weights b."""
    u, du, end = values(functions, t), slopes(functions, t), values(functions, np.ones(1))
    slope = (du * b) @ du.T
    return Grams((u * b) @ u.T, slope, slope + end @ end.T)

"""Spaces of functions by numpy alone: values, slopes, Gram matrices, constants."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np
from numpy.polynomial import legendre
from scipy.linalg import eigvalsh, null_space
from scipy.optimize import brentq

from galvi.arrays import Array

# Function spaces in plain numpy, by textbook formulas: values and slopes on [0, 1].
#
# Each space is a list of pairs (u, u'); they span the same functions as galvi's space of that name.

Function = Callable[[Array], Array]
Functions = list[tuple[Function, Function]]


def powers(degree: int) -> Functions:
    """1, t, .. t^degree."""
    return [_power(k, 0.0) for k in range(degree + 1)]


def waves(harmonics: int, frequency: float = 2.0 * np.pi) -> Functions:
    """cos k w t and sin k w t."""
    return [pair for k in range(1, harmonics + 1) for pair in _wave(k * frequency)]


def broken_powers(degree: int, pieces: int, smooth: int) -> Functions:
    """Polynomials of this degree on each piece, with ``smooth`` continuous derivatives.

    They are powers, and (t - k / pieces)_+^j, j = smooth + 1 .. degree, at each joint k / pieces,
    where the slope is the right-hand one.
    """
    joints = [k / pieces for k in range(1, pieces)]
    return powers(degree) + [
        _power(j, joint) for joint in joints for j in range(smooth + 1, degree + 1)
    ]


def table(functions: Functions, t: Array) -> tuple[Array, Array]:
    """Values and slopes, (times, functions) each."""
    values_and_slopes = [(u(t), du(t)) for u, du in functions]
    return np.stack([u for u, _ in values_and_slopes], axis=1), np.stack(
        [du for _, du in values_and_slopes], axis=1
    )


def _power(k: int, start: float) -> tuple[Function, Function]:
    def value(t: Array) -> Array:
        return np.where(t >= start, (t - start) ** k, 0.0)

    def slope(t: Array) -> Array:
        return np.where(t >= start, k * (t - start) ** max(k - 1, 0), 0.0)

    return value, slope


def _wave(w: float) -> Functions:
    return [
        (lambda t: np.cos(w * t), lambda t: -w * np.sin(w * t)),
        (lambda t: np.sin(w * t), lambda t: w * np.cos(w * t)),
    ]


# Polynomials, rules, norms and M's constants on a step, by numpy and scipy, for claims on theory.
#
# Functions are rows of coefficients of Legendre polynomials in 2 t - 1, t in [0, 1]. M's norm is
# |u|_X^2 = |u'|^2 + |u(1)|^2; K_1 are the functions with v(1) = 0, K_2 those with u(0) = 0.


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
    """Derivatives by t, (functions, times)."""
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

    Attributes
    ----------
    values
        sum_j b_j u_i u_l
    slope
        sum_j b_j u_i' u_l'
    energy
        slope plus u_i(1) u_l(1): M's |u|_X^2
    """

    values: Array
    slope: Array
    energy: Array


def grams(functions: Array, t: Array, b: Array) -> Grams:
    """The Gram matrices with a rule's nodes t and weights b."""
    u, du, end = values(functions, t), slopes(functions, t), values(functions, np.ones(1))
    slope = (du * b) @ du.T
    return Grams((u * b) @ u.T, slope, slope + end @ end.T)


@cache
def z0() -> float:
    """The smallest positive root of 1 = z tan z: |u| <= |u|_X / z0 (Friedrichs)."""
    return float(brentq(lambda z: z * math.tan(z) - 1.0, 0.5, 1.0, xtol=1e-15))


def friedrichs(gram: Grams) -> float:
    """C_N of (11)."""
    return z0() * float(np.sqrt(eigvalsh(gram.values, gram.energy)[-1]))


def kernels(functions: Array) -> tuple[Array, Array]:
    """Bases of K_2 and K_1, as columns of coefficients of the functions."""
    starts, ends = (null_space(values(functions, np.array([t])).T) for t in (0.0, 1.0))
    return starts, ends


def inf_sup(functions: Array, gram: Grams, form: Array | None = None) -> float:
    """inf over u(0) = 0 of sup over v(1) = 0 of a(u, v) / (|u| |v|), with the rule.

    Parameters
    ----------
    form
        Gram matrix of a; None for that of mass 1
    """
    a = gram.slope if form is None else form
    starts, ends = kernels(functions)
    left = np.linalg.cholesky(starts.T @ gram.energy @ starts)
    right = np.linalg.cholesky(ends.T @ gram.energy @ ends)
    both = np.linalg.solve(left, starts.T @ a @ ends)
    return float(np.linalg.svd(np.linalg.solve(right, both.T), compute_uv=False)[-1])


def farthest(functions: Array, gram: Grams) -> float:
    """T_N, the largest |u(1)| / |u'| over u(0) = 0; its square is a tableau's beta_p."""
    starts, _ = kernels(functions)
    end = starts.T @ values(functions, np.ones(1))[:, 0]
    return float(np.sqrt(end @ np.linalg.solve(starts.T @ gram.slope @ starts, end)))

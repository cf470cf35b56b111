"""Products of groups: charts, tangent maps, coordinates and momenta of all factors.

layout  (factors, 4)  for each factor the number of its group, its dimension, the entries of an
                      element, and the number of leading components that are rotations
chart   number of a chart of rotations (galvi.kernels.lie.chart_functions)
g       (r,)  an element, the entries of all factors; xi, eta (d,) in the algebra
T, G    (d, d)  g^-1 g' = T(xi) xi',  G = d(T(xi) eta)/dxi; blocks on the diagonal

For the functions of each factor see galvi.kernels.lie.groups.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie import groups
from galvi.kernels.lie.dispatch import by_number, modules_of

GROUPS = modules_of(groups)
NUMBER, DIMENSION, ENTRIES, ROTATIONS = 0, 1, 2, 3

_place = by_number("place", GROUPS)
_tangent = by_number("tangent", GROUPS)
_coordinates = by_number("coordinates", GROUPS)
_restore = by_number("restore", GROUPS)
_coadjoint_inverse = by_number("coadjoint_inverse", GROUPS)
_coadjoint = by_number("coadjoint", GROUPS)
_left_derivative = by_number("left_derivative", GROUPS)
_position_scale = by_number("position_scale", GROUPS)


@jit_inline
def is_flat(layout):
    """Whether the group is R^n alone, where T = Ad* = 1."""
    return layout.shape[0] == 1 and layout[0, ROTATIONS] == 0


@jit_inline
def is_one_rotation(layout):
    """Whether the group is SO(3) alone."""
    return layout.shape[0] == 1 and layout[0, DIMENSION] == 3 and layout[0, ROTATIONS] == 3


@jit_noalloc
def place(layout, chart, g, xi, out):
    """out <- g Phi(xi)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        own = slice(first, first + row[ENTRIES])
        _place(row[NUMBER], chart, g[own], xi[start : start + row[DIMENSION]], out[own])
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def tangent(layout, chart, xi, eta, T, G):
    """T and G, (d, d), block diagonal."""
    for i in range(T.shape[0]):
        for j in range(T.shape[1]):
            T[i, j] = G[i, j] = 0.0
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _tangent(layout[factor, NUMBER], chart, xi[own], eta[own], T[own, own], G[own, own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def coordinates(layout, chart, g, k, xi):
    """xi <- the coordinates of k in the chart at g: k = g Phi(xi)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        own = slice(first, first + row[ENTRIES])
        _coordinates(row[NUMBER], chart, g[own], k[own], xi[start : start + row[DIMENSION]])
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def restore(layout, g):
    """Correct the orthogonality of rotations, which rounding disturbs, by one Newton step."""
    first = 0
    for factor in range(layout.shape[0]):
        _restore(layout[factor, NUMBER], g[first : first + layout[factor, ENTRIES]])
        first += layout[factor, ENTRIES]


@jit_noalloc
def coadjoint_inverse(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)^-1} mu: a body covector at g Phi(xi), in the frame of g."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _coadjoint_inverse(layout[factor, NUMBER], chart, xi[own], mu[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def coadjoint(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)} mu, the inverse of ``coadjoint_inverse``."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _coadjoint(layout[factor, NUMBER], chart, xi[own], mu[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def left_derivative(layout, g, slope, out):
    """out <- the derivative along g hat(e_a) of a function with Euclidean derivative slope (r,)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        own = slice(first, first + row[ENTRIES])
        _left_derivative(row[NUMBER], g[own], slope[own], out[start : start + row[DIMENSION]])
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def position_scale(layout, g, scale):
    """scale (d,) <- 1 for rotations, the largest coordinate of the factor for positions (or 0)."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        size = _position_scale(row[NUMBER], g[first : first + row[ENTRIES]])
        for i in range(row[DIMENSION]):
            scale[start + i] = 1.0 if i < row[ROTATIONS] else size
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def largest_rotation(layout, xi):
    """The largest |xi| of the rotations in xi (d,); 0 without rotations."""
    start, largest = 0, 0.0
    for factor in range(layout.shape[0]):
        size, square = 0.0, 0.0
        for i in range(start, start + layout[factor, ROTATIONS]):
            size = max(size, abs(xi[i]))
        for i in range(start, start + layout[factor, ROTATIONS]):
            square += (xi[i] / size) ** 2 if size > 0.0 else 0.0
        largest = max(largest, size * np.sqrt(square))
        start += layout[factor, DIMENSION]
    return largest

"""Products of groups: charts, tangent maps, coordinates and momenta of all factors.

layout  (factors, 4)  for each factor the number of its group, its dimension, the entries of an
                      element, and the number of leading components that are rotations
chart   number of a chart of rotations (galvi.kernels.lie.chart_functions)
g       (r,)  an element, the entries of all factors; xi, eta (d,) in the algebra

For the functions of each factor see galvi.kernels.lie.groups.
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit_inline, jit_noalloc
from galvi.kernels.lie import groups
from galvi.kernels.lie.dispatch import by_number, modules_of

GROUPS = modules_of(groups)
NUMBER, DIMENSION, ENTRIES, ROTATIONS = 0, 1, 2, 3
COUPLED = 4  # a further column in kernels of steps: factors that a mass couples share a number

_place = by_number("place", GROUPS)
_velocity = by_number("velocity", GROUPS)
_rate = by_number("rate", GROUPS)
_momentum = by_number("momentum", GROUPS)
_covector = by_number("covector", GROUPS)
_momentum_slope = by_number("momentum_slope", GROUPS)
_coordinates = by_number("coordinates", GROUPS)
_restore = by_number("restore", GROUPS)
_coadjoint_change = by_number("coadjoint_change", GROUPS)
_coadjoint = by_number("coadjoint", GROUPS)
_left_derivative = by_number("left_derivative", GROUPS)
_position_scale = by_number("position_scale", GROUPS)
_advance = by_number("advance", GROUPS)
_in_space = by_number("in_space", GROUPS)
_carry = by_number("carry", GROUPS)


@jit_inline
def is_flat(layout):
    """Whether the group is R^n alone, where T = Ad* = 1."""
    return layout.shape[0] == 1 and layout[0, ROTATIONS] == 0


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
def velocity(layout, chart, xi, eta, out):
    """out <- T(xi) eta, the velocity g^-1 g' along g Phi(xi) with xi' = eta."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _velocity(layout[factor, NUMBER], chart, xi[own], eta[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def rate(layout, chart, xi, v, out):
    """out <- T(xi)^-1 v."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _rate(layout[factor, NUMBER], chart, xi[own], v[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def momentum(layout, chart, xi, mu, out):
    """out <- T(xi)^T mu."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _momentum(layout[factor, NUMBER], chart, xi[own], mu[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def covector(layout, chart, xi, pi, out):
    """out <- T(xi)^-T pi."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _covector(layout[factor, NUMBER], chart, xi[own], pi[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def momentum_slope(layout, chart, xi, eta, mu, out):
    """out <- d(mu . T(xi) eta)/dxi."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _momentum_slope(layout[factor, NUMBER], chart, xi[own], eta[own], mu[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def coadjoint_change(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)^-1} mu - mu."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _coadjoint_change(layout[factor, NUMBER], chart, xi[own], mu[own], out[own])
        start += layout[factor, DIMENSION]


@jit_noalloc
def coadjoint_inverse(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)^-1} mu: a body covector at g Phi(xi), in the frame of g."""
    coadjoint_change(layout, chart, xi, mu, out)
    for i in range(mu.size):
        out[i] += mu[i]


@jit_noalloc
def coadjoint(layout, chart, xi, mu, out):
    """out <- Ad*_{Phi(xi)} mu, the inverse of ``coadjoint_inverse``."""
    start = 0
    for factor in range(layout.shape[0]):
        own = slice(start, start + layout[factor, DIMENSION])
        _coadjoint(layout[factor, NUMBER], chart, xi[own], mu[own], out[own])
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
def advance(layout, chart, xi, g, memory, low):
    """g <- g Phi(xi) with compensated sums; memory and low (r,), zeros when only g is known."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        own = slice(first, first + row[ENTRIES])
        part = xi[start : start + row[DIMENSION]]
        _advance(row[NUMBER], chart, part, g[own], memory[own], low[own])
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def in_space(layout, g, mu, out):
    """out <- mu along the axes of space."""
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        own = slice(start, start + row[DIMENSION])
        _in_space(row[NUMBER], g[first : first + row[ENTRIES]], mu[own], out[own])
        first, start = first + row[ENTRIES], start + row[DIMENSION]


@jit_noalloc
def carry(layout, chart, g, g1, xi, kick, mu, nu, low):
    """mu and nu <- the momentum at g1 = g Phi(xi) after an impulse kick (d,) in the frame of g.

    nu   (d,)  the momentum along the axes of space, not used by groups where they are the body's
    low  (d,)  rounding errors of nu, or else of mu
    """
    first, start = 0, 0
    for factor in range(layout.shape[0]):
        row = layout[factor]
        all_, own = slice(first, first + row[ENTRIES]), slice(start, start + row[DIMENSION])
        _carry(row[NUMBER], chart, g[all_], g1[all_], xi[own], kick[own], mu[own], nu[own],
               low[own])  # fmt: skip
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

"""R^n under addition."""

from __future__ import annotations

from galvi.kernels.compile.jit import jit_inline


@jit_inline
def place(chart, g, xi, out):
    """out <- g + xi."""
    for i in range(xi.size):
        out[i] = g[i] + xi[i]


@jit_inline
def tangent(chart, xi, eta, T, G):
    """T <- I."""
    for i in range(xi.size):
        T[i, i] = 1.0


@jit_inline
def coordinates(chart, g, k, xi):
    """xi <- k - g."""
    for i in range(xi.size):
        xi[i] = k[i] - g[i]


@jit_inline
def restore(g):
    """There are no rotations."""


@jit_inline
def coadjoint_inverse(chart, xi, mu, out):
    """out <- mu."""
    for i in range(mu.size):
        out[i] = mu[i]


@jit_inline
def coadjoint(chart, xi, mu, out):
    """out <- mu."""
    for i in range(mu.size):
        out[i] = mu[i]


@jit_inline
def left_derivative(g, slope, out):
    """out <- slope."""
    for i in range(slope.size):
        out[i] = slope[i]


@jit_inline
def position_scale(g):
    """The largest coordinate."""
    size = 0.0
    for i in range(g.size):
        size = max(size, abs(g[i]))
    return size


@jit_inline
def with_rotation(chart, xi, w, out):
    """out <- xi: there are no rotations."""
    for i in range(xi.size):
        out[i] = xi[i]

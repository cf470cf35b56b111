"""R^n under addition."""

from galvi.kernels.lie.arithmetic import generic, larger_size, two_sum


@generic
def place(chart, g, xi, out):
    """out <- g + xi."""
    for i in range(len(xi)):
        out[i] = g[i] + xi[i]


@generic
def velocity(chart, xi, eta, out):
    """out <- eta."""
    for i in range(len(eta)):
        out[i] = eta[i]


rate = momentum = covector = coadjoint = velocity


@generic
def momentum_slope(chart, xi, eta, mu, out):
    """out <- 0."""
    for i in range(len(xi)):
        out[i] = 0.0


@generic
def coadjoint_change(chart, xi, mu, out):
    """out <- 0."""
    for i in range(len(mu)):
        out[i] = 0.0


@generic
def left_derivative(g, slope, out):
    """out <- slope."""
    velocity(0, g, slope, out)


@generic
def coordinates(chart, g, k, xi):
    """xi <- k - g."""
    for i in range(len(xi)):
        xi[i] = k[i] - g[i]


@generic
def restore(g):
    """Do nothing: there are no rotations."""


@generic
def with_rotation(chart, xi, w, out):
    """out <- xi: there are no rotations."""
    velocity(chart, xi, xi, out)


@generic
def position_scale(g):
    """The largest |coordinate|."""
    size = 0.0
    for i in range(len(g)):
        size = larger_size(size, g[i])
    return size


@generic
def remember(g, memory):
    """Do nothing: the low parts of g start at 0."""


@generic
def advance(chart, xi, g, memory, low):
    """g <- g + xi; memory is its low part."""
    for i in range(len(xi)):
        g[i], memory[i] = two_sum(g[i], memory[i] + xi[i])


@generic
def in_space(g, mu, out):
    """out <- mu."""
    velocity(0, g, mu, out)


@generic
def carry(chart, g, g1, xi, kick, mu, nu, low):
    """mu <- mu + kick; low is its low part; nu is not used."""
    for i in range(len(kick)):
        mu[i], low[i] = two_sum(mu[i], low[i] + kick[i])

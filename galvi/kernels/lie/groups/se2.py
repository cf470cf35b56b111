"""Rigid motions of the plane: matrices [[R, x], [0, 1]] (3, 3), velocities (omega, v_x, v_y).

A chart of rotations maps (x, v) to the rotation R by angle(x) and the translation V v, with
V = (1 - f x^2) I + e x J, J = [[0, -1], [1, 0]], and e and f at u = x^2
(galvi.kernels.lie.charts); the matrix p I + q J is stored as (p, q). With s = d angle/dx the
body's velocity is (s x', R^T (V' v x' + V v')).
"""

from galvi.kernels.lie.arithmetic import generic, larger_size, two_sum
from galvi.kernels.lie.dispatch import translation_radial
from galvi.kernels.lie.groups import so2


@generic
def times(matrix, v, w):
    """(p I + q J) (v, w)."""
    p, q = matrix
    return p * v - q * w, q * v + p * w


@generic
def transposed(matrix):
    """p I - q J."""
    return matrix[0], -matrix[1]


@generic
def inverse(matrix):
    """The inverse of p I + q J."""
    p, q = matrix
    size = p * p + q * q
    return p / size, -q / size


@generic
def rotation(chart, x):
    """R as (p, q)."""
    cosine_less_one, sine = so2.change(chart, x)
    return 1.0 + cosine_less_one, sine


@generic
def shift_matrix(chart, x):
    """V, dV/dx and d^2V/dx^2."""
    u = x * x
    (e, f), (e1, f1), (e2, f2) = translation_radial(chart, u)
    return (
        (1.0 - f * u, e * x),
        (-2.0 * x * (f + u * f1), e + 2.0 * u * e1),
        (-2.0 * f - u * (10.0 * f1 + 4.0 * u * f2), x * (6.0 * e1 + 4.0 * u * e2)),
    )


@generic
def place(chart, g, xi, out):
    so2.turn(chart, g, xi[0], 3, out)
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    out[2] = g[2] + (g[0] * x + g[1] * y)
    out[5] = g[5] + (g[3] * x + g[4] * y)
    out[6], out[7], out[8] = g[6], g[7], g[8]


@generic
def shift_velocity(chart, xi, eta):
    """R^T d(V v)/dt."""
    V, V1, _ = shift_matrix(chart, xi[0])
    x, y = times(V1, xi[1], xi[2])
    dx, dy = times(V, eta[1], eta[2])
    return times(transposed(rotation(chart, xi[0])), x * eta[0] + dx, y * eta[0] + dy)


@generic
def velocity(chart, xi, eta, out):
    out[0] = so2.slopes(chart, xi[0])[0] * eta[0]
    out[1], out[2] = shift_velocity(chart, xi, eta)


@generic
def rate(chart, xi, v, out):
    V, V1, _ = shift_matrix(chart, xi[0])
    angle_rate = v[0] / so2.slopes(chart, xi[0])[0]
    x, y = times(V1, xi[1], xi[2])
    dx, dy = times(rotation(chart, xi[0]), v[1], v[2])
    out[0] = angle_rate
    out[1], out[2] = times(inverse(V), dx - x * angle_rate, dy - y * angle_rate)


@generic
def momentum(chart, xi, mu, out):
    V, V1, _ = shift_matrix(chart, xi[0])
    x, y = times(V1, xi[1], xi[2])
    fx, fy = times(rotation(chart, xi[0]), mu[1], mu[2])
    out[0] = so2.slopes(chart, xi[0])[0] * mu[0] + (fx * x + fy * y)
    out[1], out[2] = times(transposed(V), fx, fy)


@generic
def covector(chart, xi, pi, out):
    V, V1, _ = shift_matrix(chart, xi[0])
    x, y = times(V1, xi[1], xi[2])
    fx, fy = times(inverse(transposed(V)), pi[1], pi[2])
    out[0] = (pi[0] - (fx * x + fy * y)) / so2.slopes(chart, xi[0])[0]
    out[1], out[2] = times(transposed(rotation(chart, xi[0])), fx, fy)


@generic
def momentum_slope(chart, xi, eta, mu, out):
    slope, slope_derivative = so2.slopes(chart, xi[0])
    _, V1, V2 = shift_matrix(chart, xi[0])
    fx, fy = times(rotation(chart, xi[0]), mu[1], mu[2])
    x, y = times(V2, xi[1], xi[2])
    dx, dy = times(V1, eta[1], eta[2])
    v, w = shift_velocity(chart, xi, eta)
    shift_part = fx * (x * eta[0] + dx) + fy * (y * eta[0] + dy)
    out[0] = (slope_derivative * (eta[0] * mu[0]) + shift_part) + slope * (mu[1] * w - mu[2] * v)
    fx, fy = times(transposed(V1), fx, fy)
    out[1], out[2] = fx * eta[0], fy * eta[0]


@generic
def coadjoint_change(chart, xi, mu, out):
    """out <- (y cross R f, R f - f) for mu = (m, f) and y = V v."""
    cosine_less_one, sine = so2.change(chart, xi[0])
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    v, w = times((cosine_less_one, sine), mu[1], mu[2])
    out[0] = x * (mu[2] + w) - y * (mu[1] + v)
    out[1], out[2] = v, w


@generic
def left_derivative(g, slope, out):
    """out <- the derivatives along a rotation and along translations in the body's frame."""
    out[0] = so2.turn_derivative(g, slope, 3)
    for a in range(2):
        out[1 + a] = g[a] * slope[2] + g[3 + a] * slope[5]


@generic
def coadjoint(chart, xi, mu, out):
    """out <- (m - y cross f, R^T f) for mu = (m, f) and y = V v."""
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    v, w = times(transposed(rotation(chart, xi[0])), mu[1], mu[2])
    out[0], out[1], out[2] = mu[0] - (x * mu[2] - y * mu[1]), v, w


@generic
def shift_to_coordinates(chart, x, shift):
    """V^-1 shift."""
    V, _, _ = shift_matrix(chart, x)
    return times(inverse(V), shift[0], shift[1])


@generic
def coordinates(chart, g, k, xi):
    xi[0] = so2.relative_coordinate(chart, g, k, 3)
    shift = times((g[0], -g[3]), k[2] - g[2], k[5] - g[5])
    xi[1], xi[2] = shift_to_coordinates(chart, xi[0], shift)


@generic
def restore(g):
    so2.restore_rotation(g, 3)


@generic
def with_rotation(chart, xi, w, out):
    """out <- w and the coordinates of the translation for which the motion is that of xi."""
    V, _, _ = shift_matrix(chart, xi[0])
    shift = times(V, xi[1], xi[2])
    out[0] = w[0]
    out[1], out[2] = shift_to_coordinates(chart, w[0], shift)


@generic
def position_scale(g):
    """The largest |coordinate| of the position."""
    return larger_size(larger_size(0.0, g[2]), g[5])


@generic
def shift_in_space(chart, g, xi):
    """R V v, the displacement from g to g Phi(xi)."""
    V, _, _ = shift_matrix(chart, xi[0])
    x, y = times(V, xi[1], xi[2])
    return times((g[0], g[3]), x, y)


@generic
def remember(g, memory):
    """memory <- cos and sin."""
    memory[0], memory[1] = g[0], g[3]


@generic
def advance(chart, xi, g, memory, low):
    """g <- g Phi(xi); memory[2:4] is the low part of the position."""
    x, y = shift_in_space(chart, g, xi)
    so2.turn_frame(chart, xi[0], 3, g, memory, low)
    g[2], memory[2] = two_sum(g[2], memory[2] + x)
    g[5], memory[3] = two_sum(g[5], memory[3] + y)


@generic
def in_space(g, mu, out):
    """out <- (m, R f) for mu = (m, f)."""
    out[0] = mu[0]
    out[1], out[2] = times((g[0], g[3]), mu[1], mu[2])


@generic
def carry(chart, g, g1, xi, kick, mu, nu, low):
    """Add the force's impulse to the momentum in space, then its moment to the angular momentum,
    which is moved to the new point."""
    x, y = shift_in_space(chart, g, xi)
    fx, fy = times((g[0], g[3]), kick[1], kick[2])
    nu[1], low[1] = two_sum(nu[1], low[1] + fx)
    nu[2], low[2] = two_sum(nu[2], low[2] + fy)
    nu[0], low[0] = two_sum(nu[0], low[0] + (kick[0] - (x * nu[2] - y * nu[1])))
    mu[0] = nu[0]
    mu[1], mu[2] = times((g1[0], -g1[3]), nu[1], nu[2])

"""Rigid motions of space: matrices [[R, x], [0, 1]] (4, 4), velocities (w, v) of the body.

A chart maps (w, v) to the rotation R(w) and the translation V(w) v. With u = |w|^2 and
V = I + e hat(w) + f hat(w)^2 (galvi.kernels.lie.charts), the body's linear velocity is
R^T d(V v)/dt = R^T (D(w, w') v + V v'), where D is the derivative of V along w':

    D(w, a) v = 2 e1 p x1 + e a x v + 2 f1 p x2 + f ((a.v) w + (w.v) a - 2 p v),
    p = w.a, x1 = w x v, x2 = w x (w x v) = (w.v) w - u v

V^T and D^T have -e in place of e. xi = (w, v), eta = (w', v').
"""

from galvi.kernels.lie import rotations
from galvi.kernels.lie.arithmetic import cross, dot, generic, larger_size, two_sum
from galvi.kernels.lie.dispatch import translation_radial
from galvi.kernels.lie.groups import so3
from galvi.kernels.lie.rotations import change, hat_polynomial, rotated, rotation, times, transpose


@generic
def plus(v, w):
    """v + w of two triples."""
    return v[0] + w[0], v[1] + w[1], v[2] + w[2]


@generic
def minus(v, w):
    """v - w of two triples."""
    return v[0] - w[0], v[1] - w[1], v[2] - w[2]


@generic
def combination(a, v, b, w, c, x):
    """a v + b w + c x of triples."""
    return (
        a * v[0] + b * w[0] + c * x[0],
        a * v[1] + b * w[1] + c * x[1],
        a * v[2] + b * w[2] + c * x[2],
    )


@generic
def shifted(chart, sign, w, v):
    """V v for sign = 1, V^T v for sign = -1."""
    (e, f), _, _ = translation_radial(chart, dot(w, w))
    return plus(v, hat_polynomial(sign * e, f, w, v))


@generic
def unshifted(chart, sign, w, x):
    """V^-1 x for sign = 1, V^-T x for sign = -1."""
    u = dot(w, w)
    (e, f), _, _ = translation_radial(chart, u)
    complement = 1.0 - f * u
    size = 1.0 / (complement * complement + e * e * u)
    return plus(x, hat_polynomial(-sign * e * size, (e * e - complement * f) * size, w, x))


@generic
def shift_rate(chart, sign, w, v, a):
    """D(w, a) v for sign = 1, D(w, a)^T v for sign = -1."""
    (e, f), (e1, f1), _ = translation_radial(chart, dot(w, w))
    p, along = dot(w, a), dot(w, v)
    x, y, z = hat_polynomial(2.0 * sign * e1 * p, 2.0 * f1 * p, w, v)
    bx, by, bz = cross(a, v)
    sx, sy, sz = combination(f * dot(a, v), w, f * along, a, -2.0 * f * p, v)
    e = sign * e
    return x + e * bx + sx, y + e * by + sy, z + e * bz + sz


@generic
def shift_slope(chart, w, v, F):
    """d(F . V(w) v)/dw."""
    u = dot(w, w)
    (e, f), (e1, f1), _ = translation_radial(chart, u)
    v_cross_F, F_dot_v = cross(v, F), dot(F, v)
    w_dot_v, w_dot_F = dot(w, v), dot(w, F)
    radial = 2.0 * (e1 * dot(w, v_cross_F) + f1 * (w_dot_v * w_dot_F - u * F_dot_v) - f * F_dot_v)
    x, y, z = combination(radial, w, f * w_dot_F, v, f * w_dot_v, F)
    return x + e * v_cross_F[0], y + e * v_cross_F[1], z + e * v_cross_F[2]


@generic
def shift_slope_derivative(chart, w, v, F, a):
    """The derivative of d(F . V(w) v)/dw along a."""
    u, p = dot(w, w), dot(w, a)
    (e, f), (e1, f1), (e2, f2) = translation_radial(chart, u)
    v_cross_F, F_dot_v = cross(v, F), dot(F, v)
    w_dot_v, w_dot_F, a_dot_v, a_dot_F = dot(w, v), dot(w, F), dot(a, v), dot(a, F)
    e_part, f_part = dot(w, v_cross_F), w_dot_v * w_dot_F - u * F_dot_v
    f_part_slope = a_dot_v * w_dot_F + w_dot_v * a_dot_F - 2.0 * p * F_dot_v
    first = 2.0 * (e1 * e_part + f1 * f_part - f * F_dot_v)
    radial = 4.0 * p * (e2 * e_part + f2 * f_part) + 2.0 * (
        e1 * dot(a, v_cross_F) + f1 * f_part_slope
    )
    radial = radial - 4.0 * f1 * p * F_dot_v
    b, c = 2.0 * f1 * p * w_dot_F + f * a_dot_F, 2.0 * f1 * p * w_dot_v + f * a_dot_v
    x, y, z = combination(first, a, b, v, c, F)
    q = 2.0 * e1 * p
    return (
        x + radial * w[0] + q * v_cross_F[0],
        y + radial * w[1] + q * v_cross_F[1],
        z + radial * w[2] + q * v_cross_F[2],
    )


@generic
def place(chart, g, xi, out):
    columns, x = transpose(rotation(chart, xi)), shifted(chart, 1.0, xi, xi[3:6])
    for i in range(3):
        row = g[4 * i], g[4 * i + 1], g[4 * i + 2]
        out[4 * i + 3] = dot(row, x) + g[4 * i + 3]
        out[4 * i], out[4 * i + 1], out[4 * i + 2] = times(columns, row)
    out[12], out[13], out[14], out[15] = g[12], g[13], g[14], g[15]


@generic
def shift_velocity(chart, xi, eta):
    """R^T d(V v)/dt."""
    space_velocity = plus(
        shift_rate(chart, 1.0, xi, xi[3:6], eta), shifted(chart, 1.0, xi, eta[3:6])
    )
    return rotated(chart, -1.0, xi, space_velocity)


@generic
def velocity(chart, xi, eta, out):
    so3.fill(rotations.tangent(chart, 1.0, xi, eta), out)
    out[3], out[4], out[5] = shift_velocity(chart, xi, eta)


@generic
def rate(chart, xi, v, out):
    rotation_rate = rotations.inverse_tangent(chart, 1.0, xi, v)
    shift_change = minus(
        rotated(chart, 1.0, xi, v[3:6]), shift_rate(chart, 1.0, xi, xi[3:6], rotation_rate)
    )
    so3.fill(rotation_rate, out)
    out[3], out[4], out[5] = unshifted(chart, 1.0, xi, shift_change)


@generic
def momentum(chart, xi, mu, out):
    F = rotated(chart, 1.0, xi, mu[3:6])
    rotation_part = rotations.tangent(chart, -1.0, xi, mu)
    so3.fill(plus(rotation_part, shift_slope(chart, xi, xi[3:6], F)), out)
    out[3], out[4], out[5] = shifted(chart, -1.0, xi, F)


@generic
def covector(chart, xi, pi, out):
    F = unshifted(chart, -1.0, xi, pi[3:6])
    rotation_part = minus(pi, shift_slope(chart, xi, xi[3:6], F))
    so3.fill(rotations.inverse_tangent(chart, -1.0, xi, rotation_part), out)
    out[3], out[4], out[5] = rotated(chart, -1.0, xi, F)


@generic
def momentum_slope(chart, xi, eta, mu, out):
    F, v = rotated(chart, 1.0, xi, mu[3:6]), xi[3:6]
    rotation_part = rotations.tangent_slope(chart, xi, eta, mu)
    shift_part = plus(
        shift_slope_derivative(chart, xi, v, F, eta), shift_slope(chart, xi, eta[3:6], F)
    )
    moment = cross(mu[3:6], shift_velocity(chart, xi, eta))
    so3.fill(plus(plus(rotation_part, shift_part), rotations.tangent(chart, -1.0, xi, moment)), out)
    out[3], out[4], out[5] = shift_rate(chart, -1.0, xi, F, eta)


@generic
def coadjoint_change(chart, xi, mu, out):
    """out <- (R m - m + x cross R f, R f - f) for mu = (m, f), where x = V v."""
    force_change = change(chart, 1.0, xi, mu[3:6])
    lever = cross(shifted(chart, 1.0, xi, xi[3:6]), plus(mu[3:6], force_change))
    so3.fill(plus(change(chart, 1.0, xi, mu), lever), out)
    out[3], out[4], out[5] = force_change


@generic
def left_derivative(g, slope, out):
    """out <- the derivatives along rotations and along translations in the body's frame."""
    so3.turn_derivatives(g, slope, 4, out)
    for a in range(3):
        out[3 + a] = g[a] * slope[3] + g[4 + a] * slope[7] + g[8 + a] * slope[11]


@generic
def coadjoint(chart, xi, mu, out):
    """out <- (R^T (m - x cross f), R^T f) for mu = (m, f), where x = V v."""
    lever = cross(shifted(chart, 1.0, xi, xi[3:6]), mu[3:6])
    so3.fill(rotated(chart, -1.0, xi, minus(mu, lever)), out)
    out[3], out[4], out[5] = rotated(chart, -1.0, xi, mu[3:6])


@generic
def coordinates(chart, g, k, xi):
    so3.relative_coordinates(chart, g, k, 4, xi)
    displacement = k[3] - g[3], k[7] - g[7], k[11] - g[11]
    xi[3], xi[4], xi[5] = unshifted(chart, 1.0, xi, times(so3.columns(g, 4), displacement))


@generic
def restore(g):
    so3.restore_rotation(g, 4)


@generic
def with_rotation(chart, xi, w, out):
    """out <- w and the coordinates of the translation for which the motion is that of xi."""
    shift = shifted(chart, 1.0, xi, xi[3:6])
    out[0], out[1], out[2] = w[0], w[1], w[2]
    out[3], out[4], out[5] = unshifted(chart, 1.0, w, shift)


@generic
def position_scale(g):
    """The largest |coordinate| of the position."""
    return larger_size(larger_size(larger_size(0.0, g[3]), g[7]), g[11])


@generic
def shift_in_space(chart, g, xi):
    """R V v, the displacement from g to g Phi(xi)."""
    return times(transpose(so3.columns(g, 4)), shifted(chart, 1.0, xi, xi[3:6]))


@generic
def remember(g, memory):
    """memory <- a quaternion."""
    so3.remember_frame(4, g, memory)


@generic
def advance(chart, xi, g, memory, low):
    """g <- g Phi(xi); memory[4:7] is the low part of the position."""
    shift = shift_in_space(chart, g, xi)
    so3.turn_frame(chart, xi, 4, g, memory, low)
    for i in range(3):
        g[4 * i + 3], memory[4 + i] = two_sum(g[4 * i + 3], memory[4 + i] + shift[i])


@generic
def in_space(g, mu, out):
    """out <- (R m, R f) for mu = (m, f)."""
    R = transpose(so3.columns(g, 4))
    so3.fill(times(R, mu), out)
    out[3], out[4], out[5] = times(R, mu[3:6])


@generic
def carry(chart, g, g1, xi, kick, mu, nu, low):
    """Add the force's impulse to the momentum in space, then its moment to the angular momentum,
    which is moved to the new point."""
    R, columns_at_end = transpose(so3.columns(g, 4)), so3.columns(g1, 4)
    force, moment = times(R, kick[3:6]), times(R, kick)
    for i in range(3):
        nu[3 + i], low[3 + i] = two_sum(nu[3 + i], low[3 + i] + force[i])
    lever = cross(shift_in_space(chart, g, xi), nu[3:6])
    for i in range(3):
        nu[i], low[i] = two_sum(nu[i], low[i] + (moment[i] - lever[i]))
    so3.fill(times(columns_at_end, nu), mu)
    mu[3], mu[4], mu[5] = times(columns_at_end, nu[3:6])

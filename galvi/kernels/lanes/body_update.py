"""The end of a rigid body's step: rotation, momentum and attitude.

Arrays as in galvi.kernels.lanes.body. The effect of Phi or Phi^T is computed as a change, and
changes are summed with compensation of their rounding errors.
"""

from __future__ import annotations

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.lie.chart_functions import half_turn, inverse_radial, rotation_radial
from galvi.kernels.lie.rotations import quaternion
from galvi.kernels.nystrom.step import two_sum


@jit_inline
def turned(sine, cosine, x, y, z, v0, v1, v2):
    """(Phi - I) v for the rotation I + sine hat + cosine hat^2 of (x, y, z)."""
    a, b, c = y * v2 - z * v1, z * v0 - x * v2, x * v1 - y * v0
    return (
        sine * a + cosine * (y * c - z * b),
        sine * b + cosine * (z * a - x * c),
        sine * c + cosine * (x * b - y * a),
    )


@jit_inline
def end_defect(chart, kicks, results, mu0, p0, size, out):
    """out <- rows xi(1), h sum_k b_k n_k, and the error of p0; returns size times the last.

    In the frame of the step's start, p0 gives the final momentum Phi T^-T (p0 + h sum_k b_k f_k),
    which should be mu0 + h sum_k b_k n_k.
    """
    for i in range(3):
        place, force, kick = 0.0, 0.0, 0.0
        for j in range(kicks.shape[1]):
            place += kicks[1, j] * results[i, j]
            force += kicks[1, j] * results[3 + i, j]
            kick += kicks[1, j] * results[6 + i, j]
        for j in range(kicks.shape[1]):
            place += kicks[0, j] * results[i, j]
            force += kicks[0, j] * results[3 + i, j]
            kick += kicks[0, j] * results[6 + i, j]
        out[0, i], out[1, i], out[2, i] = place, kick, p0[i] + force
    x, y, z = out[0, 0], out[0, 1], out[0, 2]
    u = x * x + y * y + z * z
    sine, cosine = rotation_radial(chart, u)
    k, d = inverse_radial(chart, u)
    l0, l1, l2 = turned(-0.5, d, x, y, z, out[2, 0], out[2, 1], out[2, 2])
    l0, l1, l2 = k * out[2, 0] + l0, k * out[2, 1] + l1, k * out[2, 2] + l2
    s0, s1, s2 = turned(sine, cosine, x, y, z, l0, l1, l2)
    k0, k1, k2 = out[1, 0], out[1, 1], out[1, 2]
    out[2, 0] = (mu0[0] - l0) + (k0 - s0)
    out[2, 1] = (mu0[1] - l1) + (k1 - s1)
    out[2, 2] = (mu0[2] - l2) + (k2 - s2)
    return size * max(abs(out[2, 0]), abs(out[2, 1]), abs(out[2, 2]))


@jit_inline
def matrix_of(state):
    """Row 0 of the state from the quaternion, which need not be normalised."""
    w, x, y, z = state[2, 0], state[2, 1], state[2, 2], state[2, 3]
    two = 2.0 / (w * w + x * x + y * y + z * z)
    state[0, 0], state[0, 4] = 1.0 - two * (y * y + z * z), 1.0 - two * (x * x + z * z)
    state[0, 8] = 1.0 - two * (x * x + y * y)
    state[0, 1], state[0, 3] = two * (x * y - w * z), two * (x * y + w * z)
    state[0, 2], state[0, 6] = two * (x * z + w * y), two * (x * z - w * y)
    state[0, 5], state[0, 7] = two * (y * z - w * x), two * (y * z + w * x)


@jit_inline
def quaternion_of(state):
    """A quaternion with zero low part, if the general kernel left none."""
    if state[2, 0] != 0.0 or state[2, 1] != 0.0 or state[2, 2] != 0.0 or state[2, 3] != 0.0:
        return
    R = state[0]
    state[2, 0], state[2, 1], state[2, 2], state[2, 3] = quaternion(
        ((R[0], R[1], R[2]), (R[3], R[4], R[5]), (R[6], R[7], R[8]))
    )
    for i in range(3):
        state[1, 3 + i] = state[3, i] = state[3, 3 + i] = state[3, 6 + i] = 0.0


@jit_inline
def kick_momentum(kick, R, state):
    """Update the spatial momentum by the kick in the frame R of the step's start; mu1 from it.

    Rounding errors of mu1 are thus not carried from step to step.
    """
    for i in range(3):
        push = R[3 * i] * kick[0] + R[3 * i + 1] * kick[1] + R[3 * i + 2] * kick[2]
        state[1, 6 + i], state[3, 4 + i] = two_sum(state[1, 6 + i], state[3, 4 + i] + push)
    for i in range(3):
        state[1, i] = (
            state[0, i] * state[1, 6]
            + state[0, 3 + i] * state[1, 7]
            + state[0, 6 + i] * state[1, 8]
        )


@jit_inline
def turn_quaternion(chart, xi, state):
    """q <- q times the quaternion of xi, by a compensated change."""
    x, y, z = xi[0], xi[1], xi[2]
    along, less = half_turn(chart, x * x + y * y + z * z)
    a, b, c = along * x, along * y, along * z
    w, x, y, z = state[2, 0], state[2, 1], state[2, 2], state[2, 3]
    steps = (
        less * w - (a * x + b * y + c * z), less * x + (a * w + c * y - b * z),
        less * y + (b * w + a * z - c * x), less * z + (c * w + b * x - a * y),
    )  # fmt: skip
    for i in range(4):
        state[2, i], state[3, i] = two_sum(state[2, i], state[3, i] + steps[i])

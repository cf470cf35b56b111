"""The end of a rigid body's step: rotation, momentum and attitude.

Arrays as in galvi.kernels.lanes.body. The effect of Phi or Phi^T is computed as a change, and
changes are summed with compensation of their rounding errors.
"""

from __future__ import annotations

from galvi.kernels.compile.jit import jit_inline
from galvi.kernels.lie.arithmetic import dot
from galvi.kernels.lie.chart_functions import half_turn, inverse_radial, rotation_radial
from galvi.kernels.lie.rotations import quaternion, turned
from galvi.kernels.nystrom.step import two_sum


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
    xi, momentum = (out[0, 0], out[0, 1], out[0, 2]), (out[2, 0], out[2, 1], out[2, 2])
    u = dot(xi, xi)
    sine, cosine = rotation_radial(chart, u)
    k, d = inverse_radial(chart, u)
    l0, l1, l2 = turned(-0.5, d, xi, momentum)
    body = k * momentum[0] + l0, k * momentum[1] + l1, k * momentum[2] + l2
    change = turned(sine, cosine, xi, body)
    for i in range(3):
        out[2, i] = (mu0[i] - body[i]) + (out[1, i] - change[i])
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
        state[1, 3 + i] = state[3, i] = 0.0
    state[3, 3] = 0.0


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

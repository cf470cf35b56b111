"""The force -dV/dq of each potential of galvi, and the drag of a rotor's wind, written out.

Every formula is f(q, v, t, numbers, out) and adds its force to out; arrays have shape (d,). They
are independent of galvi's kernels. Powers are written as products, since numba's complex power
rounds the imaginary part of a complex step away.

numbers of each formula
    spring        k                     f = -k q
    pendulum      w                     f_i = -w sin q_i
    central       mu                    f = -mu q / |q|^3
    uniform       f, (d,)               f
    spring_chain  alpha, beta           Fermi, Pasta, Ulam and Tsingou (1955), eqs. 1 and 2
    gravity       dimension, G m_1 ...  f_i = sum_j G m_j (q_j - q_i) / |q_j - q_i|^3, for each mass
    rotor_drag    k                     f = -k |w| w, w = v - wind(q, t) (M 14)
    rotor_drag_by_reynolds  k, s        f = -k (1 + 0.15 (s |w|)^0.687) w (Schiller and Naumann)
"""

from __future__ import annotations

from math import exp
from typing import Any

import numpy as np
from numba.extending import register_jitable

# The rotor's wind (M 6.2), in metres and seconds, as stated in `galvi.kernels.forces.rotor_wind`.
RADIUS, CORE, DOWNWASH = 7.0, 2.5, 10.0
START_HEIGHT, END_HEIGHT = 16.0, 6.0  # of the rotor, for t = 0 and t to infinity
DESCENT_TIME = 2.0  # in which the height above END_HEIGHT falls by 1 / e
RINGS = (1.0, 0.75, 0.5, 0.25)  # heights of the vortex rings over that of the rotor
# Gamma R^2 / 4 of a ring: at the hub, u_z = 2 C (R^2 + zeta^2 + a^2)^(-3/2) summed is -DOWNWASH.
CIRCULATION = (
    -0.5
    * DOWNWASH
    / sum((RADIUS**2 + ((1.0 - share) * START_HEIGHT) ** 2 + CORE**2) ** -1.5 for share in RINGS)
)


def spring(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f = -k q."""
    for i in range(q.size):
        out[i] -= numbers[0] * q[i]


def pendulum(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f_i = -w sin q_i."""
    for i in range(q.size):
        out[i] -= numbers[0] * np.sin(q[i])


def central(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f = -mu q / |q|^3."""
    square = q[0] * q[0]
    for i in range(1, q.size):
        square = square + q[i] * q[i]
    strength = numbers[0] / (square * np.sqrt(square))
    for i in range(q.size):
        out[i] -= strength * q[i]


def uniform(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f_i = numbers_i, everywhere."""
    for i in range(q.size):
        out[i] += numbers[i]


def spring_chain(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f_i is the tension of the spring on the right minus that on the left, r + alpha r^2 + beta
    r^3 each."""
    alpha, beta = numbers[0], numbers[1]
    last = q.size - 1
    left = q[0] * (1.0 + q[0] * (alpha + q[0] * beta))
    for i in range(q.size):
        r = (q[i + 1] if i < last else 0.0 * q[i]) - q[i]
        right = r * (1.0 + r * (alpha + r * beta))
        out[i] += right - left
        left = right


def gravity(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """Newton's law for each body, by rows: the acceleration, force over mass."""
    dimension, bodies = int(numbers[0]), numbers.size - 1
    for i in range(bodies):
        for j in range(i):
            a, b = i * dimension, j * dimension
            square = (q[b] - q[a]) * (q[b] - q[a])
            for x in range(1, dimension):
                square = square + (q[b + x] - q[a + x]) * (q[b + x] - q[a + x])
            inverse_cube = 1.0 / (square * np.sqrt(square))
            for x in range(dimension):
                attraction = (q[b + x] - q[a + x]) * inverse_cube
                out[a + x] += numbers[1 + j] * attraction
                out[b + x] -= numbers[1 + i] * attraction


@register_jitable
def wind(q: Any, t: Any) -> Any:
    """The radial wind over r, and the vertical wind, of four vortex rings and their images.

    The Stokes stream function of a ring is psi = C r^2 B^(-3/4), B = P^2 - 4 R^2 r^2,
    P = r^2 + R^2 + zeta^2 + a^2, at the height zeta above the ring; u_r = -psi_z / r,
    u_z = psi_r / r.
    """
    square = q[0] * q[0] + q[1] * q[1]
    height = END_HEIGHT + (START_HEIGHT - END_HEIGHT) * exp(-t / DESCENT_TIME)
    radial = 0.0
    axial = 0.0
    for share in RINGS:
        for sign in (1.0, -1.0):
            zeta = q[2] - sign * share * height
            P = square + RADIUS**2 + zeta**2 + CORE**2
            B = P * P - (2.0 * RADIUS) ** 2 * square
            factor = sign * np.sqrt(np.sqrt(B)) / (B * B)  # B^(-7/4)
            radial += 3.0 * zeta * P * factor
            axial += (2.0 * B + 3.0 * square * (2.0 * RADIUS**2 - P)) * factor
    return CIRCULATION * radial, CIRCULATION * axial


@register_jitable
def velocity_in_air(q: Any, v: Any, t: Any) -> Any:
    """The velocity w relative to the air."""
    radial, axial = wind(q, t)
    return v[0] - radial * q[0], v[1] - radial * q[1], v[2] - axial


def rotor_drag(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f = -k |w| w."""
    a, b, c = velocity_in_air(q, v, t)
    rate = numbers[0] * np.sqrt(a * a + b * b + c * c)
    out[0] -= rate * a
    out[1] -= rate * b
    out[2] -= rate * c


def rotor_drag_by_reynolds(q: Any, v: Any, t: Any, numbers: Any, out: Any) -> None:
    """f = -k (1 + 0.15 (s |w|)^0.687) w."""
    a, b, c = velocity_in_air(q, v, t)
    rate = numbers[0] * (1.0 + 0.15 * (numbers[1] * np.sqrt(a * a + b * b + c * c)) ** 0.687)
    out[0] -= rate * a
    out[1] -= rate * b
    out[2] -= rate * c

"""The wind below a rotor that descends towards the ground: vortex rings and their images.

The axis is z, the ground z = 0. Lengths in m, times in s, speeds in m/s.

R        radius of the rings                          a       radius of their cores
v        downwash at the hub far from the ground: rings below the rotor, no images
H(t)     height of the rotor, LOW + (HIGH - LOW) exp(-t / DESCENT)
Z_j      height of ring j, s_j H(t) with s_j = 1, 3/4, 1/2, 1/4: the wake, down to the ground
zeta     height above a ring, z - Z_j, and above its image, z + Z_j, of opposite circulation

One ring, of circulation Gamma, has the Stokes stream function
    psi = (Gamma R^2 / 4) r^2 / B^(3/4),   B = P^2 - 4 R^2 r^2,   P = r^2 + R^2 + zeta^2 + a^2,
so u_r = -psi_z / r and u_z = psi_r / r: divergence-free by construction, with no flow through the
ground, where ring and image have opposite psi. Far away it is the velocity of a thin ring by the
Biot-Savart law (Lamb, Hydrodynamics, art. 161), and also on the axis with R^2 + zeta^2 + a^2 in
place of R^2 + zeta^2. It is smooth about the core, since
B = ((r - R)^2 + zeta^2 + a^2) ((r + R)^2 + zeta^2 + a^2) > 0.

Elliptic integrals would lose digits near the axis and are infinite at the core; here psi / r^2 is
an algebraic function of r^2, so the wind is analytic in x, y, z and t and takes two square roots
and a division per ring. The rings do not move by their own velocity: the field is prescribed, not a
solution of Euler's equations.
"""

from __future__ import annotations

import math

from galvi.kernels.compile.jit import jit

R, CORE = 7.0, 2.5
DOWNWASH = 10.0  # m / s, for a hovering helicopter of 3.8 t, by T = 2 rho pi R^2 v^2
HIGH, LOW, DESCENT = 16.0, 6.0, 2.0
SHARES = (1.0, 0.75, 0.5, 0.25)
INERTIAL_DRAG, INERTIAL_DRAG_POWER = 0.15, 0.687  # Schiller and Naumann, Z. VDI 77 (1933) 318


def _strength():
    """Gamma R^2 / 4 of each ring, from the downwash when the rotor is at HIGH."""
    apart = [(1.0 - s) * HIGH for s in SHARES]
    return -0.5 * DOWNWASH / sum((R**2 + z**2 + CORE**2) ** -1.5 for z in apart)


STRENGTH = _strength()


@jit
def rotor_height(t):
    """H(t), above LOW."""
    return LOW + (HIGH - LOW) * math.exp(-t / DESCENT)


@jit
def ring(square, zeta):
    """(u_r / r, u_z) of a ring of Gamma R^2 / 4 = 1, at r^2 and height zeta above it."""
    P = square + R * R + zeta * zeta + CORE * CORE
    B = P * P - 4.0 * R * R * square
    scale = math.sqrt(math.sqrt(B)) / (B * B)
    return 3.0 * P * zeta * scale, (2.0 * B - 3.0 * square * (P - 2.0 * R * R)) * scale


@jit
def rotor_wind(x, y, z, t):
    """The wind (u_x, u_y, u_z) at one place and time."""
    square = x * x + y * y
    height = rotor_height(t)
    outwards = 0.0
    upwards = 0.0
    for share in SHARES:
        spread, rise = ring(square, z - share * height)
        mirrored, falling = ring(square, z + share * height)
        outwards += spread - mirrored
        upwards += rise - falling
    return STRENGTH * outwards * x, STRENGTH * outwards * y, STRENGTH * upwards


@jit
def relative_velocity(g, v, t):
    """w = v - wind, and |w|."""
    x, y, z = rotor_wind(g[0], g[1], g[2], t)
    a, b, c = v[0] - x, v[1] - y, v[2] - z
    return a, b, c, math.sqrt(a * a + b * b + c * c)


@jit
def quadratic_drag(g, v, t, constants, out):
    """out[1] <- out[1] - k |w| w.   constants [k]"""
    a, b, c, speed = relative_velocity(g, v, t)
    rate = constants[0] * speed
    out[1, 0] -= rate * a
    out[1, 1] -= rate * b
    out[1, 2] -= rate * c


@jit
def schiller_naumann_drag(g, v, t, constants, out):
    """out[1] <- out[1] - k (1 + 0.15 Re^0.687) w, Re = s |w|.   constants [k, s]"""
    a, b, c, speed = relative_velocity(g, v, t)
    rate = constants[0] * (1.0 + INERTIAL_DRAG * (constants[1] * speed) ** INERTIAL_DRAG_POWER)
    out[1, 0] -= rate * a
    out[1, 1] -= rate * b
    out[1, 2] -= rate * c

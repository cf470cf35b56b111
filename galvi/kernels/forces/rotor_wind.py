"""The wind below a rotor that descends towards the ground: vortex rings and their images.

The axis is z, the ground z = 0. Lengths in m, times in s, speeds in m/s.

R        radius of the rings                          a       radius of their cores
v        downwash at the hub far from the ground: rings below the rotor, no images
H(t)     height of the rotor, LOWEST_ROTOR + (HIGHEST_ROTOR - LOWEST_ROTOR) exp(-t / DESCENT_TIME)
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

from functools import cache

from galvi.kernels.compile.jit import jit_noalloc, set_name
from galvi.kernels.forces.celestial_velocity import LEAST_SQUARE
from galvi.kernels.lie.arithmetic import dot, generic
from galvi.kernels.lie.elementary import exp, inverse_seven_quarters, log, sqrt

R, CORE = 7.0, 2.5
DOWNWASH = 10.0  # m / s, for a hovering helicopter of 3.8 t, by T = 2 rho pi R^2 v^2
HIGHEST_ROTOR, LOWEST_ROTOR, DESCENT_TIME = 16.0, 6.0, 2.0
RING_HEIGHTS = (1.0, 0.75, 0.5, 0.25)
INERTIAL_DRAG, INERTIAL_DRAG_POWER = 0.15, 0.687  # Schiller and Naumann, Z. VDI 77 (1933) 318


def _strength():
    """Gamma R^2 / 4 of each ring, from the downwash when the rotor is at HIGHEST_ROTOR."""
    offsets = [(1.0 - s) * HIGHEST_ROTOR for s in RING_HEIGHTS]
    return -0.5 * DOWNWASH / sum((R**2 + z**2 + CORE**2) ** -1.5 for z in offsets)


STRENGTH = _strength()


@generic
def decay(t):
    """exp(-t / DESCENT_TIME), the factor by which the rotor's height approaches LOWEST_ROTOR."""
    return exp(t * (-1.0 / DESCENT_TIME))


@generic
def rotor_height(decayed):
    """H(t) from ``decayed``, the value of `decay` at t."""
    return LOWEST_ROTOR + (HIGHEST_ROTOR - LOWEST_ROTOR) * decayed


@generic
def ring(square, zeta):
    """(u_r / (3 r), u_z) of a ring of Gamma R^2 / 4 = 1, at r^2 and height zeta above it."""
    P = square + (R * R + CORE * CORE) + zeta * zeta
    scale = inverse_seven_quarters(P * P - 4.0 * R * R * square)
    return P * zeta * scale, (P * (2.0 * P - 3.0 * square) - 2.0 * R * R * square) * scale


@generic
def rotor_wind(q, decayed):
    """The wind (u_x, u_y, u_z) at a point q, at the time t given by ``decayed``, its `decay`."""
    square = q[0] * q[0] + q[1] * q[1]
    height = rotor_height(decayed)
    outwards, upwards = 0.0, 0.0
    for height_ratio in RING_HEIGHTS:
        ring_outwards, ring_upwards = ring(square, q[2] - height_ratio * height)
        image_outwards, image_upwards = ring(square, q[2] + height_ratio * height)
        outwards, upwards = (
            outwards + (ring_outwards - image_outwards),
            upwards + (ring_upwards - image_upwards),
        )
    outwards = 3.0 * STRENGTH * outwards
    return outwards * q[0], outwards * q[1], STRENGTH * upwards


@generic
def quadratic(square, c):
    """The drag rate k |w| and its derivative by log |w|, from square = |w|^2; constants [k]."""
    rate = c[0] * sqrt(square)
    return rate, rate


@generic
def schiller_naumann(square, c):
    """The drag rate k (1 + 0.15 Re^0.687), Re = s |w|, and its derivative by log |w|, from
    square = |w|^2; constants [k, s]."""
    logarithm = log(c[1] * c[1] * square + LEAST_SQUARE)
    inertial = c[0] * (INERTIAL_DRAG * exp(logarithm * (0.5 * INERTIAL_DRAG_POWER)))
    return c[0] + inertial, INERTIAL_DRAG_POWER * inertial


@cache
def drag_of(rate):
    """The force (q, v, t, c) -> 3 values, -rate w with w = v - wind; ``rate`` is `quadratic` or
    `schiller_naumann`."""

    @generic
    def force(q, v, t, c):
        wind = rotor_wind(q, decay(t))
        w = v[0] - wind[0], v[1] - wind[1], v[2] - wind[2]
        factor = -rate(dot(w, w), c)[0]
        return factor * w[0], factor * w[1], factor * w[2]

    return force


@cache
def drag_kernel(rate):
    """A kernel (g, v, t, constants, out) that adds the force of `drag_of` to out[1]."""
    force = drag_of(rate)

    def add(g, v, t, constants, out):
        pull = force(g, v, t, constants)
        for i in range(3):
            out[1, i] += pull[i]

    return jit_noalloc(set_name(add, f"{rate.__name__}_drag"))

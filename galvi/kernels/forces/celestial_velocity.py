"""Forces on point masses that depend on their velocities.

constants  dimension, number of bodies, m and G m (bodies,) each, then blocks, each of its kind, the
           number of the numbers that follow, and these, which the functions below list
"""

from __future__ import annotations

import numpy as np

from galvi.kernels.compile.jit import jit

ONE_SOURCE, EIH, RADIATION, DRAG, TIDES = range(5)
ALL_BODIES = -1  # in place of the index of a body
LEAST_SQUARE = 1e-300  # added to a square whose power or logarithm may be infinite at 0


@jit
def inner(x, y):
    """x . y."""
    total = 0.0
    for k in range(x.size):
        total += x[k] * y[k]
    return total


@jit
def one_source(q, v, mu, numbers, a):
    """Schwarzschild's field of one body in harmonic coordinates, to c^-2; numbers: c, source.

    a = M / (c^2 r^3) [(4 M / r - w.w) x + 4 (x.w) w], x and w from the source, M its mass times G;
    the source recoils (IERS Conventions (2010), eq. 10.12, beta = gamma = 1).
    """
    source = int(numbers[1])
    M = mu[source]
    for i in range(mu.size):
        if i != source:
            x, w = q[i] - q[source], v[i] - v[source]
            r = np.sqrt(inner(x, x))
            radial = 4.0 * M / r - inner(w, w)
            pull = M / (numbers[0] ** 2 * r**3) * (radial * x + 4.0 * inner(x, w) * w)
            a[i] += pull
            a[source] -= mu[i] / M * pull


@jit
def all_sources(q, v, mu, numbers, a):
    """The equations of Einstein, Infeld and Hoffmann to c^-2; numbers: c.

    Newhall, Standish and Williams, Astron. Astrophys. 125 (1983) 150, eq. 1, without its first
    term, Newton's; accelerations in it are Newton's.
    """
    n, newtonian, potentials, scale = (
        mu.size,
        np.zeros(q.shape),
        np.zeros(mu.size),
        numbers[0] ** -2.0,
    )
    for i in range(n):
        for j in range(i + 1, n):
            x = q[j] - q[i]
            square = inner(x, x)
            inverse = 1.0 / np.sqrt(square)
            pull = 1.0 / (square * np.sqrt(square)) * x
            newtonian[i] += mu[j] * pull
            newtonian[j] -= mu[i] * pull
            potentials[i] += mu[j] * inverse
            potentials[j] += mu[i] * inverse
    for i in range(n):
        for j in range(i + 1, n):
            x, w = q[j] - q[i], v[i] - v[j]
            square = inner(x, x)
            inverse = 1.0 / np.sqrt(square)
            along_i, along_j, cube = (
                inner(x, v[i]),
                inner(x, v[j]),
                1.0 / (square * np.sqrt(square)),
            )
            common = -4.0 * inner(v[i], v[j]) - potentials[i] - potentials[j]
            first, second = inner(v[i], v[i]), inner(v[j], v[j])
            onto_i = (
                common + first + 2.0 * second - 3.0 * potentials[i] + 0.5 * inner(x, newtonian[j])
            )
            onto_j = (
                common + second + 2.0 * first - 3.0 * potentials[j] - 0.5 * inner(x, newtonian[i])
            )
            onto_i -= 1.5 * along_j * along_j / square
            onto_j -= 1.5 * along_i * along_i / square
            to_i, to_j = scale * mu[j] * cube, scale * mu[i] * cube
            a[i] += to_i * onto_i * x + to_i * (3.0 * along_j - 4.0 * along_i) * w
            a[j] -= to_j * onto_j * x + to_j * (4.0 * along_j - 3.0 * along_i) * w
            a[i] += 3.5 * scale * mu[j] * inverse * newtonian[j]
            a[j] += 3.5 * scale * mu[i] * inverse * newtonian[i]


@jit
def radiation(q, v, mu, numbers, a):
    """Radiation pressure and Poynting-Robertson drag; numbers: c, source, and beta of each body.

    a = beta M / r^2 [(1 - x.w / (r c)) x / r - w / c], without recoil (Burns, Lamy and Soter,
    Icarus 40 (1979) 1, eq. 5).
    """
    c, source = numbers[0], int(numbers[1])
    for i in range(mu.size):
        if numbers[2 + i] != 0.0:
            x, w = q[i] - q[source], v[i] - v[source]
            r = np.sqrt(inner(x, x))
            pressure = numbers[2 + i] * mu[source] / r**2
            a[i] += pressure * ((1.0 - inner(x, w) / (r * c)) / r * x - w / c)


@jit
def drag(q, v, mu, numbers, a):
    """a = -k |v|^(n - 1) v; numbers: n, and k of each body."""
    for i in range(mu.size):
        if numbers[1 + i] != 0.0:
            square = inner(v[i], v[i]) + LEAST_SQUARE
            a[i] -= numbers[1 + i] * square ** (0.5 * (numbers[0] - 1.0)) * v[i]


@jit
def tides(q, v, mu, numbers, a):
    """Tides with a constant time lag; numbers: body, k2 radius^5, lag, raising body, spin (3,).

    The raising body may be ALL_BODIES. The body, of mass M, at x from the raising one, of mass m,
    is accelerated by -3 k2 R^5 m^2 / (M r^8) [(1 + 3 lag x.w / r^2) x + lag (w' - spin x x)],
    masses times G and w' the part of w across x; the other one recoils (Hut, Astron. Astrophys. 99
    (1981) 126, eq. 8).
    """
    body, lag, spin = int(numbers[0]), numbers[2], numbers[4:7]
    for i in range(mu.size):
        if i != body and mu[i] > 0.0 and (numbers[3] == ALL_BODIES or numbers[3] == i):
            x, w = q[body] - q[i], v[body] - v[i]
            square = inner(x, x)
            rate = inner(x, w) / square
            spin_velocity = np.empty(x.size)
            spin_velocity[0], spin_velocity[1] = -spin[2] * x[1], spin[2] * x[0]
            if x.size == 3:
                spin_velocity[0] += spin[1] * x[2]
                spin_velocity[1] -= spin[0] * x[2]
                spin_velocity[2] = spin[0] * x[1] - spin[1] * x[0]
            pull = (
                -3.0
                * numbers[1]
                * mu[i]
                / square**4
                * ((1.0 + 3.0 * lag * rate) * x + lag * (w - rate * x - spin_velocity))
            )
            a[body] += mu[i] / mu[body] * pull
            a[i] -= pull


@jit
def accelerations_of_blocks(q, v, t, constants):
    """The accelerations (bodies, D) of all blocks at q and v (bodies, D)."""
    n = int(constants[1])
    mu, a, block_start = constants[2 + n : 2 + 2 * n], np.zeros(q.shape), 2 + 2 * n
    while block_start < constants.size:
        kind, numbers = (
            constants[block_start],
            constants[block_start + 2 : block_start + 2 + int(constants[block_start + 1])],
        )
        if kind == ONE_SOURCE:
            one_source(q, v, mu, numbers, a)
        elif kind == EIH:
            all_sources(q, v, mu, numbers, a)
        elif kind == RADIATION:
            radiation(q, v, mu, numbers, a)
        elif kind == DRAG:
            drag(q, v, mu, numbers, a)
        else:
            tides(q, v, mu, numbers, a)
        block_start += 2 + numbers.size
    return a


@jit
def add_forces(q, v, t, constants, out):
    """out[1] <- out[1] + m a, for galvi.kernels.forces.lagrangian_derivatives."""
    n, D = int(constants[1]), int(constants[0])
    a = accelerations_of_blocks(q.reshape((n, D)), v.reshape((n, D)), t, constants)
    for i in range(n):
        for x in range(D):
            out[1, i * D + x] += constants[2 + i] * a[i, x]

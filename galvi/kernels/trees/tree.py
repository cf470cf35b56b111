"""Lagrangian of a tree of rigid bodies by recursion, for lanes, numbers, arrays and kernels alike.

Each joint has a frame: for a hinge and a slide, on the axis, which is its z axis; for a ball joint,
at its centre; for a free joint, that of the body, whose velocities are that of the origin in space,
then w. Frame 0 is the world. With C and r the rotation and the displacement from a joint's frame to
that of the joint before it, S the joint's axes, X = (C, r), twists V = (w, v) and wrenches P = (l,
f) in the joint's frame at its origin,

    U_j = X_j^-1 V_up(j),   V_j = U_j + S_j v_j,   P_j = I_j V_j + sum over next joints of X_k P_k,
    dL/dv_j = S_j^T P_j + armature v_j,
    dL/dq_j = S_j^T (ad_U^T P_j + m_j (c_j x g_j, g_j)) - dV/dq_j,
    ad_U^T P = (l x w + f x v, f x w)

with m_j, c_j mass and centre of all that the joint carries, and g_j gravity in its frame: moving a
joint by S_j e changes V_j by -[S_j e, U_j] and turns what it carries in the field (Featherstone,
Rigid Body Dynamics Algorithms, ch. 6, for the mass by composite bodies).

c     HEAD numbers: number of joints, gravity (3,), mass times centre of fixed bodies (3,); then
      JOINT numbers for each joint, see the indices below
work  STRIDE numbers for each frame, see the indices below, from zeros
q, v  entries and velocities of all joints
"""

import numpy as np

from galvi.kernels.compile.jit import jit
from galvi.kernels.lie.arithmetic import generic
from galvi.kernels.lie.elementary import atan2, sine_cosine, sqrt
from galvi.kernels.trees.sparse import (
    cross,
    difference_of,
    dot,
    keep,
    may_be_nonzero,
    minus,
    plus,
    rotated,
    rotated_back,
    scaled,
    sum_of,
    symmetric,
    times,
    triple,
)

HINGE, SLIDE, BALL, FREE = range(4)
DOFS, ENTRIES = (1, 1, 3, 6), (1, 1, 9, 12)  # of a free joint: its origin, then its rotation
HEAD, JOINT = 7, 43
# of a joint: its kind, the joint before it (0 for none), its first velocity and entry; r and the
# rows of C at 0; mass, mass times centre, inertia about the origin; the rest's coordinate or matrix
KIND, UP, DOF, ENTRY, SHIFT, TURN, MASS, MOMENT = 0, 1, 2, 3, 4, 7, 16, 17
INERTIA, ARMATURE, STIFFNESS, ZERO, REST = 20, 26, 27, 28, 29  # xx, xy, xz, yy, yz, zz
REST_PLACE = REST + 9
# of a frame in work
W, V, UW, UV, FIELD, C, R, L, F, M, H, J = 0, 3, 6, 9, 12, 15, 24, 27, 30, 33, 34, 37
STRIDE = 43
# Added to a square, so that x / |x| is 0 at 0, and an angle over its sine 1.
LEAST_SINE_SQUARE = 1e-200


@generic
def place_joint(c, k, q, work, a):
    """Set C and r of the joint at k of c, at a of work, from its coordinates."""
    kind, entry = int(c[k + KIND]), int(c[k + ENTRY])
    keep(triple(c, k + SHIFT), work, a + R)
    for i in range(3):
        row = triple(c, k + TURN + 3 * i)
        if kind == HINGE:
            sine, cosine = sine_cosine(minus(q[entry], c[k + ZERO]))
            along = plus(times(row[0], cosine), times(row[1], sine))
            across = minus(times(row[1], cosine), times(row[0], sine))
            row = along, across, row[2]
        elif kind == SLIDE:
            work[a + R + i] = plus(work[a + R + i], times(row[2], minus(q[entry], c[k + ZERO])))
        elif kind == BALL:
            row = rotated_back(q, entry, row)
        else:
            row = triple(q, entry + 3 + 3 * i)
            work[a + R + i] = q[entry + i]
        keep(row, work, a + C + 3 * i)


@generic
def outward(c, q, v, work):
    """Set C, r, U, V and gravity of each joint, and the momentum, mass and first moment of its
    body."""
    keep(triple(c, 1), work, FIELD)
    keep(triple(c, 4), work, H)
    for j in range(1, int(c[0]) + 1):
        k, a = HEAD + JOINT * (j - 1), STRIDE * j
        kind, up, dof = int(c[k + KIND]), STRIDE * int(c[k + UP]), int(c[k + DOF])
        place_joint(c, k, q, work, a)
        w = triple(work, up + W)
        swept = sum_of(triple(work, up + V), cross(w, triple(work, a + R)))
        w, velocity = rotated_back(work, a + C, w), rotated_back(work, a + C, swept)
        keep(rotated_back(work, a + C, triple(work, up + FIELD)), work, a + FIELD)
        if kind == FREE:  # on the world, U = 0; what R turns is the velocity in space
            velocity = rotated_back(work, a + C, triple(v, dof))
        keep(w, work, a + UW)
        keep(velocity, work, a + UV)
        if kind == HINGE:
            w = w[0], w[1], plus(w[2], v[dof])
        elif kind == SLIDE:
            velocity = velocity[0], velocity[1], plus(velocity[2], v[dof])
        else:
            w = sum_of(w, triple(v, dof + DOFS[kind] - 3))
        m, h = c[k + MASS], triple(c, k + MOMENT)
        keep(w, work, a + W)
        keep(velocity, work, a + V)
        keep(sum_of(symmetric(c, k + INERTIA, w), cross(h, velocity)), work, a + L)
        keep(difference_of(scaled(m, velocity), cross(h, w)), work, a + F)
        work[a + M] = m
        keep(h, work, a + H)


@generic
def inward(c, v, work, tau, mu):
    """tau <- dL/dq without the springs, mu <- dL/dv; masses and first moments in work become those
    of all bodies that each joint carries."""
    for j in range(int(c[0]), 0, -1):
        k, a = HEAD + JOINT * (j - 1), STRIDE * j
        kind, up, dof = int(c[k + KIND]), STRIDE * int(c[k + UP]), int(c[k + DOF])
        w, velocity, field = (triple(work, a + UW), triple(work, a + UV), triple(work, a + FIELD))
        l, f = triple(work, a + L), triple(work, a + F)
        m, h = work[a + M], triple(work, a + H)
        moment = sum_of(sum_of(cross(l, w), cross(f, velocity)), cross(h, field))
        force = sum_of(cross(f, w), scaled(m, field))
        if kind == HINGE:
            tau[dof], mu[dof] = moment[2], l[2]
        elif kind == SLIDE:
            tau[dof], mu[dof] = force[2], f[2]
        else:
            keep(moment, tau, dof + DOFS[kind] - 3)
            keep(l, mu, dof + DOFS[kind] - 3)
            if kind == FREE:
                keep(scaled(m, triple(work, up + FIELD)), tau, dof)
                keep(rotated(work, a + C, f), mu, dof)
        for i in range(DOFS[kind]):
            mu[dof + i] = plus(mu[dof + i], times(c[k + ARMATURE], v[dof + i]))
        r = triple(work, a + R)
        l, f, h = rotated(work, a + C, l), rotated(work, a + C, f), rotated(work, a + C, h)
        l = sum_of(l, cross(r, f))
        h = sum_of(h, scaled(m, r))
        keep(sum_of(triple(work, up + L), l), work, up + L)
        keep(sum_of(triple(work, up + F), f), work, up + F)
        keep(sum_of(triple(work, up + H), h), work, up + H)
        work[up + M] = plus(work[up + M], m)


@generic
def rotation_vector(q, entry, c, k):
    """The rotation vector from the matrix at index k of c to that at index ``entry`` of q."""
    a0, a1, a2 = triple(c, k), triple(c, k + 3), triple(c, k + 6)
    b0, b1, b2 = triple(q, entry), triple(q, entry + 3), triple(q, entry + 6)
    turn = (  # columns of A^T B
        sum_of(sum_of(scaled(b0[0], a0), scaled(b1[0], a1)), scaled(b2[0], a2)),
        sum_of(sum_of(scaled(b0[1], a0), scaled(b1[1], a1)), scaled(b2[1], a2)),
        sum_of(sum_of(scaled(b0[2], a0), scaled(b1[2], a1)), scaled(b2[2], a2)),
    )
    twice = (
        minus(turn[1][2], turn[2][1]),
        minus(turn[2][0], turn[0][2]),
        minus(turn[0][1], turn[1][0]),
    )
    sine = sqrt(plus(0.25 * dot(twice, twice), LEAST_SINE_SQUARE))
    cosine = 0.5 * (turn[0][0] + turn[1][1] + turn[2][2] - 1.0)
    return scaled(0.5 * (atan2(sine, cosine) / sine), twice)


@generic
def springs(c, q, tau):
    """Add the forces of the springs to tau; returns their energy."""
    energy = 0.0
    for j in range(1, int(c[0]) + 1):
        k = HEAD + JOINT * (j - 1)
        stiffness, kind = c[k + STIFFNESS], int(c[k + KIND])
        dof, entry = int(c[k + DOF]), int(c[k + ENTRY])
        if kind < BALL:
            away = minus(q[entry], c[k + REST])
            pull = times(stiffness, away)
            tau[dof] = minus(tau[dof], pull)
            energy = plus(energy, times(0.5, times(pull, away)))
        elif may_be_nonzero(stiffness):
            if kind == FREE:
                away = difference_of(triple(q, entry), triple(c, k + REST_PLACE))
                keep(difference_of(triple(tau, dof), scaled(stiffness, away)), tau, dof)
                energy = plus(energy, times(0.5 * stiffness, dot(away, away)))
                dof, entry = dof + 3, entry + 3
            turn = rotation_vector(q, entry, c, k + REST)
            keep(difference_of(triple(tau, dof), scaled(stiffness, turn)), tau, dof)
            energy = plus(energy, times(0.5 * stiffness, dot(turn, turn)))
    return energy


@generic
def add_inertia(work, a, up):
    """Add the inertia of the frame at a of work to that of the joint before it, at ``up``."""
    m, r = work[a + M], triple(work, a + R)
    h = rotated(work, a + C, triple(work, a + H))
    x, y, z = triple(work, a + C), triple(work, a + C + 3), triple(work, a + C + 6)
    jx, jy, jz = (symmetric(work, a + J, x), symmetric(work, a + J, y), symmetric(work, a + J, z))
    moved = sum_of(h, sum_of(h, scaled(m, r)))  # 2 h + m r
    k = up + J
    xx, yy, zz = times(moved[0], r[0]), times(moved[1], r[1]), times(moved[2], r[2])
    work[k] = plus(work[k], plus(dot(x, jx), plus(yy, zz)))
    work[k + 3] = plus(work[k + 3], plus(dot(y, jy), plus(xx, zz)))
    work[k + 5] = plus(work[k + 5], plus(dot(z, jz), plus(xx, yy)))
    half = sum_of(h, scaled(m, r))  # h r^T + r h^T + m r r^T
    xy = plus(times(half[0], r[1]), times(r[0], h[1]))
    xz = plus(times(half[0], r[2]), times(r[0], h[2]))
    yz = plus(times(half[1], r[2]), times(r[1], h[2]))
    work[k + 1] = plus(work[k + 1], minus(dot(x, jy), xy))
    work[k + 2] = plus(work[k + 2], minus(dot(x, jz), xz))
    work[k + 4] = plus(work[k + 4], minus(dot(y, jz), yz))


@generic
def component(kind, work, a, l, f, i):
    """The component of the wrench (l, f) along the i-th axis of a joint."""
    if kind == HINGE:
        return l[2]
    if kind == SLIDE:
        return f[2]
    return dot(triple(work, a + C + 3 * i), f) if kind == FREE and i < 3 else l[i % 3]


@generic
def unit(i):
    """The i-th axis."""
    return (1.0 if i == 0 else 0.0), (1.0 if i == 1 else 0.0), (1.0 if i == 2 else 0.0)


@generic
def composite(c, work, mass):
    """mass[i (i + 1) / 2 + j] <- d2L/dv_i dv_j for j <= i, after ``inward``; mass is 0 before."""
    n = int(c[0])
    for j in range(1, n + 1):
        for i in range(6):
            work[STRIDE * j + J + i] = c[HEAD + JOINT * (j - 1) + INERTIA + i]
    for j in range(n, 0, -1):
        k, a = HEAD + JOINT * (j - 1), STRIDE * j
        kind, dof = int(c[k + KIND]), int(c[k + DOF])
        m, h = work[a + M], triple(work, a + H)
        for i in range(DOFS[kind]):
            row = (dof + i) * (dof + i + 1) // 2
            if kind == FREE and i < 3:
                mass[row + dof + i] = plus(m, c[k + ARMATURE])
                continue
            axis = unit(i % 3 if kind > SLIDE else 2)
            if kind == SLIDE:
                l, f = cross(h, axis), scaled(m, axis)
            else:
                l, f = symmetric(work, a + J, axis), cross(axis, h)
            for b in range(i + 1):
                mass[row + dof + b] = component(kind, work, a, l, f, b)
            mass[row + dof + i] = plus(mass[row + dof + i], c[k + ARMATURE])
            joint = j
            for _ in range(n):
                offset, before = STRIDE * joint, int(c[HEAD + JOINT * (joint - 1) + UP])
                if before == 0:
                    break
                f, l = rotated(work, offset + C, f), rotated(work, offset + C, l)
                l = sum_of(l, cross(triple(work, offset + R), f))
                parent_row = HEAD + JOINT * (before - 1)
                type_, first = int(c[parent_row + KIND]), int(c[parent_row + DOF])
                for b in range(DOFS[type_]):
                    mass[row + first + b] = component(type_, work, STRIDE * before, l, f, b)
                joint = before
        if int(c[k + UP]) > 0:
            add_inertia(work, a, STRIDE * int(c[k + UP]))


class ConstantsWithLiterals:
    """Constants some of which are literal numbers, so that code for lanes depends on them.

    Parameters
    ----------
    literals
        index -> number
    """

    def __init__(self, literals, constants):
        self.literals, self.constants = literals, constants

    def __getitem__(self, k):
        literal = self.literals.get(k)
        return self.constants[k] if literal is None else literal


def recursion(c, q, v, d):
    """(dL/dq, dL/dv, mass (d (d + 1) / 2,), V), for lanes, numbers or arrays."""
    work = [0.0] * (STRIDE * (int(c[0]) + 1))
    tau, mu, mass = [0.0] * d, [0.0] * d, [0.0] * (d * (d + 1) // 2)
    outward(c, q, v, work)
    inward(c, v, work, tau, mu)
    composite(c, work, mass)
    spring_energy = springs(c, q, tau)
    return tau, mu, mass, minus(spring_energy, dot(triple(c, 1), triple(work, H)))


def tree(d, literals):
    """The law of a tree with d velocities; ``literals``, index -> number, replace constants."""

    def law(q, v, t, c):
        tau, mu, mass, _ = recursion(ConstantsWithLiterals(literals, c), q, v, d)
        return tau, mu, [mass[i * (i + 1) // 2 : (i + 1) * (i + 2) // 2] for i in range(d)]

    return law


@jit
def tree_slopes(g, v, t, constants, out):
    """out <- dL/dv and, left-trivialised, dL/dq, as galvi.kernels.forces.lagrangian_derivatives."""
    work = np.zeros(STRIDE * (int(constants[0]) + 1))
    outward(constants, g, v, work)
    inward(constants, v, work, out[1], out[0])
    springs(constants, g, out[1])


@jit
def tree_mass(g, constants, mass):
    """mass (d, d) <- d2L/dv2; returns the potential energy."""
    d, work = mass.shape[0], np.zeros(STRIDE * (int(constants[0]) + 1))
    zero_velocity, packed, out = np.zeros(d), np.zeros(d * (d + 1) // 2), np.zeros((2, d))
    outward(constants, g, zero_velocity, work)
    inward(constants, zero_velocity, work, out[1], out[0])
    composite(constants, work, packed)
    for i in range(d):
        for j in range(i + 1):
            mass[i, j] = mass[j, i] = packed[i * (i + 1) // 2 + j]
    return springs(constants, g, out[1]) - (
        constants[1] * work[H] + constants[2] * work[H + 1] + constants[3] * work[H + 2]
    )


@jit
def tree_states(places, rates, constants, value, at_rest, momenta, in_space):
    """At n states: value and at_rest (n,) <- L and L without velocities, momenta (n, d) <- dL/dv,
    in_space (n, 6) <- angular momentum about the origin of space, and momentum, of all bodies."""
    n, d = rates.shape
    tau, frames = np.zeros(d), STRIDE * (int(constants[0]) + 1)
    for k in range(n):
        work, mu = np.zeros(frames), momenta[k]
        outward(constants, places[k], rates[k], work)
        inward(constants, rates[k], work, tau, mu)
        at_rest[k] = (
            constants[1] * work[H] + constants[2] * work[H + 1] + constants[3] * work[H + 2]
        ) - springs(constants, places[k], tau)
        value[k] = at_rest[k]
        for i in range(d):
            value[k] += 0.5 * rates[k, i] * mu[i]
        for i in range(6):
            in_space[k, i] = work[L + i]


@jit
def tree_forces(g, v, constants, tau):
    """tau (d,) <- M v' by Newton and Euler; tau is 0 before.

    That is the force of the springs, minus the wrench that moves the bodies with v' = 0,
    d(I V)/dt = I A - ad_V^T (I V), less gravity.
    """
    n = int(constants[0])
    work, A = np.zeros(STRIDE * (n + 1)), np.zeros(6 * (n + 1))
    outward(constants, g, v, work)
    springs(constants, g, tau)
    for j in range(1, n + 1):
        k, a = HEAD + JOINT * (j - 1), STRIDE * j
        before = 6 * int(constants[k + UP])
        u, U, w, velocity = (
            triple(work, a + UW),
            triple(work, a + UV),
            triple(work, a + W),
            triple(work, a + V),
        )
        alpha = triple(A, before)
        swept = sum_of(triple(A, before + 3), cross(alpha, triple(work, a + R)))
        alpha, swept = rotated_back(work, a + C, alpha), rotated_back(work, a + C, swept)
        if int(constants[k + KIND]) == FREE:
            swept = cross(velocity, w)  # R^T x' turns
        else:
            turning, moving = difference_of(w, u), difference_of(velocity, U)
            alpha = sum_of(alpha, cross(u, turning))
            swept = sum_of(swept, sum_of(cross(u, moving), cross(U, turning)))
        keep(alpha, A, 6 * j)
        keep(swept, A, 6 * j + 3)
        m, h, field = work[a + M], triple(work, a + H), triple(work, a + FIELD)
        l, f, pull = triple(work, a + L), triple(work, a + F), difference_of(swept, field)
        moment = sum_of(symmetric(constants, k + INERTIA, alpha), cross(h, pull))
        keep(difference_of(moment, sum_of(cross(l, w), cross(f, velocity))), work, a + L)
        keep(
            difference_of(difference_of(scaled(m, pull), cross(h, alpha)), cross(f, w)), work, a + F
        )
    for j in range(n, 0, -1):
        k, a = HEAD + JOINT * (j - 1), STRIDE * j
        kind, up, dof = int(constants[k + KIND]), int(constants[k + UP]), int(constants[k + DOF])
        l, f = triple(work, a + L), triple(work, a + F)
        for i in range(DOFS[kind]):
            tau[dof + i] -= component(kind, work, a, l, f, i)
        l, f = rotated(work, a + C, l), rotated(work, a + C, f)
        l = sum_of(l, cross(triple(work, a + R), f))
        keep(sum_of(triple(work, STRIDE * up + L), l), work, STRIDE * up + L)
        keep(sum_of(triple(work, STRIDE * up + F), f), work, STRIDE * up + F)

"""Forces on a tree besides those of its Lagrangian, for lanes, numbers and kernels alike.

A pull has a length l with arms dl/dq, of joints or of a path through points of the links, and

    f = (dl/dq)^T F,   F = F_0 - x (k + k_1 x + k_2 x^2) - l' (b + b_1 |l'| + b_2 l'^2)

x is the amount by which l exceeds HIGH or, negative, falls below LOW; these two are equal but for a
spring with slack. An actuator's pull may have limits: beyond them it is NaN, so that the step
fails. Other forces are wrenches on the links in their joints' frames, summed in ``work`` of
galvi.kernels.trees.tree and carried inwards as there.

c       constants of galvi.kernels.trees.tree; then FORCES_HEAD numbers, the d coefficients of
        damping, and the rows of each kind, one kind after the other; for their entries see the
        indices below
world   12 numbers for each frame, its rotation by rows and its position in the world, from zeros
motors  (d,) from zeros, forces of actuators through joints
"""

import numpy as np

from galvi.kernels.compile.jit import jit
from galvi.kernels.lie.arithmetic import generic, where
from galvi.kernels.lie.elementary import sqrt
from galvi.kernels.trees import tree
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
    times,
    triple,
)
from galvi.kernels.trees.tree import FIELD, LEAST_SINE_SQUARE, STRIDE, F, L, R, V, W

# Of FORCES_HEAD numbers: whether there are wrenches; numbers of rows; wind in the world.
WRENCHES, PULLS, BOUNDS, WEIGHTS, PUSHES, WET, WIND, FORCES_HEAD = 0, 1, 2, 3, 4, 5, 6, 9
# Of a pull: numbers of arms and points; whether it is an actuator's, has slack, has limits; its
# other numbers.
ARMS, POINTS, OWN, SLACK, LIMITED, CONSTANT, LOW, HIGH, LEAST, MOST = range(10)
OFFSET, SPRING, DAMPER, PULL = 10, 11, 14, 17
ARM, POINT = 3, 5  # velocity, entry (-1: none), ratio; frame, place (3,), share of the way to it
BOUND, WEIGHT, PUSH = 3, 5, 10  # velocity and limits; frame, m, point; frame, point, f, moment
WET_BODY = 21  # frame, centre, axes by rows, b of w and v, and b_1 of w (3,) and v (3,)
NAN = float("nan")


@generic
def absolute(x):
    """|x|."""
    return where(x < 0.0, minus(0.0, x), x)


@generic
def within(x, c, k):
    """x, or NaN where it is outside [c[k], c[k + 1]]."""
    return where(x <= c[k + 1], where(x >= c[k], x, NAN), NAN)


@generic
def stretch(c, k, l):
    """x of the pull at k of c, for the length l."""
    if int(c[k + SLACK]) > 0:
        above, below = minus(l, c[k + HIGH]), minus(l, c[k + LOW])
        return where(above > 0.0, above, where(below < 0.0, below, 0.0))
    return minus(l, c[k + LOW])


@generic
def pull_of(c, k, l, rate):
    """F of the pull at k of c, for the length l and its rate."""
    x, s, b = stretch(c, k, l), k + SPRING, k + DAMPER
    stiffness = plus(c[s], times(x, plus(c[s + 1], times(x, c[s + 2]))))
    damping = c[b]
    if may_be_nonzero(c[b + 1]):
        damping = plus(damping, times(c[b + 1], absolute(rate)))
    damping = plus(damping, times(c[b + 2], times(rate, rate)))
    force = minus(minus(c[k + CONSTANT], times(x, stiffness)), times(rate, damping))
    return within(force, c, k + LEAST) if int(c[k + LIMITED]) > 0 else force


@generic
def point_in_world(c, k, work, world):
    """Position and velocity in the world of the point at k of c, in a frame."""
    a, b, p = STRIDE * int(c[k]), 12 * int(c[k]), triple(c, k + 1)
    moving = sum_of(triple(work, a + V), cross(triple(work, a + W), p))
    return sum_of(triple(world, b + 9), rotated(world, b, p)), rotated(world, b, moving)


@generic
def safe_length(along):
    """The length of a triple, but 1e-100 where it is 0, so that a force along it is 0 there."""
    return sqrt(plus(dot(along, along), LEAST_SINE_SQUARE))


@generic
def add_force_in_world(work, world, c, k, force):
    """Add a force, by its components in the world, at the point at k of c."""
    a, b = STRIDE * int(c[k]), 12 * int(c[k])
    add_force(work, a, triple(c, k + 1), rotated_back(world, b, force))


@generic
def add_force(work, a, p, force):
    """Add a force at a point p of the frame at a of work."""
    keep(sum_of(triple(work, a + L), cross(p, force)), work, a + L)
    keep(sum_of(triple(work, a + F), force), work, a + F)


@generic
def add_pull(c, k, q, v, work, world, tau, motors):
    """Add the pull at k of c; returns the index of the next pull."""
    first, arms, points = k + PULL, int(c[k + ARMS]), int(c[k + POINTS])
    l, rate, path = c[k + OFFSET], 0.0, first + ARM * arms
    for i in range(arms):
        m = first + ARM * i
        if int(c[m + 1]) >= 0:
            l = plus(l, times(c[m + 2], q[int(c[m + 1])]))
        rate = plus(rate, times(c[m + 2], v[int(c[m])]))
    for i in range(1, points):
        m = path + POINT * i
        if may_be_nonzero(c[m + 4]):
            start, start_velocity = point_in_world(c, m - POINT, work, world)
            to, end_velocity = point_in_world(c, m, work, world)
            along = difference_of(to, start)
            length = safe_length(along)
            l = plus(l, times(c[m + 4], length))
            rate = plus(
                rate,
                times(c[m + 4], dot(along, difference_of(end_velocity, start_velocity)) / length),
            )
    force = pull_of(c, k, l, rate)
    for i in range(arms):
        m = first + ARM * i
        dof, torque = int(c[m]), times(c[m + 2], force)
        tau[dof] = plus(tau[dof], torque)
        if int(c[k + OWN]) > 0:
            motors[dof] = plus(motors[dof], torque)
    for i in range(1, points):
        m = path + POINT * i
        if may_be_nonzero(c[m + 4]):
            along = difference_of(
                point_in_world(c, m, work, world)[0], point_in_world(c, m - POINT, work, world)[0]
            )
            end_force = scaled(times(c[m + 4], force) / safe_length(along), along)
            add_force_in_world(work, world, c, m, end_force)
            add_force_in_world(work, world, c, m - POINT, scaled(-1.0, end_force))
    return path + POINT * points


@generic
def add_drag(c, k, wind, work, world):
    """Add the drag of a medium on a body: -(b + b_1 |u|) u for each component u of the linear and
    angular velocity along the body's axes."""
    a, p, axes = STRIDE * int(c[k]), triple(c, k + 1), k + 4
    w = triple(work, a + W)
    v = sum_of(triple(work, a + V), cross(w, p))
    v = difference_of(v, rotated_back(world, 12 * int(c[k]), triple(c, wind)))
    w, v = rotated_back(c, axes, w), rotated_back(c, axes, v)
    moment = (
        resistance(c[k + 13], c[k + 15], w[0]),
        resistance(c[k + 13], c[k + 16], w[1]),
        resistance(c[k + 13], c[k + 17], w[2]),
    )
    force = (
        resistance(c[k + 14], c[k + 18], v[0]),
        resistance(c[k + 14], c[k + 19], v[1]),
        resistance(c[k + 14], c[k + 20], v[2]),
    )
    keep(sum_of(triple(work, a + L), rotated(c, axes, moment)), work, a + L)
    add_force(work, a, p, rotated(c, axes, force))


@generic
def resistance(b, b_1, u):
    """-(b + b_1 |u|) u."""
    return minus(0.0, times(u, plus(b, times(b_1, absolute(u)))))


@generic
def set_world_frames(c, work, world):
    """Set the rotation and position of each frame in the world, after ``outward``, and reset the
    wrenches in work to 0."""
    world[0] = world[4] = world[8] = 1.0
    for j in range(int(c[0]) + 1):
        a, b = STRIDE * j, 12 * j
        if j > 0:
            up = 12 * int(c[tree.HEAD + tree.JOINT * (j - 1) + tree.UP])
            for i in range(3):
                keep(rotated_back(work, a + tree.C, triple(world, up + 3 * i)), world, b + 3 * i)
            moved = rotated(world, up, triple(work, a + R))
            keep(sum_of(triple(world, up + 9), moved), world, b + 9)
        keep((0.0, 0.0, 0.0), work, a + L)
        keep((0.0, 0.0, 0.0), work, a + F)


@generic
def add_wrenches(c, work, tau):
    """Add to tau the forces of the wrenches in work along the joints."""
    for j in range(int(c[0]), 0, -1):
        k, a = tree.HEAD + tree.JOINT * (j - 1), STRIDE * j
        kind, dof, up = int(c[k + tree.KIND]), int(c[k + tree.DOF]), STRIDE * int(c[k + tree.UP])
        l, f = triple(work, a + L), triple(work, a + F)
        for i in range(tree.DOFS[kind]):
            tau[dof + i] = plus(tau[dof + i], tree.component(kind, work, a, l, f, i))
        l, f = rotated(work, a + tree.C, l), rotated(work, a + tree.C, f)
        l = sum_of(l, cross(triple(work, a + R), f))
        keep(sum_of(triple(work, up + L), l), work, up + L)
        keep(sum_of(triple(work, up + F), f), work, up + F)


@generic
def joint_forces(c, d, q, v, work, world, tau, motors):
    """Add all forces to tau (d,)."""
    s = tree.HEAD + tree.JOINT * int(c[0])
    for i in range(d):
        tau[i] = minus(tau[i], times(c[s + FORCES_HEAD + i], v[i]))
    if int(c[s + WRENCHES]) > 0:
        tree.outward(c, q, v, work)
        set_world_frames(c, work, world)
    k = s + FORCES_HEAD + d
    for _ in range(int(c[s + PULLS])):
        k = add_pull(c, k, q, v, work, world, tau, motors)
    for _ in range(int(c[s + BOUNDS])):
        dof = int(c[k])
        tau[dof] = plus(tau[dof], minus(within(motors[dof], c, k + 1), motors[dof]))
        k += BOUND
    for _ in range(int(c[s + WEIGHTS])):
        a = STRIDE * int(c[k])
        add_force(work, a, triple(c, k + 2), scaled(times(-1.0, c[k + 1]), triple(work, a + FIELD)))
        k += WEIGHT
    for _ in range(int(c[s + PUSHES])):
        a = STRIDE * int(c[k])
        add_force(work, a, triple(c, k + 1), triple(c, k + 4))
        keep(sum_of(triple(work, a + L), triple(c, k + 7)), work, a + L)
        k += PUSH
    for _ in range(int(c[s + WET])):
        add_drag(c, k, s + WIND, work, world)
        k += WET_BODY
    if int(c[s + WRENCHES]) > 0:
        add_wrenches(c, work, tau)


def law(d, literals):
    """The force (q, v, t, constants) -> d values, for lanes; see galvi.kernels.trees.tree.tree."""

    def force(q, v, t, c):
        constants = tree.ConstantsWithLiterals(literals, c)
        frames, tau, motors = int(constants[0]) + 1, [0.0] * d, [0.0] * d
        work, world = [0.0] * (STRIDE * frames), [0.0] * (12 * frames)
        joint_forces(constants, d, q, v, work, world, tau, motors)
        return tau

    return force


@jit
def tree_joint_forces(q, v, t, constants, out):
    """out[1] <- out[1] + the forces."""
    d, frames = v.size, int(constants[0]) + 1
    work, world, motors = np.zeros(STRIDE * frames), np.zeros(12 * frames), np.zeros(d)
    joint_forces(constants, d, q, v, work, world, out[1], motors)


@generic
def spring_energy(c, k, l):
    """The energy of the spring and of the constant force of the pull at k of c, for the length
    l."""
    x, s = stretch(c, k, l), k + SPRING
    terms = plus(0.5 * c[s], times(x, plus(c[s + 1] / 3.0, times(0.25 * x, c[s + 2]))))
    return minus(times(times(x, x), terms), times(c[k + CONSTANT], l))


@jit
def tree_force_potentials(places, d, constants, energies):
    """energies (n,) <- the energies of the springs and constant forces of all pulls but those of
    actuators, and of the forces that hold up weights, at n configurations (n, r).

    ``d`` is the number of velocities.
    """
    frames, s = int(constants[0]) + 1, tree.HEAD + tree.JOINT * int(constants[0])
    zero_velocity = np.zeros(d)
    for n in range(places.shape[0]):
        work, world, q = np.zeros(STRIDE * frames), np.zeros(12 * frames), places[n]
        tree.outward(constants, q, zero_velocity, work)
        set_world_frames(constants, work, world)
        k, energies[n] = s + FORCES_HEAD + d, 0.0
        for _ in range(int(constants[s + PULLS])):
            arms, points = int(constants[k + ARMS]), int(constants[k + POINTS])
            l, first = constants[k + OFFSET], k + PULL
            for m in range(first, first + ARM * arms, ARM):
                if int(constants[m + 1]) >= 0:
                    l += constants[m + 2] * q[int(constants[m + 1])]
            path = first + ARM * arms
            for m in range(path + POINT, path + POINT * points, POINT):
                to = point_in_world(constants, m, work, world)[0]
                along = difference_of(to, point_in_world(constants, m - POINT, work, world)[0])
                l += constants[m + 4] * np.sqrt(dot(along, along))
            if int(constants[k + OWN]) == 0:
                energies[n] += spring_energy(constants, k, l)
            k = path + POINT * points
        k += BOUND * int(constants[s + BOUNDS])
        for _ in range(int(constants[s + WEIGHTS])):
            b = 12 * int(constants[k])
            position = sum_of(triple(world, b + 9), rotated(world, b, triple(constants, k + 2)))
            energies[n] += constants[k + 1] * dot(triple(constants, 1), position)
            k += WEIGHT

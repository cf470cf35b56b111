"""The discrete Lagrangian of a step, and the exact one between the same two points.

A step solves the boundary value problem between its ends: its curve is stationary among those from
q0 to q1, so that L_d(q0, q1) = h sum_j b_j L(q(c_j h), q'(c_j h)) (H 2.2.1). The exact Lagrangian
is the action of the motion from q0 to q1 in the time h (H 2.1.1), in closed form.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from scipy.integrate import romb

from benchmarks.claims.kit import Array, Problem, Trajectory
from benchmarks.measures import independent_invariants
from galvi import CentralForce, LinearSpring, RigidBody, action
from references import Contender
from references.closed_forms.kepler_action import kepler_action
from references.closed_forms.oscillator import oscillator_action

ACTION, STEPPED = "error of L_d", "error of one step"
IN_N = "n-refinement"

SAMPLES = 1024  # intervals of a step for Romberg's integral, a power of 2


def discrete_lagrangian(run: Trajectory) -> float:
    """L_d of a run's first step, as a function of the two configurations that it joins."""
    return float(action(run)[1])


def exact_lagrangian(problem: Problem, q0: Array, q1: Array, h: float) -> float:
    """The action of the motion from q0 to q1, (d,) each, in the time h, for a single point of mass
    m in a central force or on a spring. Raises TypeError for another problem."""
    system: Any = problem.system
    mass, potential = float(system.mass), system.potential
    if isinstance(potential, CentralForce):
        return mass * kepler_action(potential.mu / mass, q0.tolist(), q1.tolist(), h)
    if isinstance(potential, LinearSpring):
        return math.fsum(
            oscillator_action(mass, float(potential.stiffness), float(a), float(b), h)
            for a, b in zip(q0, q1, strict=True)
        )
    raise TypeError(f"there is no action in closed form here for {system!r}.")


def action_along(problem: Problem, h: float, truth: Contender) -> tuple[float, Array]:
    """Romberg's integral of L along the problem's motion over the time h, and q at its end."""
    motion = truth.run(problem, h, {"samples": SAMPLES})
    along = lagrangian(problem, motion.q, problem.system.velocity(motion.p))
    return float(romb(along, dx=h / SAMPLES)), motion.q[-1]


def lagrangian(problem: Problem, q: Array, v: Array) -> Array:
    """The Lagrangian T - V = 2 T - (T + V), (k,).

    q and v are (k, d); for a rigid body they are R, (k, 3, 3), and body velocities, (k, 3).
    """
    system: Any = problem.system
    turning = isinstance(system, RigidBody)
    p = v @ system.inertia if turning else float(system.mass) * v
    return np.sum(v * p, axis=-1) - independent_invariants.energy(problem, q, v)

"""Explicit Nystrom methods, from their tableaus."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from typing import Any, ClassVar

import numpy as np
from numba import types

from galvi import Canonical, NBody, Problem, Trajectory
from references.as_trajectory import as_trajectory, non_finite
from references.compiled import njit
from references.contender import steps_of_run
from references.forces.force import FUNCTION, OPTIONS, VECTOR
from references.newton import inverse_mass, is_forced, total_force
from references.setting import described

# The compiled loop of an explicit Nystrom method; its arguments are tuples.
#
# tableau   A (s, s), c (s,): stages and nodes; bq, bv (s,): weights of the accelerations in the
#           position and the velocity; reuses_last
# force, numbers   force(q, v, t, numbers, out), see `references.forces.force`
# inverse_mass     (d, 1) diagonal or (d, d)
# state     q, v (d,), advanced in place
# scratch   F (s, d): accelerations at the stages, of which the last is kept when `reuses_last`;
#           Q, f (d,): the configuration at a stage and the force there
# steps     first, last, total, save_every: numbers of steps before and after this call, of the run,
#           and between saved states
# saved     q, v (n, d): the saved states, with the last
#
# The force gets the velocity of the step's start, so only one-stage methods may depend on it.

MATRIX, WHOLE, REAL = types.float64[:, ::1], types.int64, types.float64
SIGNATURE = types.UniTuple(WHOLE, 2)(
    types.Tuple((MATRIX, VECTOR, VECTOR, VECTOR, types.boolean)),
    FUNCTION,
    VECTOR,
    MATRIX,
    types.UniTuple(VECTOR, 2),
    types.Tuple((MATRIX, VECTOR, VECTOR)),
    REAL,
    REAL,
    types.UniTuple(WHOLE, 4),
    types.UniTuple(MATRIX, 2),
)


@njit(_nrt=False, **OPTIONS)
def accelerate(inverse_mass, force, out):  # type: ignore[no-untyped-def]
    """out (d,) <- the inverse mass times the force (d,)."""
    for i in range(out.size):
        if inverse_mass.shape[1] == 1:
            out[i] = inverse_mass[i, 0] * force[i]
        else:
            out[i] = 0.0
            for j in range(force.size):
                out[i] += inverse_mass[i, j] * force[j]


def advance(tableau, force, numbers, inverse_mass, state, scratch, t0, h, steps, saved):  # type: ignore[no-untyped-def]
    """Take the steps first + 1 .. last; returns the number of the step that failed (0: none) and
    the number of evaluations."""
    A, c, bq, bv, reuses_last = tableau
    q, v = state
    F, Q, f = scratch
    first, last, total, save_every = steps
    d, stages = q.size, c.size
    evaluations = 0
    for k in range(first, last):
        for s in range(stages):
            if s == 0 and reuses_last and k > 0:
                for i in range(d):
                    F[0, i] = F[stages - 1, i]
                continue
            starts = s == 0 and c[0] == 0.0  # the stage is the start of the step
            for i in range(0 if starts else d):
                change = 0.0
                for j in range(s):
                    change += A[s, j] * F[j, i]
                Q[i] = q[i] + h * (c[s] * v[i] + h * change)
            f[:] = 0.0
            force(q if starts else Q, v, t0 + (k + c[s]) * h, numbers, f)
            evaluations += 1
            accelerate(inverse_mass, f, F[s])
        residue = 0.0
        for i in range(d):
            position_change = bq[0] * F[0, i]
            velocity_change = bv[0] * F[0, i]
            for s in range(1, stages):
                position_change += bq[s] * F[s, i]
                velocity_change += bv[s] * F[s, i]
            q[i] += h * (v[i] + h * position_change)
            v[i] += h * velocity_change
            residue += (q[i] - q[i]) + (v[i] - v[i])
        if residue != 0.0:  # only a NaN or an infinity leaves one
            return k + 1, evaluations
        if (k + 1) % save_every == 0 or k + 1 == total:
            row = (k + save_every) // save_every
            for i in range(d):
                saved[0][row, i], saved[1][row, i] = q[i], v[i]
    return 0, evaluations


@cache
def compiled() -> Callable[..., Any]:
    """`advance`, compiled once for all forces and cached on disk."""
    return njit(SIGNATURE, _nrt=False, **OPTIONS)(advance)


# Explicit methods of fixed step for q'' = a(q, t), as tableaus that one compiled loop runs.
#
# Q_i = q + c_i h v + h^2 sum_{j<i} A_ij a(Q_j, t + c_i h)
# q'  = q + h v + h^2 sum_j position_j a(Q_j)
# v'  = v + h sum_j velocity_j a(Q_j)          (Hairer, Norsett and Wanner, Solving ODEs I, II.14)
#
# A method whose only stage is the start of the step evaluates a(q, v, t) and takes external forces.

CHUNK = 100_000  # number of steps between two checks for Ctrl-C
FAILURE_REASON = "bodies met or the step is too large"


@dataclass(frozen=True, eq=False)
class Nystrom:
    """An explicit Nystrom method with constant steps; setting: step, save_every.

    Attributes
    ----------
    name
        for titles and tables
    order
        order of convergence
    stages
        A, (s, s), strictly lower triangular
    nodes
        c, (s,)
    position
        weights of the accelerations in q', (s,)
    velocity
        weights in v', (s,); ValueError unless they sum to 1

    Notes
    -----
    When the last stage is the new configuration, its acceleration starts the next step.
    """

    fixed_step: ClassVar[bool] = True

    name: str
    order: int
    stages: tuple[tuple[float, ...], ...]
    nodes: tuple[float, ...]
    position: tuple[float, ...]
    velocity: tuple[float, ...]
    exact: bool = False
    missing: str = ""

    def __post_init__(self) -> None:
        if abs(sum(self.velocity) - 1.0) > 1e-15 or np.any(np.triu(self.stages)):
            raise ValueError(
                f"{self.name} must have velocity weights that sum to 1 and stages below the "
                f"diagonal; received {self.velocity} and {self.stages}."
            )

    @cached_property
    def reuses_last(self) -> bool:
        """Whether the last stage of a step is the first of the next."""
        return (
            len(self.nodes) > 1
            and self.nodes[0] == 0.0
            and self.nodes[-1] == 1.0
            and self.stages[-1] == self.position
        )

    @property
    def takes_forces(self) -> bool:
        """Whether forces may depend on the velocity: the only stage is the start of the step."""
        return self.nodes == (0.0,)

    def supports(self, problem: Problem) -> bool:
        """Any system with L = v.M v / 2 - V; an external force where `takes_forces`."""
        separable = isinstance(problem.system, (Canonical, NBody))
        return separable and (self.takes_forces or not is_forced(problem))

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; compiled when the forces are, else interpreted. See `Contender`."""
        steps = steps_of_run(self, problem, duration, setting)
        times = steps.times(problem.t0)
        arrays = map(np.array, (self.stages, self.nodes, self.position, self.velocity))
        tableau = (*arrays, self.reuses_last)
        force, inverse = total_force(problem), inverse_mass(problem)
        take_steps = compiled() if force.compiled else advance
        force_arguments = (
            force.function,
            force.numbers,
            inverse if inverse.ndim == 2 else inverse[:, None],
        )
        q, v = state = problem.q0.flatten(), problem.v0.flatten()
        saved = np.full((2, len(times), q.size), np.nan)
        saved[:, 0] = q, v
        scratch = np.zeros((len(self.nodes), q.size)), np.zeros(q.size), np.zeros(q.size)
        save_every = int(steps.saved[1])
        failed = evaluations = steps_done = 0
        while steps_done < steps.count and not failed:
            last = min(steps_done + CHUNK, steps.count)
            with np.errstate(all="ignore"):  # the loop looks for non-finite states itself
                failed, new_evaluations = take_steps(
                    tableau,
                    *force_arguments,
                    state,
                    scratch,
                    problem.t0,
                    steps.step,
                    (steps_done, last, steps.count, save_every),
                    tuple(saved),
                )
            evaluations += new_evaluations
            steps_done = failed - 1 if failed else last
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            *saved,
            counts={"steps": steps_done, "force_evaluations": evaluations},
            step=steps.step,
            failure=non_finite(failed, steps.saved, times, FAILURE_REASON) if failed else None,
        )


def splitting(name: str, order: int, nodes: Sequence[float], kicks: Sequence[float]) -> Nystrom:
    """Kicks of the velocity by the force, and drifts to their times between them: symplectic.

    Parameters
    ----------
    nodes
        times of the kicks, (s,), in units of the step
    kicks
        their lengths, (s,), in units of the step
    """
    times = range(len(nodes))
    return Nystrom(
        name,
        order,
        stages=tuple(
            tuple(kicks[j] * (nodes[i] - nodes[j]) if j < i else 0.0 for j in times) for i in times
        ),
        nodes=tuple(nodes),
        position=tuple(kicks[j] * (1.0 - nodes[j]) for j in times),
        velocity=tuple(kicks),
    )

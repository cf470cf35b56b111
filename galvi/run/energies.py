"""Kinetic and potential energies of a run's states, for galvi.run.energy_assessment."""

from __future__ import annotations

import math
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from functools import lru_cache
from typing import Any, NamedTuple, cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.problem import Problem, WithFunctions
from galvi.systems.forces.external_force import BuiltinForce
from galvi.systems.free_body import FreeBody
from galvi.systems.lagrangian import Lagrangian
from galvi.systems.multibody import Multibody
from galvi.systems.nbody import NBody
from galvi.systems.potentials.potentials import UniformGravity
from galvi.systems.rigid_body import RigidBody
from galvi.systems.system import BuiltinLagrangian, VectorSystem
from galvi.systems.traces import Traces, traces
from galvi.tableau import Tableau

# Relative error of a momentum; that of the energy is of the order of its square.
MOMENTUM_TOLERANCE = 0.03
COMPARED_STATES = (
    4  # states of a run, besides the last, at which a traced function is called itself
)
# Relative changes of a position whose effect on the energy is not an error: the larger one at rest,
# where V may be 0 and a motion grows from round-off.
POSITION_CHANGE, POSITION_CHANGE_AT_REST = 2.0**-46, 2.0**-26
PATH_POINTS = 128  # points of a straight path, each half as far as the one before
Raised = dict[int, Exception]  # by row of the states


class States(NamedTuple):
    """n states of one run of a system without explicit time.

    Attributes
    ----------
    q, p : array, shape (n, ...)
        configurations and momenta
    v : array, shape (n, d)
        velocities; for a Lagrangian they nearly belong to p
    t : array, shape (n,)
        a time of the run
    """

    q: Array
    p: Array
    v: Array
    t: Array


def has_no_force(system: Any) -> bool:
    """Whether a system has no external force and no explicit time; for point masses, whether all
    their forces conserve the energy."""
    if isinstance(system, NBody):
        return system.acting.conserve
    if not isinstance(system, WithFunctions):
        return False
    return system.force is None and not system.explicit_time


def working_force(system: Any) -> Any:
    """The part of a system's external force that has no potential; None where there is none."""
    return getattr(system, "working_force", getattr(system, "force", None))


def conserves_energy(system: Any) -> bool:
    """Whether a system conserves its energy: all its forces have a potential, and it has no
    explicit time."""
    if isinstance(system, NBody) or not isinstance(system, WithFunctions):
        return has_no_force(system)
    return working_force(system) is None and not system.explicit_time


def velocities_at_the_end(table: Tableau, stages: Array) -> Array:
    """Velocities (..., d) at the end of steps from those at their stages (..., d, s)."""
    return stages @ _stage_to_end_weights(table)


@lru_cache(maxsize=32)
def _stage_to_end_weights(table: Tableau) -> Array:
    return read_only(table.analysis.sum(axis=0))  # Legendre polynomials are 1 at 1


def energies(
    problem: Problem,
    states: States,
    solve_velocities: bool = False,
    raised: Raised | None = None,
    include_forces: bool = False,
) -> tuple[Array, Array]:
    """T and V, (n,) each; NaN where they are not defined.

    Parameters
    ----------
    solve_velocities
        whether to solve for a Lagrangian's velocities at each state, and not only where the given
        ones do not nearly have the momentum: the energy p . v - L(q, v) is stationary in v where
        dL/dv = p
    raised
        receives the exceptions of user functions by row, where energies are NaN; None: they pass
        through. An ArithmeticError or ValueError means that the energy is not defined
    include_forces
        whether V includes the energy of a `Multibody`'s forces with a potential

    Notes
    -----
    A Lagrangian's V is -L(q, 0), its energy at rest; where that is not finite, T is p . v.
    """
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        if system.builtin is not None and not solve_velocities:
            kinetic, potential = _energies_of_builtin(system, system.builtin, states, raised)
        else:
            kinetic, potential = _energies_one_by_one(system, states, solve_velocities, raised)
        if include_forces and isinstance(system, Multibody):
            potential = potential + system.potential_of_forces(states.q)
        return kinetic, potential
    p = states.p.reshape(states.v.shape)
    return 0.5 * (p * states.v).sum(axis=1), potentials(system, states.q, states.t, raised)


class Start(NamedTuple):
    """The energy at the start.

    Attributes
    ----------
    total
        T + V
    kinetic
        |T|
    fresh : array, shape (4,)
        `Checkpoint.energies` before the first step
    """

    total: float
    kinetic: float
    fresh: Array


def start_energies(problem: Problem, include_forces: bool = False) -> Start:
    """The energies at the start; exceptions of user functions pass through.

    Parameters
    ----------
    forces
        as for `energies`
    """
    system_traces = traces(problem.system)
    evaluate = (
        _start_energies if _is_fixed(problem.system, system_traces) else _start_energies.__wrapped__
    )
    return evaluate(problem, include_forces, system_traces)


@lru_cache(maxsize=32)
def energy_calls_functions(system: Any) -> bool:
    """Whether the energy depends on user functions, which may change after the run; False with
    explicit time, where no energy is assessed."""
    if not isinstance(system, WithFunctions) or system.explicit_time:
        return False
    if isinstance(system, RigidBody | FreeBody):
        return not isinstance(system.potential, UniformGravity | None)
    if isinstance(system, Lagrangian):
        return not system.brings_slopes
    return getattr(system, "builtin", None) is None


def work_calls_function(system: Any) -> bool:
    """Whether the work of forces depends on a user function, which may change after the run."""
    force = working_force(system)
    return force is not None and not isinstance(force, BuiltinForce)


@lru_cache(maxsize=32)
def _is_fixed(system: Any, system_traces: Traces) -> bool:
    """Whether the energy does not depend on user functions that may change.

    Where the energy was traced, its trace was checked when the run began.
    """
    if isinstance(system, NBody):
        return True
    if isinstance(system, RigidBody | FreeBody):
        return isinstance(system.potential, UniformGravity | None)
    if isinstance(system, Lagrangian) and "L" in system_traces.traced:
        return system.slopes is None
    return not energy_calls_functions(system)


@lru_cache(maxsize=32)
def _start_energies(problem: Problem, include_forces: bool, system_traces: Traces) -> Start:
    start = _start(problem, 1.0)
    kinetic, potential = (
        float(x[0]) for x in energies(problem, start, include_forces=include_forces)
    )
    fresh = read_only(np.array([potential, potential, abs(kinetic), 0.0]))
    return Start(kinetic + potential, abs(kinetic), fresh)


def energy_of_position_error(problem: Problem) -> float:
    """The largest finite change of V when the start moves by a share of itself, POSITION_CHANGE, or
    POSITION_CHANGE_AT_REST where all velocities are 0: about the round-off of the energy."""
    relative_shift = POSITION_CHANGE if np.any(problem.v0) else POSITION_CHANGE_AT_REST
    unmoved, *moved = (
        float(energies(problem, _start(problem, scale), include_forces=True)[1][0])
        for scale in (1.0, 1.0 - relative_shift, 1.0 + relative_shift)
    )
    changes = [abs(potential - unmoved) for potential in moved]
    return max([0.0, *(change for change in changes if np.isfinite(change))])


def kick_energy(problem: Problem, step: float) -> float:
    """The kinetic energy that the forces at the start give to the system at rest in a step.

    That is h^2 F . M^-1 F / 2, or 0 where it is not finite. Where velocities have the shape of
    configurations, the part of forces with a potential is at most the fall of V on the path
    h^2 M^-1 F / 2, since such a force may reverse within a long step.
    """
    system: Any = problem.system
    q, v, t = problem.q0, problem.v0, problem.t0
    energy = np.nan
    with suppress(ArithmeticError, ValueError, np.linalg.LinAlgError):
        if isinstance(system, Lagrangian):
            force = system.force_at_rest(q, t)
            acceleration = np.linalg.solve(system.mass(q, v, t), force)
        elif isinstance(system, FreeBody):
            force = system.lagrangian.force_at_rest(q, t)
            acceleration = system.velocity(force)
        elif isinstance(system, RigidBody):
            force = system.torque(q, t)
            acceleration = system.velocity(force)
        else:
            acceleration = system.acceleration(q, t)
            force = system.momentum(acceleration)
        energy = 0.5 * step**2 * float(np.sum(force * acceleration))
        if np.isfinite(energy) and problem.q0.shape == problem.v0.shape:
            energy = min(energy, _fall(problem, 0.5 * step**2 * acceleration))
    energy = energy if np.isfinite(energy) else 0.0
    if working_force(system) is not None:
        push = np.ravel(force_on(system, q, 0.0 * v, t))
        energy += 0.5 * step**2 * float(push @ np.linalg.solve(mass_matrix(problem, q, v, t), push))
    return energy if np.isfinite(energy) else 0.0


def force_on(system: Any, q: Array, v: Array, t: float) -> Array:
    """The force without potential at one state, of the shape of v."""
    force = working_force(system)
    force_values = force(q, v, float(t)) if system.timed_force else force(q, v)
    return np.asarray(force_values, dtype=np.float64).reshape(v.shape)


def mass_matrix(problem: Problem, q: Array, v: Array, t: float) -> Array:
    """The mass matrix (d, d) at a state."""
    system: Any = problem.system
    if isinstance(system, Lagrangian):
        return system.mass(q, v, t)
    return system.momentum(np.eye(v.size).reshape(-1, *v.shape)).reshape(v.size, v.size).T


def _fall(problem: Problem, displacement: Any) -> float:
    """The largest fall of V on a straight path from the start; infinite where V is not finite.

    V is evaluated at the end of the path, at half of it, at a quarter, ..., at PATH_POINTS points.
    """
    fractions = np.append(0.0, 0.5 ** np.arange(PATH_POINTS)).reshape(-1, *(1,) * displacement.ndim)
    states = States(
        problem.q0 + fractions * displacement,
        *(
            np.repeat(array[None], len(fractions), axis=0)
            for array in (problem.p0, problem.v0.reshape(-1), np.array(problem.t0))
        ),
    )
    _, potential = energies(problem, states, raised={})
    is_finite = np.isfinite(potential).all()
    return float(np.max(potential[0] - potential)) if is_finite else math.inf


def _start(problem: Problem, scale: float) -> States:
    return States(
        scale * problem.q0[None],
        problem.p0[None],
        problem.v0.reshape(1, -1),
        np.array([problem.t0]),
    )


def _energies_of_builtin(
    system: Lagrangian, function: BuiltinLagrangian, states: States, raised: Raised | None
) -> tuple[Array, Array]:
    """T and V of a built-in or traced Lagrangian; state by state unless all velocities nearly have
    the momenta and every V is finite."""
    lagrangian_values, rest_values, momenta = function.at_states(states.q, states.v, states.t)
    potential = -rest_values
    if function is not system.function:  # traced
        for k in _compared_rows(len(states.t)):
            with _recording_exceptions(raised, k), suppress(ArithmeticError, ValueError):
                q, t = states.q[k], float(states.t[k])
                lagrangian_values[k] = system.value(q, states.v[k], t)
                potential[k] = -system.value(q, np.zeros_like(states.v[k]), t)
    agrees = np.abs(momenta - states.p) <= MOMENTUM_TOLERANCE * np.abs(states.p).max(
        axis=1, keepdims=True
    )
    if not (agrees.all() and np.isfinite(potential).all()):
        return _energies_one_by_one(system, states, False, raised)
    return (states.p * states.v).sum(axis=1) - lagrangian_values - potential, potential


def _builtin_potential(system: Lagrangian, q: Array, t: Array, raised: Raised | None) -> Array:
    """V (n,) of a traced body: its energy at rest."""
    function, n = system.builtin, len(t)
    assert function is not None
    zero_velocities = np.zeros((n, system.group.dimension))
    potential: Array = -function.at_states(q, zero_velocities, t)[1]
    for k in _compared_rows(n):
        with _recording_exceptions(raised, k), suppress(ArithmeticError, ValueError):
            potential[k] = -system.value(q[k], zero_velocities[k], float(t[k]))
    return potential


def _compared_rows(n: int) -> list[int]:
    """The rows of n states at which a traced function of a user is called itself."""
    return sorted({n - 1, *range(0, n, -(-n // COMPARED_STATES))})


def _energies_one_by_one(
    system: Lagrangian, states: States, solve_velocities: bool, raised: Raised | None
) -> tuple[Array, Array]:
    kinetic_and_potential = np.full((2, len(states.t)), np.nan)
    rows = zip(states.q, states.p, states.v, states.t, strict=True)
    for k, (q, p, v, t) in enumerate(rows):
        with _recording_exceptions(raised, k):
            kinetic_and_potential[:, k] = _energies_of_lagrangian(
                system, q, p, v, float(t), solve_velocities
            )
    return kinetic_and_potential[0], kinetic_and_potential[1]


def _energies_of_lagrangian(
    system: Lagrangian, q: Array, p: Array, v: Array, t: float, solve_velocities: bool
) -> tuple[float, float]:
    energy, potential = np.nan, np.nan
    with suppress(ArithmeticError, ValueError):
        if solve_velocities or not _has_momentum(system, q, p, v, t):
            v = system.velocity(p, q, t, v)
        energy = float(p @ v) - system.value(q, v, t)
    with suppress(ArithmeticError, ValueError):
        potential = -system.value(q, np.zeros(v.size), t)
    if not np.isfinite(potential):
        potential = energy - float(p @ v)
    return energy - potential, potential


def _has_momentum(system: Lagrangian, q: Array, p: Array, v: Array, t: float) -> bool:
    """Whether dL/dv is p up to ``MOMENTUM_TOLERANCE``."""
    with suppress(ArithmeticError, ValueError):
        return bool(
            np.max(np.abs(system.momentum(v, q, t) - p)) <= MOMENTUM_TOLERANCE * np.max(np.abs(p))
        )
    return False


def potentials(system: Any, q: Array, t: Array, raised: Raised | None) -> Array:
    """V (n,) of a system other than a Lagrangian; ``raised`` as for ``energies``."""
    is_traced_body = isinstance(system, RigidBody | FreeBody) and bool(traces(system).traced)
    if is_traced_body and system.lagrangian.builtin is not None:
        return _builtin_potential(system.lagrangian, q, t, raised)
    system = cast(VectorSystem, system)
    with suppress(Exception):  # repeated below, state by state
        return np.asarray(system.potential_energy(q, t), dtype=np.float64)
    potential = np.full(len(t), np.nan)
    for k in range(len(t)):
        with _recording_exceptions(raised, k), suppress(ArithmeticError, ValueError):
            potential[k] = system.potential_energy(q[k], t[k])
    return potential


@contextmanager
def _recording_exceptions(raised: Raised | None, row: int) -> Iterator[None]:
    """Store an exception of the block as ``raised[row]``; it passes where ``raised`` is None."""
    try:
        yield
    except Exception as error:
        if raised is None:
            raise
        raised[row] = error

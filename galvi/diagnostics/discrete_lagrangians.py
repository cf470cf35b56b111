"""Discrete Lagrangians, their Legendre transforms, and the action of a run.

L_d(q0, q1; h) is the action h sum_j b_j L(q(c_j h), q'(c_j h)) of the curve from q0 to q1, among
those of a method, for which it is stationary (H 2.2.1, on groups H 3.2.2). The curve of a step is
the stationary one between its ends, so that this boundary-value problem is solved by shooting: for
the velocity at q0 from which a step of the method ends at q1.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any, NamedTuple, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array, read_only
from galvi.charts.chart import coordinates
from galvi.curves.curves import Curves
from galvi.curves.redone_curves import RedoneCurves
from galvi.diagnostics.symplecticity import stages_along
from galvi.groups.group import Group, Rn
from galvi.input_checks import shown
from galvi.kernels.constants import EPSILON
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.energies import potentials
from galvi.run.loop import curves_of_steps, unwatched
from galvi.run.request import RunRequest, check_types, from_start
from galvi.systems.finite_differences import difference_scales
from galvi.systems.lagrangian import CHART, Lagrangian
from galvi.systems.legendre_transform import values_and_momenta
from galvi.systems.multibody import Multibody
from galvi.trajectory import Trajectory

MAX_SUBDIVISIONS = 24  # largest number of times in the continuation to h
# Largest residual of q1 over the lengths of coordinates; residuals are round-off unless a momentum
# is differenced.
END_TOLERANCE = 2.0**-36
INCREMENT = 2.0**-17  # of central differences by the velocity, in its units and relative to it
# Singular value of the derivative of the end by the velocity, up to which the ends are conjugate.
LEAST_SINGULAR_VALUE = 2.0**-28
CHUNK = 4096  # steps whose stages are in memory at once


def discrete_lagrangian(problem: Problem, method: Galerkin, q0: Any, q1: Any, h: float) -> float:
    """L_d(q0, q1; h): the stationary action of a method's curves from q0 to q1 in the time h.

    Parameters
    ----------
    problem
        its system and its t0, at which the curves begin, are used, but not its initial state
    method
        a method without a clock or a moving frame
    q0, q1
        configurations of the shape of problem.q0
    h
        the time from q0 to q1, negative for curves backwards in time

    Returns
    -------
    float
        h sum_j b_j L at the nodes of the rule, in units of action, energy times time, to round-off.
        L has no external forces, except those of a `galvi.Multibody` with a potential, as in
        `galvi.energy`; the curve is that of a step with all of them. Where several curves are
        stationary, it is the one to which Newton's method converges from uniform motion: along the
        straight line, and by a rotation of at most half a turn. Where it does not converge, a
        shorter time is solved first and then continued to h.

    Raises
    ------
    ValueError, TypeError
        For bad input; exceptions of user functions pass through.
    RuntimeError
        Where no curve is found, as the step is too long, or where q1 is conjugate to q0, so that
        the curve is not unique or does not exist; and where L is not finite along it.

    Notes
    -----
    Hall's dissertation (2013), 2.2.1, and on groups 3.2.2; its chapters 2 and 3 are papers of Hall
    and Leok. With a symmetric method on a vector space L_d(q0, q1; h) = -L_d(q1, q0; -h) if L does
    not depend on time.

    Examples
    --------
    >>> problem = galvi.problems.harmonic_oscillator()
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> action = galvi.discrete_lagrangian(problem, method, [1.0], [0.5], h=1.0)
    >>> exact = (1.25 * np.cos(1.0) - 1.0) / (2.0 * np.sin(1.0))
    >>> bool(abs(action - exact) < 1e-14)
    True
    """
    step = _step_between(problem, method, q0, q1, h, "discrete_lagrangian")
    value = float(_actions(problem, method, cast(Curves, step.curves))[0])
    if not math.isfinite(value):
        raise RuntimeError(
            f"the action of the curve from q0 to q1 is {value}: the Lagrangian is not finite along "
            f"it. Use units in which numbers are smaller, or other ends."
        )
    return value


def discrete_legendre_transforms(
    problem: Problem, method: Galerkin, q0: Any, q1: Any, h: float
) -> tuple[Array, Array]:
    """p0 = -D1 L_d(q0, q1; h) and p1 = D2 L_d(q0, q1; h), each of the shape of run.p.

    On a Lie group derivatives are left-trivialised, along q exp(hat(eta)): body momenta, as in
    run.p. With external forces these are the forced transforms, p0 = -D1 L_d - f^- and
    p1 = D2 L_d + f^+: the momenta between which a step goes from q0 to q1.

    Parameters and exceptions are those of `galvi.discrete_lagrangian`. The errors are those of the
    round-off of q1 - q0, over h and times the mass; they grow near conjugate points. Bodies without
    mass have no momentum.

    Notes
    -----
    Marsden and West, Acta Numerica 10 (2001), 1.5; with forces 3.2.2.

    Examples
    --------
    >>> problem = galvi.problems.kepler(0.3)
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> run = galvi.integrate(problem, method, step=0.2, steps=1)
    >>> p0, p1 = galvi.discrete_legendre_transforms(problem, method, run.q[0], run.q[1], 0.2)
    >>> np.allclose(p0, run.p[0], rtol=1e-13), np.allclose(p1, run.p[1], rtol=1e-13)
    (True, True)
    """
    step = _step_between(problem, method, q0, q1, h, "discrete_legendre_transforms")
    return step.p[0], step.p[-1]


def action(run: Trajectory) -> Array:
    """The discrete action from the start of a run to each saved time, in energy times time.

    Each step adds h sum_j b_j L along its curve, with L as in `galvi.discrete_lagrangian`. This is
    L_d between the ends of the step unless several curves join them: for a step that rotates a body
    by more than half a turn, `galvi.discrete_lagrangian` uses another curve. Where curves were not
    kept, all steps are repeated.

    Parameters
    ----------
    run : galvi.Trajectory
        a run of `galvi.integrate` without a clock, a moving frame or actions of events

    Returns
    -------
    array, shape (saved,)
        action[0] is 0, action[-1] the action of the whole run; NaN past a failed step

    Raises
    ------
    ValueError
        For a run of a reference, in a clock or a moving frame, with actions of events, and one that
        an event ended within a step; and where functions of the system have changed since the run.
    TypeError
        When run is not a Trajectory.

    Notes
    -----
    The sum over k of L_d(q_k, q_k+1) is stationary under variations of the q between its ends
    (H 2.1.1).

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(8), galvi.gauss(8))
    >>> run = galvi.integrate(galvi.problems.harmonic_oscillator(), method, step=0.5, steps=4)
    >>> exact = -0.25 * np.sin(2.0 * run.t)  # from rest at q = 1
    >>> bool(np.max(np.abs(galvi.action(run) - exact)) < 1e-13)
    True
    """
    if not isinstance(run, Trajectory):
        raise TypeError(f"run must be a galvi.Trajectory; received {shown(run)}.")
    curves = run.again if run.curves is None else run.curves
    if curves is None:
        raise ValueError(
            "the action of a run is that of its Galerkin curves, which one of a reference, or with "
            "actions of events, may not have. Give one of galvi.integrate without actions."
        )
    _refuse_other_coordinates(run.method, "the action of a run")
    if run.restarts is not None:
        raise ValueError(
            "the action of a run is that of one motion; received a run that actions of events "
            "changed. Take the runs between them."
        )
    elapsed = (run.t - run.t[0]) / curves.step
    saved = np.rint(elapsed).astype(np.int64)
    round_off = 4.0 * EPSILON * (1.0 + float(np.max(np.abs(run.t / curves.step))))
    if np.max(np.abs(elapsed - saved)) > round_off:
        raise ValueError(
            f"the action of a run is that of whole steps; received one that an event ended at "
            f"t = {float(run.t[-1])!r}, within a step. Integrate without the event up to the step "
            f"before."
        )
    step_actions = [_actions(run.problem, run.method, chunk) for chunk in _chunks(curves)]
    sums = np.cumsum(np.concatenate([np.zeros(1), *step_actions]))
    nan_actions = np.full(max(saved[-1] + 1 - len(sums), 0), np.nan)
    return read_only(np.concatenate([sums, nan_actions])[saved])


def _refuse_other_coordinates(method: Galerkin, subject: str) -> None:
    """ValueError for a method in a clock or in a moving frame."""
    received = (
        "a clock" if method.clock is not None else "a moving frame" if method.in_frame else ""
    )
    if received:
        raise ValueError(
            f"{subject} needs steps of equal length in the inertial frame; received a method in "
            f"{received}. Leave it out."
        )


def _chunks(curves: Any) -> Iterator[Curves]:
    """The curves of a run's steps, at most CHUNK at once unless they are computed again; those of
    failed steps may be absent."""
    if isinstance(curves, RedoneCurves):
        curves.check()
        ends = [
            *(state.first for state in curves.checkpoints[1:]),
            curves.checkpoints[0].first + curves.steps_done,
        ]
        for start, end in zip(curves.checkpoints, ends, strict=True):
            if end > start.first:
                steps = curves.problem, curves.method, curves.step, start, 0, end - start.first
                yield from _chunks(curves_of_steps(*steps))
        return
    for first in range(0, len(curves.bases), CHUNK):
        rows = slice(first, first + CHUNK)
        yield replace(
            curves,
            t0=curves.t0 + first * curves.step,
            bases=curves.bases[rows],
            coefficients=curves.coefficients[rows],
        )


@np.errstate(over="ignore", invalid="ignore")
def _actions(problem: Problem, method: Galerkin, curves: Curves) -> Array:
    """h sum_j b_j L (steps,) of each step; NaN for a step that failed."""
    t, q, v, weights = stages_along(curves, method.table)
    solved = np.isfinite(curves.coefficients).all(axis=(1, 2))
    values = np.full(t.shape, np.nan)
    shape, count = t[solved].shape, t[solved].size
    flat = (x[solved].reshape(count, *x.shape[2:]) for x in (q, v, t))
    values[solved] = lagrangian_values(problem, *flat).reshape(shape)
    return np.sum(values * weights, axis=1)


def lagrangian_values(problem: Problem, q: Array, v: Array, t: Array) -> Array:
    """L (n,) at n states; of external forces only those of a Multibody with a potential count."""
    system: Any = problem.system
    if not isinstance(system, Lagrangian):
        p = system.momentum(v)
        kinetic: Array = 0.5 * np.sum(p * v, axis=tuple(range(1, p.ndim)))
        return kinetic - potentials(system, q, t, None)
    values_with_momenta = values_and_momenta(system, q, v, t)
    if values_with_momenta is None:
        rows = zip(q, v, t.tolist(), strict=True)
        values = np.array([system.value(x, w, s) for x, w, s in rows])
    else:
        values = values_with_momenta[0]
    return values - system.potential_of_forces(q) if isinstance(system, Multibody) else values


class Trial(NamedTuple):
    """A step from q0 with a trial velocity.

    Attributes
    ----------
    v : array, shape (d,)
        the trial velocity
    run
        the run of one step
    residual : array, shape (d,)
        the end of the step in exponential coordinates about q1, over their lengths
    size
        the largest entry of the residual; infinite for a step that failed
    """

    v: Array
    run: Trajectory
    residual: Array
    size: float


@np.errstate(over="ignore", invalid="ignore", divide="ignore")
def _step_between(
    problem: Problem, method: Galerkin, q0: Any, q1: Any, h: float, name: str
) -> Trajectory:
    """The run of one step from q0 to q1 in the time h; raises as `discrete_lagrangian`."""
    check_types(problem, method, f"{name}(problem, method, q0, q1, h)")
    _refuse_other_coordinates(method, "the discrete Lagrangian")
    system: Any = problem.system
    group: Group = getattr(system, "group", Rn(problem.q0.size))
    h = input_checks.real("h", h)
    if h == 0.0:
        raise ValueError("h must not be zero; received 0. Give the time from q0 to q1.")
    q0, q1 = (
        input_checks.array(end, q, problem.q0.shape, "It has the shape of problem.q0.")
        for end, q in (("q0", q0), ("q1", q1))
    )
    start, end = (q.reshape(group.shape) for q in (q0, q1))
    group.check("q1", end)
    displacement = coordinates(CHART, group, start, end)
    uniform = (displacement / h).reshape(problem.v0.shape)
    if not np.isfinite(uniform).all():
        raise ValueError(f"(q1 - q0) / h must be finite; received h = {h!r}. Use a larger h.")
    system.check_state(q0, uniform, problem.t0)
    RunRequest.checked(problem.moved(q0, uniform, problem.t0), method, h, 1)
    lengths = difference_scales(group, start, displacement)[0]

    def trial(v: Array, time: float) -> Trial:
        moved = problem.moved(q0, v.reshape(problem.v0.shape), problem.t0)
        run = unwatched(RunRequest(moved, method, time, 1, from_start(curves=True)))
        if not (np.isfinite(run.q[-1]).all() and np.isfinite(run.p[-1]).all()):
            return Trial(v, run, np.full(v.size, np.nan), np.inf)
        residual = coordinates(CHART, group, end, run.q[-1].reshape(group.shape)) / lengths
        return Trial(v, run, residual, float(np.max(np.abs(residual))))

    solution = _continue_in_time(trial, displacement, lengths, h)
    if solution is None:
        raise RuntimeError(
            f"no curve from q0 to q1 in the time h = {h!r} was found by Newton's method from "
            f"uniform motion: they may be conjugate points, where motions from q0 meet again, or "
            f"too far apart for one step. Use a smaller h, nearer ends or a higher degree."
        )
    return solution.run


def _continue_in_time(
    trial: Callable[[Array, float], Trial], displacement: Array, lengths: Array, h: float
) -> Trial | None:
    """The step to q1 in the time h, by continuation from a fraction of h for which Newton's method
    converges from uniform motion; None where no such step is found."""
    solved_fraction, fraction = 0.0, 1.0
    for _ in range(MAX_SUBDIVISIONS):
        time = fraction * h
        nearest = _solve_for_velocity(trial, displacement / time, lengths / abs(time), time)
        if nearest is None:
            fraction = 0.5 * (solved_fraction + fraction)
        elif fraction == 1.0:
            return nearest
        else:
            solved_fraction, displacement = fraction, nearest.v * time
            fraction = min(1.0, 2.0 * fraction)
    return None


def _solve_for_velocity(
    trial: Callable[[Array, float], Trial], v: Array, unit: Array, time: float
) -> Trial | None:
    """The trial step of Powell's hybrid method, started from v, that ends nearest to q1; None where
    its residual exceeds ``END_TOLERANCE``, and where q1 is conjugate to q0.

    Parameters
    ----------
    unit : array, shape (d,)
        units of the velocities
    """
    from scipy.optimize import root  # a fifth of galvi's import

    nearest = first = trial(v, time)
    if not np.isfinite(first.size):
        return None

    def residual(x: Array) -> Array:
        nonlocal nearest
        step = trial(x * unit, time)
        if step.size < nearest.size:
            nearest = step
        failed = 2.0 * first.size  # larger than that of any step that is accepted
        return np.where(np.isfinite(step.residual), step.residual, failed)

    def derivative(x: Array) -> Array:
        increments = INCREMENT * (1.0 + np.abs(x))
        columns = [
            (trial((x + e) * unit, time).residual - trial((x - e) * unit, time).residual)
            for e in np.diag(increments)
        ]
        return np.nan_to_num(np.stack(columns, axis=1) / (2.0 * increments))

    root(residual, v / unit, jac=derivative, options={"xtol": 0.0})  # to round-off
    if nearest.size > END_TOLERANCE:
        return None
    smallest_singular_value = np.linalg.svd(derivative(nearest.v / unit), compute_uv=False)[-1]
    return nearest if smallest_singular_value > LEAST_SINGULAR_VALUE else None

"""Discrete Lagrangians, their Legendre transforms, and the action of a run.

L_d(q0, q1; h) is the action h sum_j b_j L(q(c_j h), q'(c_j h)) of a method's curve from q0 to q1
that is stationary among them (H 2.2.2, on groups H 3.4.2). A step of the method from the right
momentum is that curve, so that the velocity at its start is sought for which it ends at q1.
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

CORRECTIONS = 50  # of the velocity at the start, at most
ATTEMPTS = 24  # for shorter times
SHARES = 0.5 ** np.arange(8)  # of a correction that are tried
RENEWED = 0.1  # the derivative, where a correction leaves a larger share of the gap
# Gaps at the end, over the lengths of coordinates: that are round-off, and that may be, where a
# momentum is differenced.
SETTLED, ACCEPTED = 4.0 * EPSILON, 2.0**-36
# By which a start is moved to difference an end, in lengths of coordinates and in ways of the step.
OF_LENGTH, OF_WAY = 2.0**-22, 2.0**-17
SINGULAR = 2.0**-28  # an end that moves by less when the start's velocity moves by 1 does not
CHUNK = 4096  # steps whose stages are held at once
WHOLE = 1e-6  # of a step, by which a time may differ from the end of one


def discrete_lagrangian(problem: Problem, method: Galerkin, q0: Any, q1: Any, h: float) -> float:
    """L_d(q0, q1; h): the stationary action of a method's curves from q0 to q1 in the time h.

    Parameters
    ----------
    problem
        its system and t0, at which the curves begin, are used; not its initial state
    method
        without a clock, and in no moving frame
    q0, q1
        configurations of the shape of problem.q0
    h
        the time from q0 to q1, negative for curves backwards in time

    Returns
    -------
    float
        h sum_j b_j L at the nodes of the rule, to round-off. L has no external forces, but those of
        a `galvi.Multibody` with a potential, as in `galvi.energy`; the curve is that of a step with
        all of them. Where several curves are stationary, it is that which Newton's method finds
        from the straight line or the steady turn of less than half a turn; where it finds none, the
        one to which that leads as the time grows up to h.

    Raises
    ------
    ValueError, TypeError
        For bad input; exceptions of user functions pass through.
    RuntimeError
        Where no curve is found, since the step is too long or q1 is conjugate to q0; and where L is
        not finite along it.

    Notes
    -----
    H 2.2.2, on groups H 3.4.2, of Hall's dissertation, whose chapters are the papers of Hall and
    Leok. With a symmetric method on a vector space L_d(q0, q1; h) = -L_d(q1, q0; -h).

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

    Parameters and exceptions are those of `galvi.discrete_lagrangian`. Both are accurate to the
    round-off of q1 - q0 over h, times the mass.

    Notes
    -----
    Marsden and West, Acta Numerica 10 (2001), 1.5; with forces 3.2.2; on groups H 3.2.2.

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
    """The discrete action since the run's start at each saved time, (saved,): sums of L_d.

    action[0] is 0, action[-1] that of the whole run; NaN past a failed step. Each step adds
    h sum_j b_j L along its curve, with L as in `galvi.discrete_lagrangian`. Where curves were not
    kept, all steps are done again.

    Raises
    ------
    ValueError
        For a run of a reference, in a clock or a moving frame, with actions of events, and one that
        an event ended within a step; and where functions of the system have changed since the run.
    TypeError
        For something that is not a Trajectory.

    Notes
    -----
    The sum over k of L_d(q_k, q_k+1) is stationary when the q between its ends move (H 2.1).

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
    passed = (run.t - run.t[0]) / curves.step
    saved = np.rint(passed).astype(np.int64)
    slack = WHOLE + 4.0 * EPSILON * float(np.max(np.abs(run.t / curves.step)))
    if np.max(np.abs(passed - saved)) > slack:
        raise ValueError(
            f"the action of a run is that of whole steps; received one that an event ended at "
            f"t = {float(run.t[-1])!r}, within a step. Integrate without the event up to the step "
            f"before."
        )
    of_steps = [_actions(run.problem, run.method, part) for part in _parts(curves)]
    so_far = np.cumsum(np.concatenate([np.zeros(1), *of_steps]))
    at_steps = np.full(max(saved[-1] + 1, len(so_far)), np.nan)
    at_steps[: len(so_far)] = so_far
    return read_only(at_steps[saved])


def _refuse_other_coordinates(method: Galerkin, what: str) -> None:
    """ValueError for a method in a clock or in a moving frame."""
    kind = "a clock" if method.clock is not None else "a moving frame" if method.in_frame else ""
    if kind:
        raise ValueError(
            f"{what} needs steps of equal length in the inertial frame; received a method in "
            f"{kind}. Leave it out."
        )


def _parts(curves: Any) -> Iterator[Curves]:
    """The curves of a run's steps, up to CHUNK of them at once; those that failed may be absent."""
    if isinstance(curves, RedoneCurves):
        curves.check()
        ends = [*(state.first for state in curves.known[1:]), curves.known[0].first + curves.done]
        for start, end in zip(curves.known, ends, strict=True):
            if end > start.first:
                again = curves.problem, curves.method, curves.step, start, 0, end - start.first
                yield from _parts(curves_of_steps(*again))
        return
    for first in range(0, len(curves.bases), CHUNK):
        rows = slice(first, first + CHUNK)
        yield replace(
            curves, t0=curves.t0 + first * curves.step, bases=curves.bases[rows],
            coefficients=curves.coefficients[rows],
        )  # fmt: skip


@np.errstate(over="ignore", invalid="ignore")
def _actions(problem: Problem, method: Galerkin, curves: Curves) -> Array:
    """h sum_j b_j L of steps, (steps,); NaN for those that failed."""
    t, q, v, weights = stages_along(curves, method.table)
    solved = np.isfinite(curves.coefficients).all(axis=(1, 2))
    values = np.full(t.shape, np.nan)
    shape, count = t[solved].shape, t[solved].size
    flat = (x[solved].reshape(count, *x.shape[2:]) for x in (q, v, t))
    values[solved] = lagrangian_values(problem, *flat).reshape(shape)
    return np.sum(values * weights, axis=1)


def lagrangian_values(problem: Problem, q: Array, v: Array, t: Array) -> Array:
    """L (n,) at n states, without external forces but those of a Multibody with a potential."""
    system: Any = problem.system
    if not isinstance(system, Lagrangian):
        p = system.momentum(v)
        kinetic: Array = 0.5 * np.sum(p * v, axis=tuple(range(1, p.ndim)))
        return kinetic - potentials(system, q, t, None)
    together = values_and_momenta(system, q, v, t)
    if together is None:
        rows = zip(q, v, t.tolist(), strict=True)
        values = np.array([system.value(x, w, s) for x, w, s in rows])
    else:
        values = together[0]
    return values - system.potential_of_forces(q) if isinstance(system, Multibody) else values


class Shot(NamedTuple):
    """A step from a velocity at q0.

    Attributes
    ----------
    v : array, shape (d,)
        that velocity
    run
        the step
    gap : array, shape (d,)
        from q1 to where it ends, in coordinates about q1
    size
        the largest of these over its coordinate's length; infinite for a step that failed
    """

    v: Array
    run: Trajectory
    gap: Array
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
    ends = [
        input_checks.array(end, q, problem.q0.shape, "It has the shape of problem.q0.")
        for end, q in (("q0", q0), ("q1", q1))
    ]
    start, end = (q.reshape(group.shape) for q in ends)
    group.check("q1", end)
    way = coordinates(CHART, group, start, end)
    if not np.isfinite(way / h).all():
        raise ValueError(f"(q1 - q0) / h must be finite; received h = {h!r}. Use a larger h.")
    system.check_state(ends[0], (way / h).reshape(problem.v0.shape), problem.t0)

    def request(v: Array, time: float) -> RunRequest:
        here = problem.moved(ends[0], v.reshape(problem.v0.shape), problem.t0)
        return RunRequest(here, method, time, 1, from_start(curves=True))

    def shot(v: Array, time: float) -> Shot:
        run = unwatched(request(v, time))
        if not (np.isfinite(run.q[-1]).all() and np.isfinite(run.p[-1]).all()):
            return Shot(v, run, np.full(v.size, np.nan), np.inf)
        gap = coordinates(CHART, group, end, run.q[-1].reshape(group.shape))
        return Shot(v, run, gap, float(np.max(np.abs(gap) / lengths)))

    lengths = difference_scales(group, start, way)[0]
    RunRequest.checked(request(way / h, h).problem, method, h, 1)
    arrived = _arriving(shot, way, lengths, h)
    if arrived is None:
        raise RuntimeError(
            f"no curve from q0 to q1 in the time h = {h!r} was found by Newton's method from the "
            f"straight way: they may be conjugate points, where motions from q0 meet again, or too "
            f"far apart for one step. Use a smaller h, nearer ends or a higher degree."
        )
    return arrived.run


def _arriving(
    shot: Callable[[Array, float], Shot], way: Array, lengths: Array, h: float
) -> Shot | None:
    """The shot that ends at q1 after the time h; None where it is not found.

    Where the straight way is no good start, it is for a shorter time, which then grows.
    """
    done, share, way_at_start = 0.0, 1.0, way
    for _ in range(ATTEMPTS):
        time = share * h
        best = _nearest(shot, way_at_start / time, lengths, time)
        if best.size <= ACCEPTED:
            if share == 1.0:
                return best
            done, way_at_start = share, best.v * time
            share = min(1.0, 2.0 * share)
        else:
            share = 0.5 * (done + share)
    return None


def _nearest(shot: Callable[[Array, float], Shot], v: Array, lengths: Array, time: float) -> Shot:
    """The shot whose gap Newton's method, with a derivative that it renews, makes no smaller; of
    infinite size where ends do not follow velocities."""
    best, slope = shot(v, time), None
    if not np.isfinite(best.size):
        return best
    nudges = np.diag(OF_LENGTH * lengths / abs(time))
    for _ in range(CORRECTIONS):
        fresh = slope is None
        if slope is None:
            moves = nudges + np.diag(OF_WAY * np.abs(best.v))
            apart = [shot(best.v + x, time).gap - shot(best.v - x, time).gap for x in moves]
            slope = np.stack(apart, axis=1) / (2.0 * np.diag(moves))
            scaled = slope * lengths / lengths[:, None] / time
            if not np.isfinite(slope).all() or (
                np.linalg.svd(scaled, compute_uv=False)[-1] < SINGULAR
            ):
                return best._replace(size=np.inf)
        change = np.linalg.solve(slope, best.gap)
        for share in SHARES if fresh else SHARES[:1]:
            trial = shot(best.v - share * change, time)
            if trial.size <= (1.0 - 0.5 * share) * best.size:
                break
        else:
            if fresh or best.size <= SETTLED:
                return best
            slope = None
            continue
        if trial.size > RENEWED * best.size:
            slope = None
        best = trial
        if best.size == 0.0:
            return best
    return best

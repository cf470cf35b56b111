"""Derivatives of a step, and its defects of symplecticity and reversibility.

The derivative of a step in a clock is in the phase space of (q, t) and (p, -E).
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, cast

import numpy as np

from galvi import input_checks
from galvi.arrays import Array
from galvi.charts.chart import coordinates, place
from galvi.curves.clock_curves import ClockCurves
from galvi.curves.curves import Curves, FrameCurves
from galvi.diagnostics.frame_derivative import frame_step_derivative
from galvi.groups.group import Group
from galvi.kernels.nystrom.solve import SOLVED
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.clocked.lagrangians import lagrangian_of
from galvi.run.energies import start_energies
from galvi.run.engines import motion_in_clock
from galvi.run.group_system import group_system
from galvi.run.integrate import integrate
from galvi.run.interruption import uninterrupted
from galvi.run.request import ROUND_OFF, check_types
from galvi.systems.finite_differences import WEIGHTS
from galvi.systems.lagrangian import CHART, velocity_at
from galvi.systems.nbody import NBody
from galvi.systems.system import GroupSystem, VectorSystem
from galvi.tableau import Tableau
from galvi.trajectory import Trajectory

NO_VELOCITY_FORCES = (
    "the derivative of a step is not known with forces of velocity on point masses, which are not "
    "symplectic. Leave them out."
)
NO_MASSLESS = (
    "symplecticity is a property of (q, p), and the p of massless bodies is always 0; received "
    "some. Give them a small mass."
)


def stage_states(run: Trajectory) -> tuple[Array, Array, Array, Array]:
    """The stages of a run's steps: times (steps, s), q and velocities (steps, s, ...), and h times
    the weights (s,).

    Raises
    ------
    ValueError
        For a run without curves, such as one by a reference, or in a moving frame.
    """
    curves = run.curves
    if isinstance(curves, FrameCurves | ClockCurves):
        raise ValueError(
            "this needs curves between stages of one rule in time; a run in a moving frame or in a "
            "clock has others. Integrate with another chart, and without a clock."
        )
    if curves is None:
        raise ValueError(
            "this needs the Galerkin curves of a run; integrate with curves=True or save_every=1 "
            "(references keep none)."
        )
    return stages_along(curves, run.method.table)


def stages_along(curves: Curves, table: Tableau) -> tuple[Array, Array, Array, Array]:
    """The arrays of `stage_states` for given curves."""
    coefficients, step = curves.coefficients, curves.step
    xi = np.einsum("kdi,si->ksd", coefficients, table.psi)
    rate = np.einsum("kdi,si->ksd", coefficients, table.slope) / step
    t = curves.t0 + (np.arange(len(xi))[:, None] + table.c) * step
    bases = np.repeat(curves.bases[:, None], table.c.size, axis=1)
    return (
        t,
        curves.chart.configurations(bases, xi),
        curves.chart.velocity(lambda: xi, rate),
        step * table.b,
    )


def step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """The derivative of one step with respect to the initial state.

    At the converged stages Q, (I - h^2 A x da/dq) dQ = dq + c h dv, and the updates are linear in
    da/dq dQ. In a moving frame see ``galvi.diagnostics.frame_derivative``.

    Parameters
    ----------
    problem : galvi.Problem
        its initial state is the start of the step
    method : galvi.Galerkin
    step : float
        step size h in the problem's unit of time

    Returns
    -------
    array, shape (2 d, 2 d)
        D(q1, v1)/D(q0, v0); on a Lie group D(eta1, mu1)/D(eta0, mu0)

    Raises
    ------
    ValueError
        When the step itself fails, or has no derivative.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> D = galvi.step_derivative(galvi.problems.kepler(0.3), method, step=0.2)
    >>> D.shape, bool(np.isclose(np.linalg.det(D), 1.0))
    ((4, 4), True)
    """
    check_types(problem, method, "step_derivative(problem, method, step)")
    if method.clock is not None:
        raise ValueError(
            "a step in a clock has its derivative in the phase space of (q, t): see "
            "galvi.symplecticity_defect, or leave the clock out."
        )
    if method.in_frame:
        return frame_step_derivative(problem, method, step)
    if group_system(problem, method) is not None:
        if isinstance(problem.system, NBody):
            raise ValueError(NO_VELOCITY_FORCES)
        return group_step_derivative(problem, method, step)
    run = uninterrupted(integrate(problem, method, step, 1))
    h, table, d = float(step), method.table, problem.q0.size
    if not run.success:
        raise ValueError(f"the step has no derivative, because it failed. {run.status}")
    times = problem.t0 + table.c * h
    stage_positions = run(times)
    system = cast(VectorSystem, problem.system)
    slopes = np.stack(
        [system.acceleration_jacobian(q, t) for q, t in zip(stage_positions, times, strict=True)]
    )
    stages, unit = len(times), np.eye(d)
    coupling = np.einsum("kj,jab->kajb", h * h * table.A, slopes).reshape(stages * d, stages * d)
    right_sides = np.concatenate(
        [np.tile(unit, (stages, 1)), np.kron(h * table.c[:, None], unit)], axis=1
    )
    try:
        dQ = np.linalg.solve(np.eye(stages * d) - coupling, right_sides).reshape(stages, d, 2 * d)
    except np.linalg.LinAlgError:
        raise ValueError(
            f"the step has no derivative, because the stage equations are singular at step {h!r}. "
            f"Use a smaller step."
        ) from None
    da = np.einsum("jab,jbc->jac", slopes, dQ)
    position = np.concatenate([unit, h * unit], axis=1) + h * h * np.tensordot(table.beta, da, 1)
    velocity = np.concatenate([0.0 * unit, unit], axis=1) + h * np.tensordot(table.b, da, 1)
    return np.concatenate([position, velocity])


def symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of ``DF^T J DF - J`` over ``|DF|^2``, for F: (q0, p0) -> (q1, p1) (H 1.2), in
    coordinates of unit mass, each in units of its largest entry at the start.

    On a Lie group the symplectic form is left-trivialised (H 3.1.1). With a clock the phase space
    is that of (q, t) and (p, -E), and the step is one in tau.

    Parameters
    ----------
    problem : galvi.Problem
        its initial state is the start of the step
    method : galvi.Galerkin
    step : float
        step size h in the problem's unit of time

    Returns
    -------
    float
        round-off for a symplectic method on a vector space, about 1e-12 on a Lie group and 1e-11
        with a clock

    Raises
    ------
    ValueError
        As `step_derivative`.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.lobatto(5))
    >>> galvi.symplecticity_defect(galvi.problems.kepler(0.3), method, step=0.2) < 1e-13
    True
    """
    check_types(problem, method, "symplecticity_defect(problem, method, step)")
    if method.clock is not None:
        if isinstance(problem.system, NBody) and problem.system.has_massless:
            raise ValueError(NO_MASSLESS)
        return clock_symplecticity_defect(problem, method, step)
    if not method.in_frame and group_system(problem, method) is not None:
        return group_symplecticity_defect(problem, method, step)
    d, shape = problem.q0.size, problem.q0.shape
    unit = np.eye(d).reshape(d, *shape)
    if not np.all(np.isfinite(problem.system.velocity(unit))):
        raise ValueError(NO_MASSLESS)
    root = np.linalg.cholesky(problem.system.momentum(unit).reshape(d, d)).T
    sizes = [float(np.max(np.abs(root @ x.ravel()))) or 1.0 for x in (problem.q0, problem.v0)]
    zero, to_unit_mass = np.zeros((d, d)), [root / size for size in sizes]
    to_weighted = np.block([[to_unit_mass[0], zero], [zero, to_unit_mass[1]]])
    DF = (
        to_weighted @ np.linalg.solve(to_weighted.T, step_derivative(problem, method, step).T).T
    )  # of (L^T q, L^T v), M = L L^T, which are conjugate
    J = np.block([[zero, np.eye(d)], [-np.eye(d), zero]])
    return _defect(DF, J, J)


def _defect(DF: Array, W0: Array, W1: Array) -> float:
    scale = max(1.0, float(np.linalg.norm(DF, 2)) ** 2)
    return float(np.max(np.abs(DF.T @ W1 @ DF - W0)) / scale)


STATE_DIFFERENCE, CLOCK_DIFFERENCE = 2.0**-6, 2.0**-7


def _central_differences(end: Callable[[Array], Array], increments: list[float]) -> Array:
    """The derivative (m, n) at 0 of a function of (n,), by central differences of order eight."""
    columns = []
    for unit, increment in zip(np.eye(len(increments)), increments, strict=True):
        column: Any = 0.0
        for k, weight in enumerate(WEIGHTS, start=1):
            end_ahead, end_behind = (end(sign * k * increment * unit) for sign in (1.0, -1.0))
            column = column + weight * (end_ahead - end_behind) / increment
        columns.append(column)
    return np.stack(columns, axis=1)


def group_step_derivative(problem: Problem, method: Galerkin, step: float) -> Array:
    """D(eta1, mu1)/D(eta0, mu0), (2 d, 2 d), for g moved to g exp(hat(eta)) at both ends.

    By central differences of order eight, accurate to about 1e-12.

    Raises
    ------
    ValueError
        When the step itself fails.
    """
    system = cast(GroupSystem, group_system(problem, method))
    group, d = system.group, system.group.dimension

    def end(eta: Array, shift: Array) -> tuple[Array, Array]:
        g = place(CHART, group, problem.q0, eta)
        v = velocity_at(system, g, problem.p0 + shift, problem.t0)
        start = Problem(problem.system, g, v, problem.t0)
        run = uninterrupted(integrate(start, method, step, 1))
        if not run.success:
            raise ValueError(f"the step has no derivative, because it failed. {run.status}")
        return run.q[-1], run.p[-1]

    g_end, _ = end(np.zeros(d), np.zeros(d))
    size = float(np.max(np.abs(problem.p0))) or 1.0

    def moved(x: Array) -> Array:
        g, mu = end(x[:d], x[d:])
        return np.concatenate([coordinates(CHART, group, g_end, g), mu])

    return _central_differences(moved, [STATE_DIFFERENCE] * d + [STATE_DIFFERENCE * size] * d)


def group_symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 (H 3.1.1, claim L16).

    W(mu) is the matrix of <d mu2, eta1> - <d mu1, eta2> + <mu, [eta1, eta2]>.
    """
    group = cast(GroupSystem, group_system(problem, method)).group
    DF = step_derivative(problem, method, step)
    end = uninterrupted(integrate(problem, method, step, 1))
    W0, W1 = (_symplectic_form(group, mu) for mu in (problem.p0, end.p[-1]))
    return _defect(DF, W0, W1)


def _symplectic_form(group: Group, mu: Array, time: int = 0) -> Array:
    """W(mu), with a time and its momentum or without."""
    d, n = group.dimension, group.dimension + time
    unit, bracket_terms = np.eye(n), np.zeros((n, n))
    bracket_terms[:d, :d] = [[mu @ group.bracket(v, w) for w in np.eye(d)] for v in np.eye(d)]
    return np.block([[bracket_terms, unit], [-unit, np.zeros((n, n))]])


def round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """The distance of a run from its start after ``steps`` steps forwards and as many backwards.

    A symmetric method returns to round-off; others, a `KeplerFrame` whose nodes an orbit places,
    and on groups all but degree 1 with the exponential chart, only to their order. With a clock
    both directions use the energy of the start.

    Parameters
    ----------
    problem : galvi.Problem
        its initial state is the start of the step
    method : galvi.Galerkin
    step : float
        step size h in the problem's unit of time; with a clock, in its unit
    steps : int
        number of steps in each direction

    Returns
    -------
    float
        the largest component of ``|q - q0|`` at the end

    Raises
    ------
    ValueError
        When a run fails, and as `galvi.integrate`.
    KeyboardInterrupt
        On Ctrl-C.

    Examples
    --------
    >>> method = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
    >>> galvi.round_trip_error(galvi.problems.kepler(0.3), method, step=0.1, steps=50) < 1e-11
    True
    """
    check_types(problem, method, "round_trip_error(problem, method, step, steps)")
    step = input_checks.real("step", step)
    if method.clock is not None:
        return clock_round_trip_error(problem, method, step, steps)
    forward = uninterrupted(integrate(problem, method, step, steps, save_every=steps))
    _check_success(forward)
    end, t = forward.q[-1], float(forward.t[-1])
    reversed_start = Problem(problem.system, end, forward.v[-1], t)
    backward = uninterrupted(integrate(reversed_start, method, -step, steps, save_every=steps))
    _check_success(backward)
    return float(np.max(np.abs(backward.q[-1] - problem.q0)))


def _check_success(run: Trajectory) -> None:
    if not run.success:
        raise ValueError(f"both ways must be completed; received a run of which: {run.status}")


def clock_step_derivative(
    problem: Problem, method: Galerkin, step: float
) -> tuple[Array, Array, Array]:
    """D(eta1, t1, mu1, e1)/D(eta0, t0, mu0, e0) of a step, (2 d + 2, 2 d + 2), and mu0, mu1 (d,).

    q moves to q exp(hat(eta)) on a group, to q + eta else; e = -E is the momentum of the time, E
    the energy of the clock. By central differences of order eight, to about 1e-11.

    Raises
    ------
    ValueError
        When the step fails.
    """
    group = lagrangian_of(problem.system, problem).group
    d, energy = group.dimension, start_energies(problem).total
    rate = method.clock.rate(problem)
    q0, p0 = problem.q0.reshape(group.shape), problem.p0.ravel()

    def end(eta: Array, shift: Array, energy_shift: float) -> tuple[Array, Array, float]:
        q = place(CHART, group, q0, eta)
        shape = problem.v0.shape
        v: Any = velocity_at(
            problem.system,
            q.reshape(problem.q0.shape),
            (p0 + shift).reshape(shape),
            problem.t0,
            problem.v0,
        )
        motion = motion_in_clock(problem, method, "auto", ROUND_OFF, energy + energy_shift)
        state = motion.at(q.reshape(problem.q0.shape), v, problem.t0)
        advanced = motion.advance(state, step, 1, None, False)
        if advanced.code != SOLVED:
            raise ValueError(f"the step has no derivative, because it failed: {advanced.reason}.")
        steps = advanced.steps
        return steps.q[0].reshape(group.shape), steps.p[0], float(steps.t[0] @ (1.0, 1.0))

    zero = np.zeros(d)
    q_end, mu1, _ = end(zero, zero, 0.0)
    size = float(np.max(np.abs(p0))) or 1.0
    size_of_q = min(
        1.0, abs(step) * float(np.max(np.abs(problem.v0))) * float(rate(problem.q0.ravel()))
    )
    scales = [size_of_q or 1.0] * d + [size] * d + [max(abs(energy), size)]

    def moved(x: Array) -> Array:
        q, mu, t = end(x[:d], x[d : 2 * d], -float(x[2 * d]))
        return np.concatenate([coordinates(CHART, group, q_end, q), [t], mu, [0.0]])

    DF = np.insert(
        _central_differences(moved, [CLOCK_DIFFERENCE * scale for scale in scales]), d, 0.0, axis=1
    )
    DF[d, d] = DF[2 * d + 1, 2 * d + 1] = (
        1.0  # t1 and e1 change as t0 and e0; nothing depends on t0
    )
    return DF, p0, mu1


def clock_symplecticity_defect(problem: Problem, method: Galerkin, step: float) -> float:
    """Largest entry of DF^T W1 DF - W0 over |DF|^2 in the extended phase space; see
    `galvi.symplecticity_defect`."""
    group = lagrangian_of(problem.system, problem).group
    DF, mu0, mu1 = clock_step_derivative(problem, method, step)
    return _defect(DF, *(_symplectic_form(group, mu, time=1) for mu in (mu0, mu1)))


def clock_round_trip_error(problem: Problem, method: Galerkin, step: float, steps: int) -> float:
    """As `galvi.round_trip_error`; both ways have the energy of the start."""
    motion = motion_in_clock(problem, method, "auto", ROUND_OFF)
    state = motion.at(problem.q0, problem.v0, problem.t0)
    for h in (step, -step):
        advanced = motion.advance(state, h, input_checks.whole("steps", steps), None, False)
        if advanced.code != SOLVED:
            raise ValueError(
                f"both ways must be completed; a step failed: {advanced.reason.rstrip('.')}."
            )
        state = advanced.after
    return float(np.max(np.abs(advanced.steps.q[-1] - problem.q0.ravel())))

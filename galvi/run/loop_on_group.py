"""A run on a Lie group: its kernel, the rescue of a step, and what is kept."""

from __future__ import annotations

from collections.abc import Callable
from typing import cast

import numpy as np

from galvi.arrays import Array, read_only
from galvi.charts.branch_tracking import unwrapped
from galvi.charts.exponential import Exponential
from galvi.charts.maps import coordinates, tangent
from galvi.checkpoint import Checkpoint
from galvi.curves.group_curves import GroupCurves
from galvi.groups.group import Group
from galvi.kernels.lie import product
from galvi.kernels.nystrom.advance import GUESS, HOLDS
from galvi.kernels.nystrom.solve import SOLVED
from galvi.kernels.on_group.advance import LEFT_CHART, RATES
from galvi.method import Galerkin
from galvi.problem import Problem
from galvi.run.batches import step_in_batches
from galvi.run.engines_on_group import fastest_on_group, general_on_group
from galvi.run.group_system import group_system
from galvi.run.run_arrays_on_group import GroupWorkspace
from galvi.run.status import ending_on_group
from galvi.systems.system import GroupSystem
from galvi.trajectory import Trajectory

SUBSTEPS = (4, 16, 64)
PATH = 33  # times at which the turn of a step is followed
COUNTED = ("iterations", "force_evaluations", "hessian_evaluations", "linear_solves")


def march_on_group(
    problem: Problem,
    method: Galerkin,
    step: float,
    steps: int,
    start: Checkpoint,
    *,
    save_every: int = 1,
    curves: bool | None = None,
    progress: bool | None = None,
    rescue: bool = True,
    interrupted: Callable[[], bool] | None = None,
) -> Trajectory:
    """Do ``steps`` steps from ``start``; arguments as for `galvi.integrate`, already checked.

    interrupted  says whether to stop; None means that Ctrl-C stops it

    A step that Newton's method cannot solve is tried once more from the path of a run with
    smaller steps (``rescue``); only then the run ends.
    """
    system = cast(GroupSystem, group_system(problem, method))
    group = system.group
    with_curves = save_every == 1 if curves is None else curves
    work = GroupWorkspace.of(group, start, method, steps, save_every, with_curves)
    call = fastest_on_group(problem, method, step, steps, save_every, start, work)

    def recover(code: int) -> int:
        if not rescue:
            return code
        if start.solver == "fixed_point":
            work.turned[0] = abs(step) * farthest_turn(group, work.stages[:, -1])
            return code
        t = problem.t0 + (start.first + work.done) * step
        velocities = work.stages.copy()
        rates = rates_of_smaller_steps(problem, method, step, t, work)
        if rates is None:
            return LEFT_CHART if work.turned[0] > method.chart.limit else code
        work.memo[HOLDS] = RATES
        work.stages[:] = rates
        code = general_on_group(problem, method, step, steps, save_every, start, work)(1)
        if code:
            work.stages[:] = velocities
        return code

    code = step_in_batches(call, recover, work, steps, progress, interrupted)
    done = work.done
    t_first = problem.t0 + start.first * step
    counts = {name: int(count) for name, count in zip(COUNTED, work.counts, strict=True)}
    differenced = getattr(system, "potential_calls_per_force", 0)
    if differenced:
        calls = counts["force_evaluations"] * differenced * group.dimension
        counts["potential_evaluations"] = calls
    return Trajectory(
        problem=problem,
        t=read_only(problem.t0 + (start.first + np.array(work.kept)) * step),
        q=read_only(work.saved_g.reshape(-1, *group.shape)),
        p=read_only(work.saved_mu),
        success=done == steps,
        interrupted=done < steps and code == SOLVED,
        status=ending_on_group(
            problem, method.chart, code, start.solver, step, done, steps, t_first + done * step,
            work.state[0, : problem.q0.size].reshape(group.shape),
            work.state[1, : group.dimension], work.stages[:, -1], float(work.turned[0]),
            not differenced,
        ),
        failed_step=None if done == steps else done + 1,
        counts={"steps": done, **counts},
        step=step,
        method=method,
        curves=GroupCurves(
            method.space, t_first, step, read_only(work.bases.reshape(-1, *group.shape)),
            read_only(work.coefficients), group, method.chart,
        )
        if with_curves
        else None,
        continuation=Checkpoint(
            start.first + done, read_only(work.state), read_only(work.stages), work.memo,
            start.solver, start.tolerance,
        ),
    )  # fmt: skip


def rates_of_smaller_steps(
    problem: Problem, method: Galerkin, step: float, t: float, work: GroupWorkspace
) -> Array | None:
    """xi' (d, s) in the chart along a run from (t, state) with 4, 16 or 64 steps in one, or None.

    None also where that run leaves the chart. Adds its cost to the counts, and leaves in
    ``work.turned`` how far its rotations turn from the start.
    """
    group, chart = cast(GroupSystem, group_system(problem, method)).group, method.chart
    r, d = int(np.prod(group.shape)), group.dimension
    q, v = work.state[0, :r].reshape(group.shape), work.stages[:, -1].reshape(d)
    for parts in SUBSTEPS:
        start = Checkpoint(
            0, work.state, np.repeat(v[:, None], work.stages.shape[1], axis=1),
            np.array([GUESS, 0, 0, 0]), "newton", 1e-8,
        )  # fmt: skip
        run = march_on_group(
            Problem(problem.system, q, v, t), method, step / parts, parts, start, rescue=False
        )
        for row, name in enumerate(COUNTED):
            work.counts[row] += run.counts[name]
        if run.success:
            places = np.union1d(np.linspace(0.0, 1.0, PATH), method.table.c)
            path, turning = run(t + step * places), Exponential()
            turns = unwrapped(turning, group, coordinates(turning, group, q, path))
            work.turned[0] = max(farthest_turn(group, xi) for xi in turns)
            if work.turned[0] > chart.limit:
                return None
            xi = unwrapped(chart, group, coordinates(chart, group, q, path))
            xi = xi[np.searchsorted(places, method.table.c)]
            velocities = run.velocity(t + method.table.c * step)
            rates = np.linalg.solve(tangent(chart, group, xi), velocities[..., None])[..., 0]
            return np.ascontiguousarray(rates.T)
    work.turned[0] = abs(step) * farthest_turn(group, v)
    return None


def farthest_turn(group: Group, xi: Array) -> float:
    """The largest |xi| of a rotation in exponential coordinates or velocities (d,)."""
    return float(product.largest_rotation(group.layout, np.ascontiguousarray(xi)))

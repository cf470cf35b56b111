"""Implicit Euler, order 1 (H figure 1.1)."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar

import numpy as np

from galvi import Canonical, End, NBody, Outcome, Problem, Trajectory, input_checks
from galvi.arrays import Array
from galvi.trajectory import Ending
from references.as_trajectory import Failure, as_trajectory
from references.contender import steps_of_run
from references.newton import acceleration, acceleration_jacobian, is_forced
from references.setting import described

Function = Callable[[Array, float], Array]
DEFAULT_TOLERANCE = 8.0 * float(np.finfo(np.float64).eps)


@dataclass(frozen=True)
class ImplicitEuler:
    """q' = q + h v', v' = v + h a(q', t + h), by Newton's method from the explicit guess.

    Setting: step, save_every, tolerance (last Newton update relative to |q| + h |v|, default
    8 eps), max_iterations (default 50). A solve that does not converge ends the run, unless
    accept_unconverged is set: then the run goes on from its last iterate, and status and
    counts["unconverged_steps"] report it.
    """

    fixed_step: ClassVar[bool] = True

    name: str = "implicit Euler"
    order: int = 1
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """Any system whose force depends on q and t alone."""
        return isinstance(problem.system, (Canonical, NBody)) and not is_forced(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`."""
        steps = steps_of_run(
            self, problem, duration, setting, "tolerance", "max_iterations", "accept_unconverged"
        )
        tolerance = input_checks.positive("tolerance", setting.get("tolerance", DEFAULT_TOLERANCE))
        limit = input_checks.whole("max_iterations", setting.get("max_iterations", 50))
        times = steps.times(problem.t0)
        accelerated, slope = acceleration(problem), acceleration_jacobian(problem)
        zero_velocity = np.zeros(problem.v0.shape)  # supported forces do not depend on velocities

        def force(q: Array, t: float) -> Array:
            return accelerated(q, zero_velocity, t)

        q, v, a = problem.q0, problem.v0, force(problem.q0, problem.t0)
        saved_q, saved_v = (np.full((len(times), *q.shape), np.nan) for _ in "qv")
        saved_q[0], saved_v[0] = q, v
        row, iterations, unconverged, failure = 1, 0, [], None
        for k in range(1, steps.count + 1):
            with np.errstate(all="ignore"):
                t = problem.t0 + k * steps.step
                q, step_iterations, converged = _solve(
                    force, slope, q, v, a, t, steps.step, tolerance, limit
                )
                a = force(q, t)
            v = v + steps.step * a
            iterations += step_iterations
            if not converged:
                unconverged.append(k)
            if not np.all(np.isfinite(v)) or (
                unconverged and not setting.get("accept_unconverged")
            ):
                failure = Failure(
                    row=row, step=k, why=_stalled(k, step_iterations, problem.t0, steps.step)
                )
                break
            if k == steps.saved[row]:
                saved_q[row], saved_v[row] = q, v
                row += 1
        run = as_trajectory(
            problem,
            described(self.name, setting),
            times,
            saved_q,
            saved_v,
            counts={
                "steps": k if failure is None else k - 1,
                "unconverged_steps": len(unconverged),
                "iterations": iterations,
                "force_evaluations": iterations + k + 1,
                "hessian_evaluations": iterations,
                "linear_solves": iterations,
            },
            step=steps.step,
            failure=failure,
        )
        if not (unconverged and run.success):
            return run
        return replace(run, ending=Ending(Outcome(End.DOUBTFUL, reason=_accepted(unconverged))))


def _stalled(k: int, iterations: int, t0: float, h: float) -> str:
    return (
        f"Newton's method stopped converging in step {k}, from t = {t0 + (k - 1) * h:.6g}, after "
        f"{iterations} iterations. Choose a smaller step, or end the run earlier."
    )


def _accepted(stalled: list[int]) -> str:
    return (
        f"Newton's method did not converge in {len(stalled)} steps, first in step "
        f"{stalled[0]}; from there on these are not states of implicit Euler"
    )


def _solve(
    force: Function,
    slope: Function,
    q: Array,
    v: Array,
    a: Array,
    t: float,
    h: float,
    tolerance: float,
    limit: int,
) -> tuple[Array, int, bool]:
    """The configuration at the time t by Newton's method: the last iterate, the number of
    iterations, and whether it converged."""
    drifted = q + h * v
    size = np.max(np.abs(q)) + abs(h) * np.max(np.abs(v))
    new = drifted + h**2 * a
    for iteration in range(1, limit + 1):
        residual = new - drifted - h**2 * force(new, t)
        matrix = np.eye(q.size) - h**2 * slope(new, t)
        if not (np.all(np.isfinite(residual)) and np.all(np.isfinite(matrix))):
            break
        try:
            update = np.linalg.solve(matrix, residual.ravel()).reshape(q.shape)
        except np.linalg.LinAlgError:
            break
        new = new - update
        if np.max(np.abs(update)) <= tolerance * size:
            return new, iteration, True
    return new, iteration, False


IMPLICIT_EULER = ImplicitEuler()

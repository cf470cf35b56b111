"""Compiled RK4 on quaternions: the cost of a conventional special-purpose code."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.closed_forms.principal_body import PrincipalBody, is_known_body
from references.contender import require
from references.setting import check_keys, described, fixed_steps
from references.textbook import quaternion_kernel

CHUNK = 100_000  # steps between two looks at Ctrl-C


@dataclass(frozen=True)
class QuaternionRK4:
    """The classical Runge-Kutta method on (quaternion, body momentum); setting: step, save_every.

    In the principal axes, so that w = J^-1 p costs three products; no memory is taken in the loop.
    The quaternion is divided by its norm after every step, the momentum is left alone.
    """

    name: str = "RK4 on quaternions, compiled"
    order: int = 4
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody that is free or has its weight."""
        return is_known_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Equal steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("step", "save_every"))
        steps = fixed_steps(duration, setting)
        times = steps.times(problem.t0)
        body = PrincipalBody.of(problem)
        advance = quaternion_kernel.compiled("rk4")
        state = body.start()
        saved = np.full((len(times), 7), np.nan)
        saved[0] = state
        every = int(steps.saved[1])
        failed = done = 0
        while done < steps.count and not failed:
            last = min(done + CHUNK, steps.count)
            failed = advance(
                *body.numbers, state, steps.step, done, last, steps.count, every, saved
            )
            done = failed - 1 if failed else last
        q, p = body.states(problem, saved)
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            q,
            p=p,
            counts={"steps": done, "force_evaluations": 4 * (done + (failed > 0))},
            step=steps.step,
            failure=_failure(failed, steps.saved, times) if failed else None,
        )


def _failure(failed: int, saved: Any, times: Array) -> Failure:
    row = int(np.searchsorted(saved, failed))
    return Failure(
        row=row,
        step=failed,
        why=f"Step {failed}, towards t = {times[row]:.6g}, gave a non-finite state: the step is "
        "too large. Choose a smaller step, or end the run earlier.",
    )


QUATERNION_RK4 = QuaternionRK4()

"""DOP853, Dormand and Prince's method of order 8, compiled for rigid bodies."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cache
from typing import Any

import numpy as np
import scipy

from galvi import Problem, Trajectory, input_checks
from galvi.arrays import Array
from references.as_trajectory import Failure, as_trajectory
from references.closed_forms.principal_body import PrincipalBody, is_known_body
from references.contender import require
from references.setting import check_keys, described, sample_times
from references.textbook import quaternion_kernel

TRIES = 100_000  # between two looks at Ctrl-C
SMALLEST = 1e-16  # tolerance; below it only round-off is left to control
FIRST = 0.01  # first step tried, over the time of one radian
DEFAULT: Mapping[str, Any] = {"tolerance": 1e-9}
LOOSE = "With the default tolerance of 1e-9 it is no truth: for a truth, set tolerance=1e-15."
TIGHT: Mapping[str, Any] = {"tolerance": 1e-15}


@dataclass(frozen=True)
class QuaternionDOP853:
    """Adaptive steps on (quaternion, body momentum), tableau and error estimate as in SciPy.

    Setting: samples; tolerance, both relative and absolute. The default of 1e-9 leaves about eight
    digits: add TIGHT for a truth. Samples are ends of steps.
    Otherwise as `references.textbook.quaternion_rk4.QuaternionRK4`.
    """

    name: str = "DOP853 on quaternions, compiled"
    order: int = 8
    exact: bool = False
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody that is free or has its weight."""
        return is_known_body(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Adaptive steps; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples", "tolerance"))
        times = sample_times(problem.t0, duration, setting)
        tolerance = input_checks.positive(
            "tolerance", setting.get("tolerance", DEFAULT["tolerance"])
        )
        if tolerance < SMALLEST:
            raise ValueError(
                f"tolerance must be at least {SMALLEST:g}, below which only round-off is left; "
                f"received {tolerance!r}."
            )
        body = PrincipalBody.of(problem)
        advance = quaternion_kernel.compiled("dop853")
        state = body.start()
        saved = np.full((len(times), 7), np.nan)
        saved[0] = state
        turning = np.max(np.abs(body.numbers[0] * body.p0))
        first = FIRST / turning if turning else abs(duration)
        clock = np.array([0.0, 0.0, np.copysign(min(first, abs(duration)), duration)])
        tries = steps = 0
        failure = None
        for row, t in enumerate(times[1:] - problem.t0, start=1):
            clock[1], status = t, 1
            while status == 1:
                status, tried, accepted = advance(
                    *body.numbers, state, *_tableau(), tolerance, tolerance, clock, TRIES
                )
                tries, steps = tries + tried, steps + accepted
            if status < 0:
                failure = Failure(row=row, step=steps + 1, why=_stuck(problem.t0 + clock[0]))
                break
            saved[row] = state
        q, p = body.states(problem, saved)
        engine = f"tableau of scipy {scipy.__version__}"
        return as_trajectory(
            problem,
            described(self.name, {**setting, "tolerance": tolerance}, engine),
            times,
            q,
            p=p,
            counts={"steps": steps, "rejected_steps": tries - steps,
                    "force_evaluations": 11 * tries + steps + 1},
            failure=failure,
            note="" if "tolerance" in setting else LOOSE,
        )  # fmt: skip


def _stuck(t: float) -> str:
    return (
        f"The step became too small at t = {t:.6g}: the state is not finite, or the "
        "tolerance cannot be had. Loosen it, or end the run earlier."
    )


@cache
def _tableau() -> tuple[Array, Array, Array]:
    """A with the weights as its last row (13, 12), and the two error estimates (12,)."""
    from scipy.integrate import DOP853

    method: Any = DOP853
    A = np.vstack([method.A, method.B])
    return tuple(np.ascontiguousarray(x) for x in (A, method.E3[:-1], method.E5[:-1]))


QUATERNION_DOP853 = QuaternionDOP853()

"""The free rigid body in closed form, attitude included."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import localcontext
from typing import Any

import numpy as np

from galvi import Problem, RigidBody, Trajectory
from references.as_trajectory import as_trajectory
from references.closed_forms.decimal_trigonometry import DIGITS
from references.closed_forms.top_motion import motion
from references.contender import require
from references.newton import is_forced
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class FreeTop:
    """A RigidBody without potential: any inertia, any start, on the separatrix too.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the entries of q and p come
    out rounded once: within eps / 2 of the exact motion of that start, however long the run.
    """

    name: str = "free rigid body, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A RigidBody without potential and external torque."""
        free = isinstance(problem.system, RigidBody) and problem.system.potential is None
        return free and not is_forced(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        system: Any = problem.system
        with localcontext(DIGITS):
            moving = motion(system.inertia, problem.q0, problem.v0)
            states = [moving(t) for t in (times - problem.t0).tolist()]
        q, p = (np.array([x[k] for x in states], dtype=np.float64) for k in (0, 1))
        p[0] = problem.p0  # rounded as galvi rounds it
        return as_trajectory(
            problem, described(self.name, setting), times, q, p=p, counts={"steps": 0}
        )


FREE_TOP = FreeTop()

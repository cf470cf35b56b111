"""A body thrown in uniform gravity in closed form: a free rotation, and a parabola."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from galvi import Problem, Trajectory
from galvi.extended_precision import decimals
from references.as_trajectory import as_trajectory
from references.closed_forms.decimal_trigonometry import DIGITS
from references.closed_forms.top_motion import motion
from references.contender import require
from references.newton import is_thrown
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class ThrownBody:
    """A FreeBody: any inertia, any start.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the entries of q and p come
    out rounded once, as of `references.closed_forms.top_motion.FreeTop`.
    """

    name: str = "thrown body, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A FreeBody on which gravity alone acts."""
        return is_thrown(problem)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        body: Any = problem.system
        start, v = problem.q0, problem.v0
        q = np.zeros((len(times), 4, 4))
        q[:, 3, 3] = 1.0
        p = np.empty((len(times), 6))
        with localcontext(DIGITS):
            turning = motion(body.inertia, start[:3, :3], v[:3])
            place, g = decimals(start[:3, 3]), decimals(body.g)
            speed = decimals(start[:3, :3]) @ decimals(v[3:])
            for k, t in enumerate(Decimal(t) for t in (times - problem.t0).tolist()):
                R, spin = turning(float(t))
                q[k, :3, :3], q[k, :3, 3] = R, place + t * speed + t * t / 2 * g
                p[k, :3], p[k, 3:] = spin, Decimal(body.mass) * ((speed + t * g) @ R)
        p[0] = problem.p0  # rounded as galvi rounds it
        return as_trajectory(
            problem, described(self.name, setting), times, q, p=p, counts={"steps": 0}
        )


THROWN_BODY = ThrownBody()

"""Independent harmonic oscillators in closed form."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from galvi import LinearSpring, Problem, Trajectory
from references.as_trajectory import as_trajectory
from references.contender import require
from references.newton import is_moved_by
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class Oscillator:
    """A LinearSpring on a scalar or diagonal mass: q = q0 cos wt + (v0 / w) sin wt, w^2 = k / m.

    Setting: samples. The rounding of w t costs about eps |v| |t - t0|.
    """

    name: str = "oscillator, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """A Canonical system with a LinearSpring and no external force."""
        return is_moved_by(problem, LinearSpring)

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        system: Any = problem.system
        w = np.sqrt(system.potential.stiffness / system.mass)
        phase = (times - problem.t0)[:, None] * np.broadcast_to(w, problem.q0.shape)
        cosine, sine = np.cos(phase), np.sin(phase)
        return as_trajectory(
            problem,
            described(self.name, setting),
            times,
            problem.q0 * cosine + problem.v0 / w * sine,
            problem.v0 * cosine - problem.q0 * w * sine,
            counts={"steps": 0},
        )


OSCILLATOR = Oscillator()

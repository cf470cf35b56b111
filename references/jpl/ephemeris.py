"""JPL's ephemeris DE421 as a trajectory: the motion of the planets, not of point masses."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any, ClassVar

import numpy as np

from galvi import NBody, Problem, Trajectory, problems
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.contender import require, times_of_run
from references.jpl import states as jpl
from references.setting import described


@dataclass(frozen=True)
class JplEphemeris:
    """DE421 (Folkner, Williams and Boggs 2009) for a problem that starts from it in the year 2000.

    Setting: samples; times from 1900 to 2200. Not exact for any `Problem`: DE421 was fitted to
    observations, with relativity (post-Newtonian), asteroids, the Moon apart from the Earth and its
    tides, and the oblateness of the Sun. Against Newton's point masses the differences are of
    the model and not of an integrator. Its velocities are derivatives of its Chebyshev series.
    """

    fixed_step: ClassVar[bool] = False
    engine: ClassVar[str] = "jplephem"

    name: str = "JPL DE421"
    exact: bool = False

    @property
    def missing(self) -> str:
        """Why DE421 cannot be read here; empty when it can."""
        return jpl.missing()

    def supports(self, problem: Problem) -> bool:
        """Masses and start of `problems.solar_system`, with Pluto or without, bit for bit."""
        system, table = problem.system, problems.solar_system()
        n = len(table.q0)
        if not isinstance(system, NBody) or system.masses.size not in (n - 1, n):
            return False
        n, solar = system.masses.size, table.system
        return (
            isinstance(solar, NBody)
            and not system.forces
            and system.G == solar.G
            and np.array_equal(system.masses, solar.masses[:n])
            and np.array_equal(problem.q0, table.q0[:n])
            and np.array_equal(problem.v0, table.v0[:n])
        )

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """Look up; see `Contender`. ValueError for times outside the ephemeris."""
        times = times_of_run(self, problem, duration, setting)
        q, v = jpl.states(times - problem.t0, bodies=len(problem.q0))
        method = described(self.name, setting, _engine())
        return as_trajectory(problem, method, times, q, v, counts={"steps": 0})


def _engine() -> str:
    from importlib.metadata import version

    return f"jplephem {version('jplephem')}, de421 {version('de421')}"


def differences(run: Trajectory) -> Array:
    """Distance of each body to where DE421 has it, au, (saved, bodies), at the times of a run.

    The run may be any contender's on a problem that `JplEphemeris` supports; ValueError otherwise.
    """
    require(JPL_EPHEMERIS, run.problem)
    q, _ = jpl.states(run.t - run.problem.t0, bodies=len(run.problem.q0))
    return np.linalg.norm(run.q - q, axis=-1)


JPL_EPHEMERIS = JplEphemeris()

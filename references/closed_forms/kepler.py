"""The two-body problem in closed form, for any eccentricity below 1."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from decimal import Decimal, localcontext
from typing import Any

import numpy as np

from galvi import Canonical, CentralForce, NBody, Problem, Trajectory
from galvi.arrays import Array
from references.as_trajectory import as_trajectory
from references.closed_forms.double_double import DoubleDouble
from references.closed_forms.kepler_flow import DIGITS, Orbit, flow, orbit
from references.contender import require
from references.newton import is_moved_by
from references.setting import check_keys, described, sample_times


@dataclass(frozen=True)
class Kepler:
    """A CentralForce on a scalar mass in 2 or 3 dimensions, or two bodies; bound, not radial.

    Setting: samples. The start is taken as exact, t - t0 likewise, and the error of q stays within
    4 eps (|q| + |v| |t - t0|), eps = 2.2e-16, at eccentricities up to 0.999999.
    """

    name: str = "Kepler, closed form"
    exact: bool = True
    missing: str = ""

    def supports(self, problem: Problem) -> bool:
        """By the system, and by the start: the orbit must be an ellipse."""
        return _orbit(problem) is not None

    def run(self, problem: Problem, duration: float, setting: Mapping[str, Any]) -> Trajectory:
        """States at evenly spaced times; see `Contender`."""
        require(self, problem)
        check_keys(setting, ("samples",))
        times = sample_times(problem.t0, duration, setting)
        known = _orbit(problem)
        assert known is not None
        q, v = _motion(problem, known, times - problem.t0)
        return as_trajectory(
            problem, described(self.name, setting), times, q, v, counts={"steps": 0}
        )


def _orbit(problem: Problem) -> Orbit | None:
    """The orbit about the centre, or of the second body about the first; None if unsupported."""
    system, q0, v0 = problem.system, problem.q0, problem.v0
    with localcontext(DIGITS):
        if isinstance(system, Canonical) and is_moved_by(problem, CentralForce):
            if system.mass.ndim:
                return None
            gm = Decimal(system.potential.mu) / Decimal(float(system.mass))
            return orbit(gm, [Decimal(x) for x in q0.tolist()], [Decimal(x) for x in v0.tolist()])
        if isinstance(system, NBody) and system.masses.size == 2:
            gm = Decimal(system.G) * sum(map(Decimal, system.masses.tolist()))
            apart = [[Decimal(b) - Decimal(a) for a, b in zip(*x.tolist(), strict=True)]
                     for x in (q0, v0)]  # fmt: skip
            return orbit(gm, *apart)
    return None


def _motion(problem: Problem, known: Orbit, t: Array) -> tuple[Array, Array]:
    """q and v at times t (k,) since the start."""
    q0, v0 = (DoubleDouble(x, np.zeros_like(x)) for x in (problem.q0, problem.v0))
    if not isinstance(problem.system, NBody):
        q, v = flow(known, q0, v0, t)
        return q.hi, v.hi
    masses = problem.system.masses
    share = DoubleDouble(masses) / (DoubleDouble(masses[0]) + masses[1])
    moving_q, moving_v = (share[0] * x[0] + share[1] * x[1] for x in (q0, v0))
    q, v = flow(known, q0[1] - q0[0], v0[1] - v0[0], t)
    centre = moving_q + moving_v * t[:, None]
    places = (centre - share[1] * q, centre + share[0] * q)
    speeds = (moving_v - share[1] * v, moving_v + share[0] * v)
    return np.stack([x.hi for x in places], axis=1), np.stack([x.hi for x in speeds], axis=1)


KEPLER = Kepler()

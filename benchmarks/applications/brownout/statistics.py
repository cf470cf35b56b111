"""Statistics of a cloud: optical depth and height, with the errors of sampling and of the step.

A cloud of n super-particles of each size gives a mean, whose sampling error is its standard
deviation over sqrt(n). The error of the step is the mean of the same particles' differences from a
run of high order, in which their sampling errors cancel.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.applications.brownout.cloud import DIAMETERS, END_TIME, Cloud, optical_depth
from benchmarks.applications.brownout.emission import Emission
from benchmarks.applications.brownout.flights import FAILED, Flights
from benchmarks.statistics.estimate import Estimate
from galvi.arrays import Array

DEPTH, HEIGHT = "optical depth", "height of the centre of mass [m]"


@dataclass(frozen=True, eq=False)
class ParticleShares:
    """The shares (sizes, n) of the super-particles in the statistics, which are their sums.

    Attributes
    ----------
    work
        number of evaluations of the wind: passes of the iteration times stages
    unsolved
        number of grains whose step equations were not solved; their shares are NaN
    """

    depth: Array
    height: Array
    work: float
    unsolved: int

    @property
    def grains(self) -> float:
        """The number of super-particles of all sizes."""
        return float(self.depth.size)

    def shares_in(self, quantity: str) -> Array:
        """The shares in DEPTH or HEIGHT."""
        return self.depth if quantity == DEPTH else self.height


def particle_shares(clouds: Mapping[float, Cloud], method: Any, steps: int) -> ParticleShares:
    """Run clouds, by diameter, with the same number of super-particles each; returns the shares."""
    runs = {diameter: cloud.flights(method, steps) for diameter, cloud in clouds.items()}
    return ParticleShares(
        np.array([_depth(run, clouds[d]) for d, run in runs.items()]),
        np.array([_height(run, clouds[d]) for d, run in runs.items()]),
        float(sum(run.passes.sum() for run in runs.values())) * method.stages,
        int(sum(np.sum(run.status == FAILED) for run in runs.values())),
    )


def _depth(run: Flights, cloud: Cloud) -> Array:
    mass = cloud.emission.mass / len(run.t)
    return mass * optical_depth(run.q, cloud.diameter)


def _height(run: Flights, cloud: Cloud) -> Array:
    """Shares in the height of the centre of all lifted mass, 0 for grains on the ground."""
    masses = [Emission(d, END_TIME, 1.0 / len(DIAMETERS)).mass for d in DIAMETERS]
    return cloud.emission.mass / sum(masses) / len(run.t) * run.q[:, 2]


def total(shares: Array) -> Estimate:
    """The sum over sizes and super-particles, with its sampling error."""
    n = shares.shape[1]
    error = math.sqrt(float(np.sum(n * np.var(shares, axis=1, ddof=1))))
    return Estimate(float(np.sum(shares)), error)

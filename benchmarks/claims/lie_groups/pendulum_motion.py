"""The 3D pendulum of H 3.5.2 and its truths, shared by L6 to L9, L11, L15, L17 and L18."""

from __future__ import annotations

from typing import Any

import numpy as np

import galvi
from benchmarks.claims.kit import ORACLES, Problem, row
from benchmarks.work_precision.with_settings import WithSettings
from references import Contender
from references.scipy import ivp
from references.scipy.rigid_ivp import RIGID_DOP853
from references.textbook import quaternions

FLOOR = 8e-15  # entries of R after T = 5; 1e-15 was measured at n = 9 and above
# At T = 5 its distance from heyoka in quadruple precision is 2e-15.
TRUTH = WithSettings(quaternions.QUATERNION_DOP853, quaternions.TIGHT)
SECOND = WithSettings(RIGID_DOP853, ivp.TIGHT)
problem = galvi.problems.pendulum_3d


def oracles(
    motion: Problem,
    duration: float,
    samples: int,
    first: Contender = TRUTH,
    second: Contender = SECOND,
    study: str = ORACLES,
) -> dict[str, Any]:
    """The row ORACLES: the largest difference of an entry between two truths at `samples` times."""
    both = [truth.run(motion, duration, {"samples": samples}).q for truth in (first, second)]
    return row(study=study, quantity=ORACLES, value=float(np.max(np.abs(both[0] - both[1]))))

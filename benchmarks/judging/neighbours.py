"""How long a prediction means anything: how fast runs from neighbouring starts part."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.judging.candidate import Source
from benchmarks.judging.truth import Errors
from galvi import Problem, Trajectory
from galvi.arrays import Array

SHIFT = 1e-9  # of each coordinate, relative to its part's largest
KNOWN = (1e-6, 1e-9, 1e-12, 1e-15)  # relative accuracies of a start
SEED = 20_260_101


def growth(source: Source, truth: Trajectory, errors: Errors) -> Array:
    """The distance of a run from a start that is shifted by ``SHIFT``, over ``SHIFT``, (saved,)."""
    problem = truth.problem
    draw = np.random.default_rng(SEED).choice([-1.0, 1.0], problem.q0.shape)
    shifted = Problem(
        problem.system, problem.q0 * (1.0 + SHIFT * draw), problem.v0, problem.t0,
        problem.name, dict(problem.parameters), problem.units,
    )  # fmt: skip
    duration = float(truth.t[-1] - truth.t[0])
    setting = {"samples": len(truth.t) - 1, **source.setting}
    run = source.contender.run(shifted, duration, setting)
    apart = errors(run, truth).reshape(len(truth.t), -1).max(axis=1)
    found: Array = apart / SHIFT
    return found


def horizons(t: Array, grown: Array, error: float) -> pd.DataFrame:
    """For starts known to ``KNOWN``, the first time at which the error is reached; NaN for none."""
    rows = []
    for known in KNOWN:
        beyond = np.flatnonzero(~(grown * known < error))
        rows.append((known, float(t[beyond[0]]) if beyond.size else np.nan))
    return pd.DataFrame(rows, columns=["start_known_to", "until"])

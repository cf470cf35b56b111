"""How long a prediction means anything: how fast runs from neighbouring starts part."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.judging.candidate import Kind, Source
from galvi import Trajectory
from galvi.arrays import Array

SHIFT = 1e-9  # of each coordinate
KNOWN = (1e-6, 1e-9, 1e-12, 1e-15)  # relative accuracies of a start
SEED = 20_260_101


def growth(kind: Kind, source: Source, truth: Trajectory) -> Array:
    """The distance of a run from a start that is shifted by ``SHIFT``, over ``SHIFT``, (saved,)."""
    problem = truth.problem
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], 2 * problem.q0.size)
    shifted = kind.shifted(problem, SHIFT, signs)
    run = source.run(shifted, float(truth.t[-1] - truth.t[0]), len(truth.t) - 1)
    found: Array = kind.errors(run, truth).max(axis=1) / SHIFT
    return found


def horizons(t: Array, grown: Array, error: float) -> pd.DataFrame:
    """For starts known to ``KNOWN``, the first time at which the error is reached; NaN for none."""
    rows = []
    for known in KNOWN:
        beyond = np.flatnonzero(~(grown * known < error))
        rows.append((known, float(t[beyond[0]]) if beyond.size else np.nan))
    return pd.DataFrame(rows, columns=["start_known_to", "until"])

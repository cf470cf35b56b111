"""Horizons of prediction: until when runs from neighbouring starts stay together."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.applications.judging.candidate import Kind, Source
from galvi import Trajectory
from galvi.arrays import Array

START_ACCURACIES = (1e-6, 1e-9, 1e-12, 1e-15)  # relative accuracies of a start
# shifts of a start that are run; from others the distances are in proportion, as long as they are
# small, as a required error is
SHIFTS = {1e-6: 1e-9, 1e-9: 1e-9, 1e-12: 1e-12, 1e-15: 1e-12}
SMALL = 0.01  # of the motion: distances up to this are in proportion to a shift
SEED = 20_260_101


def deviations(kind: Kind, source: Source, truth: Trajectory, accuracy: float) -> Array:
    """The error of a run from a start of this relative accuracy, (saved,)."""
    problem = truth.problem
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], 2 * problem.q0.size)
    shifted = kind.shifted(problem, accuracy, signs)
    run = source.run(shifted, float(truth.t[-1] - truth.t[0]), len(truth.t) - 1)
    return kind.errors(run, truth).max(axis=1)


def horizons(kind: Kind, source: Source, truth: Trajectory, error: float) -> pd.DataFrame:
    """For each of ``START_ACCURACIES``, the first time at which the error is reached, or NaN."""
    small = SMALL * kind.size(truth)
    measured = {
        shift: deviations(kind, source, truth, shift) for shift in dict.fromkeys(SHIFTS.values())
    }
    rows = []
    for accuracy in START_ACCURACIES:
        shift, ran = SHIFTS[accuracy], measured[SHIFTS[accuracy]]
        lost = (accuracy < shift) & ~(ran < small)
        beyond = np.flatnonzero(~(ran * (accuracy / shift) < error) | lost)
        rows.append((accuracy, float(truth.t[beyond[0]]) if beyond.size else np.nan))
    return pd.DataFrame(rows, columns=["start_known_to", "until"])

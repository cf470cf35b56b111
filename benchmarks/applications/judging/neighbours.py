"""Horizons of prediction: until when runs from neighbouring starts stay together."""

from __future__ import annotations

import numpy as np
import pandas as pd

from benchmarks.applications.judging.candidate import Kind, Source
from galvi import Trajectory
from galvi.arrays import Array

START_ACCURACIES = (1e-6, 1e-9, 1e-12, 1e-15)  # relative accuracies of a start
# accuracy of a start -> shift of the start that is run; small distances are in proportion to it
SHIFTS = {1e-6: 1e-9, 1e-9: 1e-9, 1e-12: 1e-12, 1e-15: 1e-12}
PROPORTIONAL_FRACTION = 0.01  # of the motion: smaller distances are in proportion to a shift
SEED = 20_260_101


def deviations(kind: Kind, source: Source, truth: Trajectory, accuracy: float) -> Array:
    """The distance from the truth of a run from a start shifted by `accuracy`, (saved,)."""
    problem = truth.problem
    signs = np.random.default_rng(SEED).choice([-1.0, 1.0], 2 * problem.q0.size)
    shifted = kind.shifted(problem, accuracy, signs)
    run = source.run(shifted, float(truth.t[-1] - truth.t[0]), len(truth.t) - 1)
    return kind.errors(run, truth).max(axis=1)


def horizons(kind: Kind, source: Source, truth: Trajectory, error: float) -> pd.DataFrame:
    """For each of ``START_ACCURACIES`` the first time at which the error is reached, or at which
    distances are no longer in proportion to the shift; NaN where neither happens."""
    small = PROPORTIONAL_FRACTION * kind.size(truth)
    measured = {
        shift: deviations(kind, source, truth, shift) for shift in dict.fromkeys(SHIFTS.values())
    }
    rows = []
    for accuracy in START_ACCURACIES:
        shift, distances = SHIFTS[accuracy], measured[SHIFTS[accuracy]]
        is_out_of_proportion = (accuracy < shift) & ~(distances < small)
        beyond = np.flatnonzero(~(distances * (accuracy / shift) < error) | is_out_of_proportion)
        rows.append((accuracy, float(truth.t[beyond[0]]) if beyond.size else np.nan))
    return pd.DataFrame(rows, columns=["start_known_to", "until"])

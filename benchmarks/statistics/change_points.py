"""Change points of a series: binary segmentation with a rank test.

A segment is split where the Mann-Whitney test between both parts gives the smallest p. The split is
a change when p times the number of candidates is below SIGNIFICANCE and the medians differ by more
than LEAST_CHANGE. Both parts are then searched in the same way, with ranks of their own: the
penalised cost of the ranks of a whole series, as in change-point libraries, misses the second of
two changes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

SIGNIFICANCE = 0.05
LEAST_CHANGE = 0.05  # relative to the earlier median
FEWEST_POINTS = 4  # fewest points in a part
CHANGE_RULE = (
    "A change is marked where a rank test between the values before and after it, corrected for "
    f"the number of candidates, gives p below {SIGNIFICANCE}, and the medians differ by more than "
    f"{100 * LEAST_CHANGE:.0f} %, with at least {FEWEST_POINTS} runs on either side. Counts are "
    "exact: every difference is marked. Errors: every difference beyond the benchmark's tolerance "
    "is marked."
)


def change_points(values: Sequence[float]) -> list[int]:
    """Indices k, ascending, such that values[k] is the first value of a new level.

    Values that are not finite are ignored.
    """
    finite = np.flatnonzero(np.isfinite(values))
    return finite[_changes(np.asarray(values, dtype=float)[finite])].tolist()


def _changes(series: np.ndarray, first: int = 0) -> list[int]:
    """The change points of a segment of finite values that begins at index `first`."""
    from scipy.stats import mannwhitneyu  # a sixth of the import of a report

    splits = range(FEWEST_POINTS, len(series) - FEWEST_POINTS + 1)
    if not splits or np.ptp(series) == 0.0:
        return []
    p, split = min((mannwhitneyu(series[:k], series[k:]).pvalue, k) for k in splits)
    before, after = series[:split], series[split:]
    level = np.median(before)
    if p * len(splits) >= SIGNIFICANCE or abs(np.median(after) - level) <= LEAST_CHANGE * abs(
        level
    ):
        return []
    return [*_changes(before, first), first + split, *_changes(after, first + split)]


def steps(values: Sequence[float], tolerance: float) -> list[int]:
    """Indices where a value differs from the last finite one before it by more than the tolerance.

    Parameters
    ----------
    values
        numbers that are not negative, or not finite
    tolerance
        relative to the smaller of the two values; 0 marks all differences
    """
    finite = np.flatnonzero(np.isfinite(values))
    series = np.asarray(values, dtype=float)[finite]
    before, after = series[:-1], series[1:]
    changed = np.maximum(before, after) > (1.0 + tolerance) * np.minimum(before, after)
    return finite[1:][changed].tolist()

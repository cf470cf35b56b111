"""Where a series changes its level: binary segmentation with a rank test.

A segment is split where Mann and Whitney's test between both parts gives the least chance, times
the number of places tried; it is a change when that is below LEVEL and the medians differ by more
than SIZE. Both parts are then searched in the same way. Numbers only.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

from scipy.stats import mannwhitneyu

LEVEL = 0.05
SIZE = 0.05  # of the earlier median
LEAST = 4  # points in a part
TEXT = (
    "A change is marked where a rank test between what came before and after it, corrected for "
    f"the places tried, gives less than {LEVEL}, and the medians differ by more than "
    f"{100 * SIZE:.0f} %; at least {LEAST} runs must stand on either side. Counts are exact: each "
    "difference is marked. Errors: each difference beyond the benchmark's tolerance."
)


def change_points(values: Sequence[float], size: float = SIZE, level: float = LEVEL) -> list[int]:
    """Positions k such that values[k] is the first of a new level, ascending.

    Values that are not finite belong to no level and are passed over.
    """
    places = [k for k, value in enumerate(values) if math.isfinite(value)]
    series = [values[k] for k in places]
    found = []
    segments = [(0, len(series))]
    for _ in range(2 * len(series) + 1):
        if not segments:
            break
        start, end = segments.pop()
        split = _split(series[start:end], size, level)
        if split is not None:
            found.append(places[start + split])
            segments += [(start, start + split), (start + split, end)]
    return sorted(found)


def steps(values: Sequence[float], tolerance: float) -> list[int]:
    """Positions where a value differs from the last known one by more than the tolerance.

    tolerance  relative to the earlier value; 0 marks every difference
    """
    found, last = [], None
    for k, value in enumerate(values):
        if not math.isfinite(value):
            continue
        if last is not None and max(value, last) > (1.0 + tolerance) * min(value, last):
            found.append(k)
        last = value
    return found


def _split(part: Sequence[float], size: float, level: float) -> int | None:
    """The best place to split a segment, or None where none is good enough."""
    places = range(LEAST, len(part) - LEAST + 1)
    if not places or len(set(part)) == 1:
        return None
    chance, split = min(
        (float(mannwhitneyu(part[:k], part[k:], alternative="two-sided").pvalue), k) for k in places
    )
    before, after = statistics.median(part[:split]), statistics.median(part[split:])
    if chance * len(places) >= level or abs(after - before) <= size * abs(before):
        return None
    return split

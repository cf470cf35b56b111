"""Change points of a series: binary segmentation with a rank test.

A segment is split where the Mann-Whitney test between both parts gives the smallest p, multiplied
by the number of candidates; it is a change when that is below LEVEL and the medians differ by more
than SIZE. Both parts are then searched in the same way.
"""

from __future__ import annotations

import math
import statistics
from collections.abc import Sequence

LEVEL = 0.05
SIZE = 0.05  # relative to the earlier median
LEAST = 4  # fewest points in a part
TEXT = (
    "A change is marked where a rank test between the values before and after it, corrected for "
    f"the number of candidates, gives p below {LEVEL}, and the medians differ by more than "
    f"{100 * SIZE:.0f} %, with at least {LEAST} runs on either side. Counts are exact: every "
    "difference is marked. Errors: every difference beyond the benchmark's tolerance is marked."
)


def change_points(values: Sequence[float], size: float = SIZE, level: float = LEVEL) -> list[int]:
    """Indices k, ascending, such that values[k] is the first of a new level.

    Values that are not finite are ignored.
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
    """Indices where a value differs from the last finite one by more than the tolerance.

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
    """The best index to split a segment; None where no split is significant."""
    places = range(LEAST, len(part) - LEAST + 1)
    if not places or len(set(part)) == 1:
        return None
    from scipy.stats import mannwhitneyu  # a sixth of the import of a report

    chance, split = min(
        (float(mannwhitneyu(part[:k], part[k:], alternative="two-sided").pvalue), k) for k in places
    )
    before, after = statistics.median(part[:split]), statistics.median(part[split:])
    if chance * len(places) >= level or abs(after - before) <= size * abs(before):
        return None
    return split

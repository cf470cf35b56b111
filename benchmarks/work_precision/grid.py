"""Add settings until no code's front has a gap of more than half a decade.

Every code is treated alike. Between two neighbours of its front whose errors differ by more than
LARGEST_GAP, their lines (settings that differ in the step or the tolerance alone) get the geometric
mean of neighbouring settings. At either end settings are added until the largest of ERRORS is
exceeded, or the smallest is reached.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

import pandas as pd

from benchmarks.work_precision.asked import ERRORS, code_of
from benchmarks.work_precision.dependable import FINENESS_PATTERN, dependable
from benchmarks.work_precision.fronts import front_indices
from benchmarks.work_precision.problem import Setting

LARGEST_GAP = 0.5  # decades of error between neighbours
LEAST_LOG_RATIO = 0.03  # of two steps between which another is tried
STEP_FACTOR = math.sqrt(2.0)  # ratio of steps beyond either end
LEAST_TOLERANCE = 1e-14  # that is tried
FINENESS_KEYS = ("step", "epsilon", "tolerance")  # the first one in a setting is its fineness
MOST_ROUNDS, MAX_ADDED = 5, 20  # rounds of adding, and settings added to a code
ADDED_SECONDS = 1.5  # processor time of the runs added to a code
BRIEF_RUN_SECONDS = 0.3  # longer runs get no neighbours

CurrentRows = Callable[[], pd.DataFrame]
Add = Callable[[str, Setting], None]


def fineness_of(setting: Setting) -> tuple[str, float]:
    """The first of FINENESS_KEYS in a setting, and its value; ('', NaN) without one."""
    key = next((name for name in FINENESS_KEYS if name in setting), "")
    return key, float(setting[key]) if key else math.nan


def with_fineness(setting: Setting, value: float, duration: float) -> Setting:
    """The setting with another tolerance, or another step, rounded so that steps fill the
    duration."""
    key, _ = fineness_of(setting)
    if "save_every" not in setting:
        return {**setting, key: value}
    count = max(1, round(duration / value))
    return {**setting, key: duration / count, "save_every": count}


def line_of(setting: Setting) -> tuple[Any, ...]:
    """The entries that the settings of a line share: all but the step or the tolerance."""
    key, _ = fineness_of(setting)
    return tuple(sorted((k, v) for k, v in setting.items() if k not in (key, "save_every")))


def neighbour(key: str, value: float, line: Sequence[float], finer: bool) -> float:
    """The geometric mean of a value and the next of its line, or a value beyond the line's end; 0
    where the next value is close."""
    further = [v for v in line if (v < value if finer else v > value)]
    if further:
        adjacent = max(further) if finer else min(further)
        return (
            math.sqrt(value * adjacent)
            if abs(math.log(adjacent / value)) > LEAST_LOG_RATIO
            else 0.0
        )
    factor = STEP_FACTOR if key == "step" else 10.0**LARGEST_GAP
    return value / factor if finer else value * factor


def settings_to_add(
    runs: pd.DataFrame, settings: Mapping[Any, tuple[str, Setting]], duration: float
) -> list[tuple[str, Setting]]:
    """New settings for one code, each as (contender, setting).

    Parameters
    ----------
    runs
        its current rows, with `dependable` errors; a row's index is a key of `settings`
    """
    lines = {
        index: (contender, line_of(setting)) for index, (contender, setting) in settings.items()
    }
    known_settings = {
        (lines[index], fineness_of(setting)) for index, (_, setting) in settings.items()
    }
    additions: list[tuple[str, Setting]] = []

    def offer(index: Any, finer: bool) -> None:
        """Add a setting's neighbour, where it is affordable and new."""
        contender, setting = settings[index]
        key, value = fineness_of(setting)
        values = [
            fineness_of(settings[k][1])[1] for k, line in lines.items() if line == lines[index]
        ]
        if not key or runs["seconds"][index] > BRIEF_RUN_SECONDS:
            return
        new = neighbour(key, value, values, finer)
        if new <= 0.0 or (key != "step" and new < LEAST_TOLERANCE):
            return
        added = with_fineness(setting, new, duration)
        if (lines[index], fineness_of(added)) not in known_settings:
            known_settings.add((lines[index], fineness_of(added)))
            additions.append((contender, added))

    errors, points = runs["error"], front_indices(runs)
    widest = sorted(_holes(errors, points, lines), key=lambda hole: -hole[2])
    for coarser, finer, gap in widest:
        if gap > LARGEST_GAP:
            offer(coarser, finer=True)
            offer(finer, finer=False)
    if points and errors[points[0]] < ERRORS[0]:
        offer(points[0], finer=False)
    if points and errors[points[-1]] > ERRORS[-1]:
        offer(points[-1], finer=True)
    return additions


def _holes(
    errors: pd.Series, points: Sequence[Any], lines: Mapping[Any, Any]
) -> Iterator[tuple[Any, Any, float]]:
    """Yield (coarser, finer, decades between their errors within the range of ERRORS).

    They are neighbours by error among the settings on the lines of two neighbours of the front.
    """
    for a, b in pairwise(points):
        between = errors[[line in (lines[a], lines[b]) for line in map(lines.get, errors.index)]]
        between = between[(between <= errors[a]) & (between >= errors[b])]
        for c, d in pairwise(between.sort_values(ascending=False).index):
            high, low = min(errors[c], ERRORS[0]), max(errors[d], ERRORS[-1])
            if high > low:
                yield c, d, math.log10(high / low)


def add_settings(
    current_rows: CurrentRows,
    settings: Mapping[Any, tuple[str, Setting]],
    duration: float,
    add: Add,
) -> None:
    """Add settings to each code until none is missing, or its limits are reached.

    Parameters
    ----------
    current_rows
        function that returns the current rows, whose index is a key of `settings`
    add
        function (contender, setting) that runs a setting and adds it to the rows and to `settings`
    """
    spent: dict[str, float] = {}
    added: dict[str, int] = {}
    for _ in range(MOST_ROUNDS):
        rows = dependable(current_rows())
        codes = rows["contender"].map(code_of)
        is_complete = True
        for code in codes.drop_duplicates():
            code_rows = rows[codes == code]
            code_settings = {index: settings[index] for index in code_rows.index}
            for contender, setting in settings_to_add(code_rows, code_settings, duration):
                if spent.get(code, 0.0) > ADDED_SECONDS or added.get(code, 0) >= MAX_ADDED:
                    break
                start = time.process_time()
                add(contender, setting)
                spent[code] = spent.get(code, 0.0) + time.process_time() - start
                added[code] = added.get(code, 0) + 1
                is_complete = False
        if is_complete:
            return


def gaps(table: pd.DataFrame) -> pd.DataFrame:
    """The widest gap of each code on each problem: problem, code, settings, gap, above.

    settings is the number of settings with an error; gap the widest interval of errors, in decades
    and within ERRORS, between neighbours of the front without a setting on their lines, or from the
    largest error to the largest of ERRORS; above is its lower end.
    """
    rows = []
    text = table["settings"].fillna("").astype(str)
    lines = table["contender"] + text.str.replace(FINENESS_PATTERN, "", n=1, regex=True)
    codes = table["contender"].map(code_of)
    for (problem, code), runs in table.groupby(["problem", codes], sort=False):
        errors = runs["error"].dropna()
        holes = _holes(errors, front_indices(runs), lines)
        widest = [(wide, float(errors[finer])) for _, finer, wide in holes]
        if errors.max() < ERRORS[0]:
            widest.append((math.log10(ERRORS[0] / errors.max()), float(errors.max())))
        gap, above = max(widest, default=(math.nan, math.nan))
        rows.append((problem, code, len(errors), gap, above))
    return pd.DataFrame(rows, columns=["problem", "code", "settings", "gap", "above"])


def wide_gaps(table: pd.DataFrame, widest: float = 2.0 * LARGEST_GAP) -> Sequence[str]:
    """A sentence for each code whose settings leave a wider gap than `widest` decades."""
    return [
        f"{row['code']} has no setting in {row['gap']:.1f} decades above {row['above']:.0e}."
        for row in gaps(table).to_dict("records")
        if row["gap"] > widest
    ]

"""A comparison's rows, also those kept from earlier ones."""

from __future__ import annotations

import sys
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from functools import partial
from pathlib import Path

import pandas as pd

from benchmarks.applications.external.loading import describe_error
from benchmarks.store.cells import read_csv
from reports.results.cache import BuildCache
from reports.results.options import Options
from reports.results.progress import Studies
from reports.results.suite import Suite

MARKS = ("date", "commit", "setting")  # origin of a row; setting: quick or default


def marked(table: pd.DataFrame, origin: Mapping[str, str]) -> pd.DataFrame:
    """The table with a column for each of MARKS appended; existing columns are unchanged."""
    marks = {name: origin.get(name, "") for name in MARKS if name not in table}
    return table.assign(**marks)


def written(path: Path, key: str, origin: Mapping[str, str]) -> pd.DataFrame | None:
    """The rows of the file, marked; None when it is missing or (with a warning) unreadable.

    Parameters
    ----------
    key
        required column
    origin
        marks for rows without their own
    """
    if not path.is_file():
        return None
    try:
        table = read_csv(path)
        if key not in table:
            raise ValueError(f"it has no column {key!r}")
    except (OSError, ValueError) as error:  # pandas' own errors are ValueErrors
        why = " ".join(str(error).split())
        print(f"The rows of {path} are not kept, since it cannot be read: {why}.", file=sys.stderr)
        return None
    text = [name for name in table if table[name].dtype.kind not in "fiu"]
    return marked(table, origin).fillna(dict.fromkeys((*text, *MARKS), ""))


def merged(
    before: pd.DataFrame | None, now: pd.DataFrame, key: str, checked: Collection[str],
    known: Collection[str],
) -> pd.DataFrame:  # fmt: skip
    """The new rows, and the old rows of claims that were not checked, in the order of `known`.

    Rows of claims that no longer exist are dropped.
    """
    if before is None:
        return now
    stays = before[before[key].isin(set(known) - set(checked))]
    if stays.empty:
        return now
    both = pd.concat([now, stays.reindex(columns=now.columns)] if len(now) else [stays])
    places = {name: place for place, name in enumerate(known)}
    return both.sort_values(key, key=lambda ids: ids.map(places), kind="stable", ignore_index=True)


COST = "cost of a step"


@dataclass(frozen=True, eq=False)
class Comparison:
    """Frames of `benchmarks.work_precision.run` and `benchmarks.work_precision.cost`; None where
    one raised, with a sentence in `failures`.
    """

    work_precision: pd.DataFrame | None
    cost: pd.DataFrame | None
    failures: tuple[str, ...] = ()


def measure_comparison(
    suite: Suite, options: Options, cache: BuildCache | None = None
) -> Comparison:
    """Measure every problem and the cost; exceptions are recorded in `failures`."""
    cache, failures, frames = cache or BuildCache(), [], dict[str, pd.DataFrame]()
    by_problem = {
        f"work-precision, {name}": partial(suite.work_precision, problem=name)
        for name in suite.problems(options.quick)
    }
    measures = {**(by_problem or {"work-precision": suite.work_precision}), COST: suite.cost}
    with Studies(len(measures)) as studies:
        for title, measure in measures.items():
            try:
                with studies("cost" if title == COST else "time", title) as report:
                    result = cache.result(title, partial(measure, options.quick, report))
                frames[title] = result.frame
            except Exception as error:
                failures.append(f"{title}: not run ({describe_error(error)}).")
    cost = frames.pop(COST, None)
    runs = pd.concat(frames.values(), ignore_index=True) if frames else None
    return Comparison(runs, cost, (*failures, *suite.faults()))

"""Measured numbers, the smaller the better, in the formats of services that plot them over time.

PREFIX-benchmark-action.json  `customSmallerIsBetter` of github-action-benchmark
PREFIX-bencher.json           Bencher Metric Format
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path

from benchmarks.checks.bounds import NOT_RUN
from benchmarks.checks.claim import Row
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible

MAX_NAME_LENGTH, MAX_SLUG_LENGTH = 1024, 64  # characters, in Bencher
UPPER_BOUND_PREFIXES = ("at most", "below")  # beginnings of the texts of upper bounds
ERROR_PREFIXES = ("error", "relative change of")  # beginnings of the names of unbounded errors


@dataclass(frozen=True)
class Metric:
    """A number, the smaller the better.

    Attributes
    ----------
    benchmark
        name of what was run
    measure
        name of the measured quantity
    spread
        uncertainty of the value; 0 if it is unknown
    """

    benchmark: str
    measure: str
    value: float
    unit: str = ""
    spread: float = 0.0


def write_metrics(folder: Path, prefix: str, metrics: Iterable[Metric]) -> None:
    """Write both files; metrics whose value or spread is not finite are left out."""
    finite = [metric for metric in metrics if math.isfinite(metric.value + metric.spread)]
    for name, text in (("benchmark-action", benchmark_action), ("bencher", bencher)):
        write(folder / f"{prefix}-{name}.json", text(finite))


def benchmark_action(metrics: Sequence[Metric]) -> str:
    """JSON of github-action-benchmark: a list of name, unit, value and, with a spread, range."""
    return _as_json(
        [
            {
                "name": f"{visible(metric.benchmark)}: {visible(metric.measure)}",
                "unit": metric.unit,
                "value": metric.value,
                **({"range": f"± {metric.spread:.2g}"} if metric.spread else {}),
            }
            for metric in metrics
        ]
    )


def bencher(metrics: Sequence[Metric]) -> str:
    """JSON of Bencher: benchmark -> measure -> value and, with a spread, lower and upper value."""
    content: dict[str, dict[str, dict[str, float]]] = {}
    for metric in metrics:
        value, spread = metric.value, metric.spread
        limits = {"lower_value": value - spread, "upper_value": value + spread} if spread else {}
        measures = content.setdefault(visible(metric.benchmark)[:MAX_NAME_LENGTH], {})
        measures[_slug(metric.measure, measures)] = {"value": value, **limits}
    return _as_json(content)


def row_metrics(rows: Iterable[Row]) -> list[Metric]:
    """The measured numbers of rows of claims that are bounded from above, or are errors."""
    return [
        Metric(
            f"{row.id}: {row.quantity}",
            "measured",
            float(row.measured),
            "",
            float(row.uncertainty or 0.0),
        )
        for row in rows
        if row.measured is not None
        and row.verdict != NOT_RUN
        and (
            row.bound.startswith(UPPER_BOUND_PREFIXES)
            or (row.bound == "none" and row.quantity.startswith(ERROR_PREFIXES))
        )
    ]


def _as_json(content: object) -> str:
    return json.dumps(content, indent=1, allow_nan=False) + "\n"


def _slug(text: str, used: Collection[str]) -> str:
    """A name that Bencher allows, with a number appended if it is already in `used`."""
    slug = re.sub(r"[^a-z0-9]+", "-", text.lower()).strip("-") or "measured"
    endings = ("", *(f"-{number}" for number in range(2, len(used) + 2)))
    names = (slug[: MAX_SLUG_LENGTH - len(ending)].rstrip("-") + ending for ending in endings)
    return next(name for name in names if name not in used)

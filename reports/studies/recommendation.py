"""The section on errors and times promised by `galvi.recommend`, and those measured."""

from __future__ import annotations

from functools import partial

import pandas as pd

from benchmarks.studies.recommendation import (
    BROKEN,
    EXPLANATION,
    GAVE_UP,
    recommendation_table,
)
from reports.results.section import Section
from reports.tables.number_format import readable
from reports.tables.study_table import readable_table

HEADINGS = {
    "problem": "problem",
    "asked": "error asked",
    "measured_over": "measured over",
    "degree": "degree",
    "step": "step",
    "predicted": "predicted",
    "found": "found",
    "evaluations": "force evaluations",
    "seconds": "time [s]",
    "scan_seconds": "time of the scan [s]",
    "promise": "promise",
}


def kept_and_broken(frame: pd.DataFrame) -> str:
    """How many promises were kept, and those that were not."""
    missed = frame[frame["promise"].isin([BROKEN, GAVE_UP])]
    words = "; ".join(
        f"{row['problem']}, {readable(row['asked'], 1)} asked: {row['promise']}, found "
        f"{readable(row['found'])}"
        for row in missed.to_dict("records")
    )
    kept = f"{len(frame) - len(missed)} of {len(frame)} promises kept"
    return f"{kept}; {words}." if words else f"{kept}."


RECOMMENDATION = Section(
    name="recommendation",
    title="Which degree and step for an error: promises and findings",
    text=EXPLANATION,
    measure=recommendation_table,
    table=partial(readable_table, headings=HEADINGS),
    summary=kept_and_broken,
    compared=True,
    timed=True,
)

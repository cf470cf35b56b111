"""The section on the problems published for another implicit Gauss method in vector code."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.moving_frames import published
from reports.results.section import LongForm, Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "problem": "problem",
    "contender": "contender",
    "step": "step",
    "steps": "steps",
    "energy_error": "largest energy error",
    "microseconds": "time of a step [µs]",
    "seconds": "time [s]",
    "status": "status",
    "commit": "commit",
    "date": "date",
}

PUBLISHED = Section(
    name="published",
    title="Problems published for IRKGL16-SIMD",
    text=published.EXPLANATION,
    measure=published.published,
    table=partial(readable_table, headings=HEADINGS),
    long_form=LongForm(published.parts, published.stored),
    timed=True,
)

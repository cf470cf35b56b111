"""The section on orbits through the pericentre at high eccentricity."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.high_eccentricity import EXPLANATION, high_eccentricity_table
from reports.results.section import Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "eccentricity": "eccentricity",
    "contender": "contender",
    "settings": "setting",
    "error": "error",
    "energy_error": "energy error",
    "evaluations": "force evaluations",
    "status": "status",
}

HIGH_ECCENTRICITY = Section(
    name="high_eccentricity",
    title="Through the pericentre at high eccentricity",
    text=EXPLANATION,
    measure=high_eccentricity_table,
    table=partial(readable_table, headings=HEADINGS),
    open=True,
    compared=True,
)

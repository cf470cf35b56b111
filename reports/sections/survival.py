"""The section on who survives close encounters."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.survival import EXPLANATION, survival_table
from reports.results.section import Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "problem": "problem",
    "contender": "contender",
    "settings": "setting",
    "energy_error": "largest energy error",
    "seconds": "time [s]",
    "success": "completed",
    "status": "status",
}

SURVIVAL = Section(
    name="survival",
    title="Close encounters: who survives",
    text=EXPLANATION,
    measure=survival_table,
    table=partial(readable_table, headings=HEADINGS),
    compared=True,
    timed=True,
)

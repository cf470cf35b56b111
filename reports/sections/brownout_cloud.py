"""The section on what the grains of a brownout cloud cost."""

from __future__ import annotations

from functools import partial

from benchmarks.applications.brownout import cost
from benchmarks.applications.brownout.cost import EXPLANATION, cost_of_clouds
from reports.results.section import LongForm, Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "drag": "drag",
    "micrometres": "size [µm]",
    "degree": "degree",
    "grains": "grains",
    "threads": "threads",
    "steps": "steps of all grains",
    "passes": "passes per step",
    "microseconds": "time per step [µs]",
    "single": "step of a single run / this",
    "optical_depth": "optical depth",
    "uncertainty": "standard error",
    "status": "status",
    "commit": "commit",
    "date": "date",
}

BROWNOUT_CLOUD = Section(
    name="brownout_cloud",
    title="The brownout cloud",
    text=EXPLANATION,
    measure=cost_of_clouds,
    table=partial(readable_table, headings=HEADINGS),
    long_form=LongForm(cost.parts, cost.stored),
    timed=True,
)

"""The sections on what runs cost: from nothing, and of a brownout cloud."""

from functools import partial

from benchmarks.applications.brownout import cost
from benchmarks.studies import start_up
from reports.results.section import LongForm, Section
from reports.tables.study_table import readable_table

START_UP_COLUMNS = {
    "problem": "problem",
    "import": "import galvi [s]",
    "cold": "first run, cold [s, processor time]",
    "warm": "first run, warm [s]",
    "import_in_numpys": "import galvi / import numpy",
    "warm_in_numpys": "warm / import numpy",
    "few_steps": "memory, few steps [MiB]",
    "many_steps": "memory, many steps [MiB]",
}

START_UP = Section(
    name="start_up",
    title="The first call in a fresh process, and the memory of long runs",
    text=start_up.EXPLANATION,
    measure=start_up.start_up_table,
    table=partial(readable_table, headings=START_UP_COLUMNS),
    long_form=LongForm(start_up.parts, start_up.stored),
    compared=True,
    timed=True,
)


CLOUD_COLUMNS = {
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
    text=cost.EXPLANATION,
    measure=cost.cost_of_clouds,
    table=partial(readable_table, headings=CLOUD_COLUMNS),
    long_form=LongForm(cost.parts, cost.stored),
    timed=True,
)

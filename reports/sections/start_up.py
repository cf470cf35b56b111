"""The section on the first call in a fresh process, and on the memory of long runs."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.start_up import EXPLANATION, parts, start_up_table, stored
from reports.results.section import LongForm, Section
from reports.tables.study_table import readable_table

HEADINGS = {
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
    text=EXPLANATION,
    measure=start_up_table,
    table=partial(readable_table, headings=HEADINGS),
    long_form=LongForm(parts, stored),
    compared=True,
    timed=True,
)

"""The sections on what runs cost: from nothing, of a brownout cloud, and on other processors."""

from __future__ import annotations

from functools import partial

import pandas as pd

from benchmarks.applications.brownout import cost
from benchmarks.applications.processors import study as processors
from benchmarks.store.provenance import version
from benchmarks.store.row_files import of_one_version
from benchmarks.studies import start_up
from reports.results.section import LongForm, Section, long_form_only
from reports.tables.number_format import readable
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


def processors_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each case, a column for each processor; of this version, or else the newest."""
    rows = of_one_version(frame, version())
    lines: dict[str, dict[str, str]] = {}
    for row in rows.to_dict("records"):
        line = lines.setdefault(row["case"], {"run": row["case"]})
        line[row["processor"]] = row["status"] or readable(row["units"])
    names = [name for name in dict.fromkeys(rows["processor"]) if name != processors.HOST]
    table = pd.DataFrame(lines.values(), columns=["run", *names]).fillna("")
    return table, dict.fromkeys(names, "number")


PROCESSORS = Section(
    name="processors",
    title="The same runs on other processors",
    text="A hundred steps in each kernel, compiled for other processors, with their instructions "
    "alone and the BLAS that goes with them: the largest difference of the last state from that of "
    "this machine's own, in units in the last place of the largest coordinate, or momentum. "
    "Vectors of 8, 4 or 2 numbers and fused products round differently, so that results agree to "
    "rounding, which grows as the motion lets it; success and status must be the same. On one kind "
    "of processor all bits are the same, in every process and thread.",
    measure=long_form_only,
    table=processors_table,
    long_form=LongForm(processors.parts, processors.stored),
)

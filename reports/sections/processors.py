"""The section on processors: how far results differ from one to another."""

from __future__ import annotations

import pandas as pd

from benchmarks.applications.processors import study
from benchmarks.store.provenance import version
from benchmarks.store.row_files import of_one_version
from reports.results.section import LongForm, Section, long_form_only
from reports.tables.number_format import readable


def processors_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each case, a column for each processor; of this version, or else the newest."""
    rows = of_one_version(frame, version())
    lines: dict[str, dict[str, str]] = {}
    for row in rows.to_dict("records"):
        line = lines.setdefault(row["case"], {"run": row["case"]})
        line[row["processor"]] = row["status"] or readable(row["units"])
    names = [name for name in dict.fromkeys(rows["processor"]) if name != study.HOST]
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
    long_form=LongForm(study.parts, study.stored),
)

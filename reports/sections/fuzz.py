"""The section on calls at random: what returned, what was refused, and what must not happen."""

from __future__ import annotations

import pandas as pd

from benchmarks.applications.fuzzing import study
from benchmarks.store.provenance import version
from benchmarks.store.row_files import of_one_version
from reports.results.section import LongForm, Section, long_form_only


def fuzz_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each target, the sum, and one for each finding; of this or the newest version."""
    rows = of_one_version(frame, version())
    counts = rows.groupby("target", sort=False)[["calls", "returned", "refused"]].sum()
    found = rows[rows["finding"] != ""].drop_duplicates(["target", "finding"])
    counts["findings"] = found.groupby("target").size().reindex(counts.index, fill_value=0)
    counts.loc["all"] = counts.sum()
    lines = counts.reset_index().astype(str).to_dict("records")
    lines += [
        {"target": f"{row.target}: {row.finding}: {row.example}"} for row in found.itertuples()
    ]
    columns = ["target", "calls", "returned", "refused", "findings"]
    return pd.DataFrame(lines, columns=columns).fillna(""), dict.fromkeys(columns[1:], "number")


FUZZ = Section(
    name="fuzz",
    title="How good the refusals are: calls at random",
    text="Public functions with one or two odd arguments out of good ones (numbers of any kind and "
    "size, arrays of other shapes and types, objects), problems and methods drawn at random, "
    "and saved runs, archives of REBOUND's and models of MuJoCo's with bits changed or cut "
    "short. A call must return something finite and, for a run called good, of constant "
    "energy, or be refused by galvi itself in one sentence. Anything else is a finding: "
    "another exception or a warning, a crash, a hang, a run that is loaded and is not what "
    "was saved, a file left behind. `make fuzz` calls for ten minutes, `make studies` a "
    "million times.",
    measure=long_form_only,
    table=fuzz_table,
    long_form=LongForm(study.parts, study.stored),
)

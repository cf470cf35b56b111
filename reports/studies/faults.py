"""The section on how faults are found: mutants of the sources."""

from __future__ import annotations

from pathlib import PurePosixPath

import pandas as pd

from benchmarks.applications.mutation import study as mutation
from benchmarks.applications.mutation.trial import KILLED
from reports.results.section import LongForm, Section, long_form_only


def mutants_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each folder, and one for each sample; then the mutants that no test found."""
    same = mutation.equivalents()
    changed = [tuple(row) for row in frame[["file", "before", "after"]].itertuples(index=False)]
    rows = frame.assign(
        folder=["/".join(PurePosixPath(file).parent.parts[:2]) for file in frame["file"]],
        equivalent=[change in same for change in changed],
    )
    lines = []
    for sample, of_sample in rows.groupby("sample", sort=False):
        lines += [_line(f"{folder}/", table) for folder, table in of_sample.groupby("folder")]
        lines.append(_line(f"all: {sample}", of_sample))
        commits = of_sample[of_sample["outcome"] == KILLED]["commit"].value_counts()
        at = ", ".join(f"{commit} ({count})" for commit, count in commits.items())
        lines += [{"where": f"found at: {sample}", "found": at}] if at else []
    for row in rows[(rows["outcome"] != KILLED) & ~rows["equivalent"]].to_dict("records"):
        what = f"{row['file']}:{row['line']}: {row['before']}  ->  {row['after']}"
        lines.append({"where": what, "found": row["outcome"]})
    columns = ["where", "mutants", "equivalent", "found"]
    return pd.DataFrame(lines, columns=columns).fillna(""), dict.fromkeys(columns[1:], "number")


def _line(where: str, rows: pd.DataFrame) -> dict[str, str]:
    counted = rows[~rows["equivalent"]]
    killed = int((counted["outcome"] == KILLED).sum())
    share = f" ({killed / len(counted):.0%})" if len(counted) else ""
    return {
        "where": where,
        "mutants": str(len(rows)),
        "equivalent": str(int(rows["equivalent"].sum())),
        "found": f"{killed}{share}",
    }


MUTANTS = Section(
    name="mutants",
    title="How good the tests are: mutants",
    text="Small faults, planted one at a time by the operators of cosmic-ray: a sum for a "
    "difference, a limit moved by one, a condition reversed. A seed draws them, each folder by its "
    "lines of code. The tests that reach the line run, the quickest first, until one fails: the "
    "fault is found. Equivalent mutants compute the same and are not tried; their reasons are in "
    "benchmarks/applications/mutation/equivalent.csv. References whose engine is not installed are "
    "left out. "
    "Below, those that no test found. `make mutants` tries what is missing, and what survived "
    "again when the tests change; a fault once found is not tried again, so that it is known to be "
    "found by the tests of the commit it was found at.",
    measure=long_form_only,
    table=mutants_table,
    long_form=LongForm(mutation.parts, mutation.stored),
)

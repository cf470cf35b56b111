"""The sections on how faults are found: calls at random, and mutants of the sources."""

from __future__ import annotations

from pathlib import PurePosixPath

import pandas as pd

from benchmarks.applications.fuzzing import study as fuzzing
from benchmarks.applications.mutation import study as mutation
from benchmarks.applications.mutation.trial import KILLED
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
    long_form=LongForm(fuzzing.parts, fuzzing.stored),
)


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

"""`tolerance`: the bounds that a regression test of a user's own run should have."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.applications.releases.own_run import read_own_run
from benchmarks.applications.releases.requirements import RANGE, requested_releases
from benchmarks.applications.releases.tolerance import Tolerance, measure
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from benchmarks.store.provenance import provenance
from galvi.interop.judge import JudgeRequest
from reports.cli.handed_over import show_progress
from reports.judge.files import plain
from reports.tables.tolerance import (
    bounds_table,
    contents,
    lines_to_paste,
    sentences,
    write_tolerance,
)
from reports.tables.writing import as_markdown

COMMAND = "tolerance"
REFUSALS = (
    ValueError,
    TypeError,
    FileNotFoundError,
    ImportError,
    RuntimeError,
    EnvironmentUnavailable,
)
progress = partial(show_progress, COMMAND)


def tolerance_of(file: Path, request: JudgeRequest, texts: Sequence[str], out: Path) -> Tolerance:
    """Measure the tolerance of a file's run. Raises REFUSALS if that cannot be carried out."""
    run = read_own_run(file, request)
    releases, is_range = requested_releases(run.package, texts) if texts else ([], False)
    if is_range:
        raise ValueError(
            f"--releases of tolerance expects a list as 3.17.0,4.0.1; received the range "
            f"{RANGE.join(releases)}, which is for `galvi versions`."
        )
    tolerance = measure(run, releases, out, progress)
    progress("")
    return tolerance


def report_tolerance(tolerance: Tolerance, file: str, out: Path, command: str) -> int:
    """Write tables and tolerance.json, and print sentences.

    Parameters
    ----------
    command
        the command line as typed

    Returns
    -------
    int
        The exit status: 0 if there are bounds at the end that hold for every release that was
        named, else 1.
    """
    facts, summary = provenance(command), list(sentences(tolerance))
    values = {"model": file, **contents(tolerance), "summary": summary, "provenance": facts}
    files = write_tolerance(tolerance, out, facts)
    files.append(write(out / f"{COMMAND}.json", json.dumps(plain(values), indent=1) + "\n"))
    for sentence in summary:
        print(visible(sentence))
    print(f"\n{as_markdown(bounds_table(tolerance))}")
    for line in lines_to_paste(tolerance):
        print(line)
    print(f"Written: {', '.join(map(str, files))}.")
    return int(not tolerance.holds)

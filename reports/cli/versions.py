"""`versions`: between which releases of its engine a user's own run changed."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import partial
from pathlib import Path

from benchmarks.applications.releases.own_run import read_own_run
from benchmarks.applications.releases.requirements import requested_releases
from benchmarks.applications.releases.versions import Versions, compare_releases
from benchmarks.store.atomic import write
from benchmarks.store.foreign_texts import visible
from benchmarks.store.isolated_environment import EnvironmentUnavailable
from benchmarks.store.provenance import provenance
from galvi.interop.judge import JudgeRequest
from reports.cli.handed_over import show_progress
from reports.judge.files import plain
from reports.tables.versions import changes, label, rows, sentences, truth_facts, write_versions

COMMAND = "versions"
REFUSALS = (
    ValueError,
    TypeError,
    FileNotFoundError,
    ImportError,
    RuntimeError,
    EnvironmentUnavailable,
)
progress = partial(show_progress, COMMAND)


def versions_of(file: Path, request: JudgeRequest, texts: Sequence[str], out: Path) -> Versions:
    """Compare a file's run in the requested releases. Raises REFUSALS if that cannot be carried
    out."""
    run = read_own_run(file, request)
    releases, is_range = requested_releases(run.package, texts)
    versions = compare_releases(run, releases, is_range, out, progress)
    progress("")
    return versions


def report_versions(versions: Versions, file: str, out: Path, command: str) -> int:
    """Write the table and versions.json, and print sentences; returns 0, even if a result changed.

    Parameters
    ----------
    command
        the command line as typed
    """
    facts, run = provenance(command), versions.run
    summary = list(sentences(versions))
    contents = {
        "model": file,
        "engine": run.package,
        "integrator": label(run),
        "step": run.step,
        "duration": run.duration,
        "summary": summary,
        "changes": changes(versions),
        "truth": truth_facts(versions),
        "releases": rows(versions),
        "provenance": facts,
    }
    files = write_versions(versions, out, facts)
    files.append(write(out / f"{COMMAND}.json", json.dumps(plain(contents), indent=1) + "\n"))
    for sentence in summary:
        print(visible(sentence))
    print(f"Table: {', '.join(map(str, files))}.")
    return 0

"""`track`: the benchmark history; with `--against`, a comparison with a revision."""

from __future__ import annotations

import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack
from pathlib import Path

import typer

from benchmarks.applications.external.loading import ContenderError
from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT
from benchmarks.timings.case import Case, Thresholds
from benchmarks.timings.catalogue import CASES
from references.setting import nearest
from reports.results.junit import github_annotations
from reports.results.metrics import write_metrics
from reports.results.progress import Studies
from reports.results.summary import write_job_summary
from reports.tracking.against import compare
from reports.tracking.benches import store_bench
from reports.tracking.checkouts import (
    CannotCompare,
    Checkout,
    checkouts,
    isolated,
    project_checkouts,
)
from reports.tracking.head_metrics import head_metrics
from reports.tracking.junit_cases import as_junit, junit_cases
from reports.tracking.outcome import as_json, summary
from reports.tracking.record import STORE
from reports.tracking.tracked_problems import contender_cases
from reports.tracking.worker import ANSWER_SECONDS, CONTENDER_SECONDS

THRESHOLDS = Thresholds()


def track_command(
    out: Path,
    provenance: Mapping[str, str],
    against: str,
    only: Sequence[str],
    quick: bool,
    isolate: bool,
    contenders: Sequence[str] = (),
    timeout: float | None = None,
    thresholds: Thresholds = THRESHOLDS,
) -> int:
    """Compare with a revision; returns 1 if worse, 2 if not comparable.

    Parameters
    ----------
    contenders
        integrators of the repository that the current folder is in, to compare in place of galvi
    timeout
        seconds for each answer of a side; None for the default
    thresholds
        increases of a contender's time and error that count as worse

    Notes
    -----
    Raises typer.BadParameter for incompatible options and for an unknown benchmark.
    """
    if not against.strip():
        raise typer.BadParameter(
            "--against expects a commit, a branch or a tag; received nothing: is a variable empty?"
        )
    if thresholds != THRESHOLDS and not contenders:
        raise typer.BadParameter("--slower and --less-accurate are for a --contender.")
    if contenders and (only or isolate):
        raise typer.BadParameter("--only and --isolate are not for a --contender.")
    answer_seconds = timeout or (CONTENDER_SECONDS if contenders else ANSWER_SECONDS)
    try:
        if contenders:
            sides = project_checkouts(against, Path.cwd())
            cases = contender_cases(contenders, answer_seconds, thresholds)
        else:
            sides, cases = checkouts(against, ROOT), choose_cases(only, quick)
        return track_against(sides, cases, out, provenance, isolate, answer_seconds)
    except ContenderError as error:
        raise typer.BadParameter(f"--contender: {error}") from None
    except CannotCompare as error:
        print(error, file=sys.stderr)
        return 2


def choose_cases(only: Sequence[str], quick: bool) -> tuple[Case, ...]:
    """The benchmarks whose names contain one of the texts, in any case.

    Without texts, the quick benchmarks if `quick`, else all. Raises typer.BadParameter for a text
    that no name contains.
    """
    for text in only:
        if not any(text.lower() in case.name.lower() for case in CASES):
            raise typer.BadParameter(
                f"there is no benchmark with {text!r} in its name; "
                f"did you mean {nearest(text, [case.name for case in CASES])!r}?"
            )
    if not only:
        return tuple(case for case in CASES if case.quick or not quick)
    return tuple(case for case in CASES if any(text.lower() in case.name.lower() for text in only))


def track_against(
    sides: AbstractContextManager[tuple[Checkout, Checkout]],
    cases: Sequence[Case],
    out: Path,
    provenance: Mapping[str, str],
    isolate: bool,
    limit: float = ANSWER_SECONDS,
) -> int:
    """Compare the working tree with a revision; print the outcome, and write against.md,
    against.json, track.xml, track-*.json and, where the yardstick was timed, a bench for the
    history.

    Parameters
    ----------
    both
        a context that yields base and head
    limit
        seconds for each answer of a side

    Returns
    -------
    int
        The exit status: 1 if something got worse, else 0.

    Raises
    ------
    CannotCompare
        If no benchmark could be compared, unless all integrators are new.
    """
    with ExitStack() as stack:
        # SIGTERM acts as an interrupt, so that folders and processes are cleaned up.
        previous_handler = signal.signal(signal.SIGTERM, signal.default_int_handler)
        stack.callback(signal.signal, signal.SIGTERM, previous_handler)
        base, head = stack.enter_context(sides)
        if isolate:
            base, head = isolated(base), isolated(head)
        outcome = compare(base, head, cases, stack.enter_context(Studies(3)), limit)
    text, cases = summary(outcome, provenance), junit_cases(outcome)
    write(out / "against.json", as_json(outcome, provenance))
    write(out / "track.xml", as_junit(outcome, cases, "galvi track"))
    write_metrics(out, "track", head_metrics(outcome))
    write(out / "against.md", text)
    write_job_summary(text)
    store_bench(outcome, head, out / STORE)
    print(outcome.report(), outcome, *github_annotations(cases), sep="\n")
    all_new = all(finding.pair.case.contender in outcome.new for finding in outcome.findings)
    if not outcome.compared and not all_new:
        raise CannotCompare("Nothing could be compared: no benchmark runs on both sides.")
    return int(outcome.has_alarms)

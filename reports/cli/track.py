"""`track`: the benchmark history; with `--against`, a comparison with a revision."""

from __future__ import annotations

import signal
import sys
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager, ExitStack, nullcontext
from pathlib import Path

import typer

from benchmarks.applications.external.loading import ContenderError
from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT
from benchmarks.timings.case import Case, Thresholds
from benchmarks.timings.catalogue import CASES
from references.setting import nearest
from reports.results.progress import Studies
from reports.results.summary import write_job_summary
from reports.tracking.against import compare
from reports.tracking.bench_record import keep_bench
from reports.tracking.outcome import as_json, as_junit, summary
from reports.tracking.project import (
    CannotCompare,
    Checkout,
    absent,
    checkouts,
    contender_cases,
    isolated,
    project_checkouts,
)
from reports.tracking.record import STORE, track
from reports.tracking.worker import CONTENDER_SECONDS, SECONDS

XML = "track.xml"
THRESHOLDS = Thresholds()
Sides = AbstractContextManager[tuple[Checkout, Checkout]]


def track_command(
    out: Path,
    provenance: Mapping[str, str],
    against: str | None,
    only: Sequence[str],
    quick: bool,
    isolate: bool,
    contenders: Sequence[str] = (),
    timeout: float | None = None,
    thresholds: Thresholds = THRESHOLDS,
) -> int:
    """Show the history, or compare with a revision; returns 1 if worse, 2 if not comparable.

    contenders  integrators of the repository that the current folder is in, to compare in place of
                galvi
    timeout     seconds for each answer of a side; None for the default
    thresholds  what counts as worse in the contenders

    Raises typer.BadParameter for incompatible options and for an unknown benchmark.
    """
    if against is None:
        if only or isolate or contenders:
            raise typer.BadParameter("--only, --isolate and --contender require --against REV.")
        return track(out, provenance)
    if not against.strip():
        raise typer.BadParameter(
            "--against expects a commit, a branch or a tag; received nothing: is a variable empty?"
        )
    if thresholds != THRESHOLDS and not contenders:
        raise typer.BadParameter("--slower and --less-accurate are for a --contender.")
    try:
        if contenders:
            if only or isolate:
                raise typer.BadParameter("--only and --isolate are not for a --contender.")
            return track_project(
                project_checkouts(against, Path.cwd()),
                contenders,
                out,
                provenance,
                CONTENDER_SECONDS if timeout is None else timeout,
                thresholds,
            )
        return track_against(
            checkouts(against, ROOT),
            choose_cases(only, quick),
            out,
            provenance,
            isolate,
            SECONDS if timeout is None else timeout,
        )
    except ContenderError as error:
        raise typer.BadParameter(f"--contender: {error}") from None
    except CannotCompare as error:
        print(error, file=sys.stderr)
        return 2


def track_project(
    both: Sides,
    contenders: Sequence[str],
    out: Path,
    provenance: Mapping[str, str],
    limit: float = CONTENDER_SECONDS,
    thresholds: Thresholds = THRESHOLDS,
) -> int:
    """As `track_against` for a repository's integrators; those that the base has not are new."""
    with both as sides:
        cases = contender_cases(contenders, limit, thresholds)
        new = absent(sides[0], contenders, limit)
        said = [f"{path} is new: {sides[0].name} has nothing to compare it with." for path in new]
        for sentence in said:
            print(sentence)
        known = tuple(case for case in cases if case.contender not in new)
        if not known:
            for name in ("against.json", XML):
                (out / name).unlink(missing_ok=True)
            write(out / "against.md", "\n".join(said) + "\n")
            write_job_summary("\n".join(said) + "\n")
            return 0
        return track_against(nullcontext(sides), known, out, provenance, False, limit)


def choose_cases(only: Sequence[str], quick: bool) -> tuple[Case, ...]:
    """Benchmarks whose name contains one of the texts; without texts, the quick ones or all."""
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
    both: Sides,
    cases: Sequence[Case],
    out: Path,
    provenance: Mapping[str, str],
    isolate: bool,
    limit: float = SECONDS,
) -> int:
    """Compare the working tree with a revision; print, and write against.md, against.json,
    track.xml and, of another project's integrators, a bench for the history.

    both   a context of base and head
    limit  seconds for each answer of a side

    Returns 0 when nothing got worse, 1 when something did. Raises CannotCompare.
    """
    with ExitStack() as stack:
        # SIGTERM acts as an interrupt, so that folders and processes are cleaned up.
        before = signal.signal(signal.SIGTERM, signal.default_int_handler)
        stack.callback(signal.signal, signal.SIGTERM, before)
        sides = stack.enter_context(both)
        base, head = map(isolated, sides) if isolate else sides
        outcome = compare(base, head, cases, stack.enter_context(Studies(4)), limit)
    write(out / "against.json", as_json(outcome, provenance))
    write(out / XML, as_junit(outcome, "galvi track"))
    keep_bench(outcome, head, out / STORE)
    text = summary(outcome, provenance)
    write(out / "against.md", text)
    write_job_summary(text)
    print(outcome.report(), outcome, sep="\n")
    if any(finding.compared for finding in outcome.findings):
        return int(outcome.red)
    if all(one.pair.case.contender and set(one.pair.why) == {"base"} for one in outcome.findings):
        return 0  # the head mends what the base could not run
    raise CannotCompare("Nothing could be compared: no benchmark runs on both sides.")

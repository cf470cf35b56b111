"""`track --against REV`: base and head in one job, and whether the head got worse."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.statistics.rank_test import samples_needed
from benchmarks.store.atomic import write
from benchmarks.store.provenance import ROOT
from benchmarks.timings.case import ROUND_OFF, Case
from benchmarks.timings.truth import Unknown, true_ends
from reports.results.job_summary import write_job_summary
from reports.results.progress import Studies
from reports.tracking.gates import judge, suspects
from reports.tracking.rounds import Pair, Told, prepare, take_turns
from reports.tracking.separate import interpreters
from reports.tracking.side import Side
from reports.tracking.trees import CannotCompare, Tree, two_trees
from reports.tracking.verdict import Verdict, as_json, as_markdown, show

NAMES = ("base", "head")
SAMPLES = 14  # a side at least: two that a busy machine spoils do not hide a slower head


@dataclass(frozen=True)
class Places:
    """Of the two trees that are compared, with the interpreters to run them."""

    base: Tree
    head: Tree
    interpreters: tuple[str, str] = (sys.executable, sys.executable)


def track_against(
    revision: str, cases: Sequence[Case], out: Path, provenance: dict[str, str], isolate: bool
) -> int:
    """Compare the working tree with a revision; prints, and writes against.md and against.json.

    Returns 0 when nothing got worse, 1 when something did. Raises CannotCompare.
    """
    with ended_gently(), two_trees(revision, ROOT) as (base, head):
        places = Places(base, head, *([interpreters(base, head)] if isolate else []))
        with Studies(3) as studies:
            verdict, pairs = compare(places, cases, studies)
    write(out / "against.json", as_json(verdict, pairs, provenance))
    text = as_markdown(verdict, provenance)
    write(out / "against.md", text)
    write_job_summary(text)
    show(verdict)
    if not any(finding.compared for finding in verdict.findings):
        raise CannotCompare("Nothing could be compared: no benchmark runs on both sides.")
    return int(bool(verdict.worse))


def compare(places: Places, cases: Sequence[Case], studies: Any) -> tuple[Verdict, list[Pair]]:
    """First calls and a round of samples of all cases; a second round, in new processes, of those
    that look slower. New ones lie elsewhere in memory, which alone can cost some percent.

    studies  (name, title) -> a context that hands out a report
    """
    with studies("track", "truths") as report:
        truths = {case.name: _truth(case, report) for case in cases}
    timed = sum(case.kind != ROUND_OFF for case in cases)
    with studies("track", "first round") as report, both(places) as sides:
        pairs = prepare(sides, cases, report)
        take_turns(sides, pairs, max(SAMPLES, samples_needed(timed)), report)
    slow = suspects(pairs)
    confirmed: set[str] = set()
    with studies("track", "second round") as report:
        if slow:
            confirmed = _again(places, [p for p in pairs if p.case.name in slow], report)
    findings = judge(pairs, truths, confirmed)
    return Verdict(places.base.name, places.head.name, tuple(findings)), pairs


def _again(places: Places, pairs: Sequence[Pair], report: Told) -> set[str]:
    """Cases that are slower in new processes too; samples and failures join the first round's."""
    with both(places) as sides:
        fresh = prepare(sides, [pair.case for pair in pairs], report)
        take_turns(sides, fresh, max(SAMPLES, samples_needed(len(fresh))), report)
    for pair, again in zip(pairs, fresh, strict=True):
        pair.samples += again.samples
        pair.walls += again.walls
        pair.why |= again.why
    return suspects(fresh)


@contextmanager
def both(places: Places) -> Iterator[dict[str, Side]]:
    """The two processes."""
    trees = (places.base, places.head)
    with ExitStack() as stack:
        yield {
            name: stack.enter_context(Side(tree.folder, interpreter))
            for name, tree, interpreter in zip(NAMES, trees, places.interpreters, strict=True)
        }


@contextmanager
def ended_gently() -> Iterator[None]:
    """A request to end is an interrupt here, so that folders and processes are removed."""

    def interrupt(*_: object) -> None:
        raise KeyboardInterrupt

    try:
        before: Callable[..., Any] | int | None = signal.signal(signal.SIGTERM, interrupt)
    except ValueError:  # not in the main thread, where signals do not arrive
        yield
        return
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _truth(case: Case, report: Told) -> Sequence[Any] | str:
    report(case.name)
    try:
        return true_ends(case)
    except Unknown as error:
        return str(error)
    except Exception as error:
        return f"{type(error).__name__}: {' '.join(str(error).split())}"

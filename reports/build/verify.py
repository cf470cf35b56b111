"""The command verify: claims against their expected verdicts, told to people and to CI."""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import pandas as pd

from benchmarks.checks.claim import Claim, Row
from benchmarks.checks.coverage import coverage
from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.build.changes import Change, changes
from reports.build.check_session import CheckSession, kind_of
from reports.build.kept import CLAIMS, DURATIONS, durations
from reports.build.terminal import show, show_changes, show_engines
from reports.build.workers import study_in_workers
from reports.figures.catalogue.all import FIGURES
from reports.results.cache import BuildCache
from reports.results.claim_results import NOT_RUN, ClaimResult, Elsewhere, Finished, check
from reports.results.comparison import marked, merged, written
from reports.results.junit import JUnitCase, Outcome, github_annotations
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.own_problems import Engines
from reports.results.suite import Suite
from reports.results.summary import Summary, summary, write_job_summary
from reports.tables.claims_table import READ, claims_frame, convergence_frame
from reports.tables.number_format import plain
from reports.tables.writing import as_markdown, write_table


def cases_of(result: ClaimResult) -> list[JUnitCase]:
    """A case for each row of a claim.

    failure  a verdict other than the expected one
    error    a row that should have been measured but was not
    skipped  a row that was expected not to run
    """
    return [_case(row, result.seconds / len(result.rows)) for row in result.rows]


def further_cases(engines: Engines, results: Sequence[ClaimResult]) -> list[JUnitCase]:
    """Cases of the optional engines, of which an absent one fails where it is required, of printed
    statements that the rows do not support, and of what else makes `verify` fail."""
    seen = summary(results)
    wrong = [("printed statement", sentence) for sentence in seen.unfounded]
    covered = coverage(seen.rows)
    if not covered.sound:
        wrong.append(("stated errors of orders", str(covered)))
    if all(row.verdict == NOT_RUN for row in seen.rows):
        wrong.append(("measured rows", "nothing was measured"))
    return [_engine(name, engines) for name in engines.absence] + [
        JUnitCase("statements", name, 0.0, "failure", sentence) for name, sentence in wrong
    ]


def properties(row: Row) -> tuple[tuple[str, str], ...]:
    """What a reader of a check's outcome wants to know, by name."""
    measured = plain(row.measured, 6) or "nothing"
    error = plain(row.uncertainty, 2)
    return (
        ("measured", f"{measured}{f' -+ {error}' if error else ''}"),
        ("bound", row.bound or "none"),
        ("verdict", row.verdict),
        ("expected", row.expected or "a verdict"),
        ("source", row.source),
        ("claimed", row.claimed),
        ("setup", row.setup),
        ("reference", row.reference),
        ("reason", row.reason),
    )


def _case(row: Row, seconds: float) -> JUnitCase:
    outcome, message = _outcome(row)
    group = f"{kind_of(row.source)}.{row.id}"
    return JUnitCase(group, row.quantity, seconds, outcome, message, properties=properties(row))


def _outcome(row: Row) -> tuple[Outcome, str]:
    """The outcome of a row's test, and a sentence on it."""
    if row.verdict == NOT_RUN:
        return "skipped" if row.expected == NOT_RUN else "error", f"not run: {row.reason}"
    if row.verdict == row.expected:
        return "passed", ""
    measured = plain(row.measured, 6)
    return "failure", (
        f"{row.verdict}, expected was {row.expected}: measured {measured}, bound {row.bound}"
    )


def _engine(name: str, engines: Engines) -> JUnitCase:
    why = engines.absence[name]
    if not why:
        return JUnitCase("engines", name)
    outcome: Outcome = "failure" if name in engines.required else "skipped"
    return JUnitCase("engines", name, 0.0, outcome, f"{name} is absent: {why}")


HEADINGS = ("claim", "quantity", "bound", "measured", "uncertainty", "verdict", "expected")


def markdown(found: Verified) -> str:
    """Passed or failed, unexpected verdicts, changes, and all rows in a collapsed section."""
    seen, changed, engines = found.summary, found.changed, found.engines
    parts = [f"## verify: {'passed' if found.passed else 'failed'}", str(seen)]
    parts += filter(None, [share_sentence(found)])
    parts += [f"- {sentence}" for sentence in engines.sentences()]
    if seen.differing:
        parts += ["### Not as expected", _table(_lines(seen.differing, reason=True))]
    if changed:
        moved = [
            {"claim": c.id, "quantity": c.quantity, "what": c.what, "before": c.before,
             "now": c.now}
            for c in changed
        ]  # fmt: skip
        parts += ["### Changed since the rows before", _table(moved)]
    folded = _table(_lines(seen.rows))
    parts += [f"<details><summary>All {len(seen.rows)} checks</summary>\n\n{folded}\n\n</details>"]
    return "\n\n".join(parts) + "\n"


def share_sentence(found: Verified) -> str:
    """How many checks came out as expected, where fewer than all are enough; else ""."""
    if found.fail_under == 100.0:
        return ""
    return (
        f"{found.summary.share:.4g} % of the checks came out as expected; --fail-under asks for "
        f"{found.fail_under:.4g} %."
    )


def _lines(rows: Sequence[Row], reason: bool = False) -> list[dict[str, str]]:
    lines = []
    for row in rows:
        cells = (row.id, row.quantity, row.bound, plain(row.measured) or "-",
                 plain(row.uncertainty, 2), row.verdict, row.expected)  # fmt: skip
        line = dict(zip(HEADINGS, cells, strict=True))
        lines.append({**line, "reason": row.reason} if reason else line)
    return lines


def _table(lines: Sequence[dict[str, str]]) -> str:
    return as_markdown(pd.DataFrame(lines)).rstrip("\n")


# `verify`: check the claims and agreements; write and print the verdicts.
#
# claims.csv    every row; rows of claims that were not selected are kept, with their dates
# durations.csv seconds that the study of each claim took
# verify.xml    JUnit XML for CI services
# verify.md     the same in Markdown; also appended to the CI job summary
# frames/       the studies' frames
# tables/       claims and convergence


@dataclass(frozen=True, eq=False)
class Verified:
    """The result of `verify`.

    changed     differences from the previous rows
    fail_under  percent of the checks that must come out as expected
    """

    checked: tuple[ClaimResult, ...]
    engines: Engines
    changed: tuple[Change, ...]
    fail_under: float = 100.0

    @property
    def summary(self) -> Summary:
        """The summary of all rows."""
        return summary(self.checked)

    @property
    def passed(self) -> bool:
        """Whether enough verdicts are the expected ones, and every required engine is there."""
        return self.summary.passes(self.fail_under) and not self.engines.wanting


def verify(
    suite: Suite,
    options: Options,
    cache: BuildCache | None = None,
    beside: Sequence[str] = (),
) -> Verified:
    """Check the selected claims, or all; write, print and return the results.

    cache   the build's result cache; None stores nothing
    beside  titles of sections to measure for the build as well

    Claims and sections without timings run in two processes, or where the suite says.
    """
    cache = cache or BuildCache()
    chosen = [claim for claim in suite.claims if not options.claims or claim.id in options.claims]
    engines = Engines(suite.engines(), options.require)

    def measured(claims: Sequence[Claim]) -> Sequence[ClaimResult]:
        elsewhere = _in_workers(suite, options.quick, cache, beside)
        return check(claims, suite.make_method, options.quick, cache, elsewhere)

    session = CheckSession(chosen, measured, cases_of, partial(further_cases, engines))
    session.run(options.out, f"{options.called} verify", options.checks)
    checked = session.measured
    changed = tuple(_write(checked, suite, options))
    found = Verified(tuple(checked), engines, changed, options.fail_under)
    text = markdown(found)
    write(options.out / "verify.md", text)
    write_job_summary(text)
    show(found.summary)
    show_changes(found.changed)
    show_engines(engines)
    lines = [share_sentence(found), *([] if found.passed else github_annotations(session.judged))]
    print("".join(f"{line}\n" for line in lines if line), end="")
    return found


def _in_workers(suite: Suite, quick: bool, cache: BuildCache, beside: Sequence[str]) -> Elsewhere:
    def study(names: Sequence[str]) -> Generator[Finished, None, None]:
        wanted = (*names, *(title for title in beside if title not in cache.taken))
        known = {name: suite.in_workers[name] for name in wanted if name in suite.in_workers}
        for name, frame, seconds in (suite.runner or study_in_workers)(known, quick):
            if name in beside:
                cache.ready[name] = cache.keep(name, frame, seconds)
            else:
                yield name, frame, seconds

    return study


def _write(checked: Sequence[ClaimResult], suite: Suite, options: Options) -> list[Change]:
    """Write tables and frames; return the changes."""
    rows = [row for one in checked for row in one.rows]
    origin = {
        **suite.provenance(options.command),
        "setting": "quick" if options.quick else "default",
    }
    dates = {one.claim.id: one.run or origin.get("date", "") for one in checked}
    now = marked(_dated(claims_frame(rows), "id", dates), origin)
    before_origin = read_origins(options.out).get(CLAIMS, {})
    before = written(options.out / CLAIMS, "id", before_origin)
    table = _with_kept(before, now, "id", checked, suite)
    write(options.out / CLAIMS, as_csv(table))
    note_origin(options.out, CLAIMS, suite.provenance(options.command), options.quick)
    _note_durations(options, checked)
    tables = options.out / "tables"
    write_table(tables, "claims", table, table[list(READ)], origin)
    rates = marked(_dated(convergence_frame(checked, FIGURES), "claim", dates), origin)
    kept = written(tables / "convergence.csv", "claim", before_origin)
    fits = _with_kept(kept, rates, "claim", checked, suite)
    write_table(tables, "convergence", fits, origin=origin)
    for one in checked:
        path = options.out / "frames" / f"{one.claim.id}.csv"
        if one.frame is None:
            path.unlink(missing_ok=True)
        else:
            write(path, as_csv(one.frame))
    return changes(before, now)


def _note_durations(options: Options, checked: Sequence[ClaimResult]) -> None:
    """Update the seconds of these claims; quick runs are shorter, and say nothing."""
    if options.quick:
        return
    path = options.out / DURATIONS
    times = durations(options.out) | {
        one.claim.id: one.seconds for one in checked if one.frame is not None
    }
    write(path, as_csv(pd.DataFrame(times.items(), columns=["claim", "seconds"])))


def _dated(table: pd.DataFrame, key: str, dates: Mapping[str, str]) -> pd.DataFrame:
    """The table with a date column: when each row's claim was measured."""
    return table.assign(date=[dates[name] for name in table[key]])


def _with_kept(
    before: pd.DataFrame | None, now: pd.DataFrame, key: str, checked: Sequence[ClaimResult],
    suite: Suite,
) -> pd.DataFrame:  # fmt: skip
    known = [claim.id for claim in suite.claims]
    return merged(before, now, key, {one.claim.id for one in checked}, known)

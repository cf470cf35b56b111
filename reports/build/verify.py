"""`verify`: check the claims and agreements; write and print the verdicts.

claims.csv    every row; rows of claims that were not selected are kept, with their dates
durations.csv seconds that the study of each claim took
verify.xml    JUnit XML for CI services
verify.md     the same in Markdown; also appended to the CI job summary
frames/       the studies' frames
tables/       claims and convergence
"""

from __future__ import annotations

from collections.abc import Generator, Mapping, Sequence
from dataclasses import dataclass

import pandas as pd

from benchmarks.store.atomic import write
from reports.build.changes import Change, changes
from reports.build.junit import junit
from reports.build.kept import CLAIMS, DURATIONS, durations
from reports.build.markdown_summary import markdown
from reports.build.terminal import show, show_changes, show_engines
from reports.build.workers import study_in_workers
from reports.figures.catalogue.all import FIGURES
from reports.results.cache import BuildCache
from reports.results.claim_results import ClaimResult, Elsewhere, Finished, check
from reports.results.engines import Engines
from reports.results.job_summary import write_job_summary
from reports.results.kept_rows import marked, merged, written
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.suite import Suite
from reports.results.summary import summary
from reports.tables.claims_table import READ, claims_frame
from reports.tables.convergence_table import convergence_frame
from reports.tables.writing import as_csv, write_table


@dataclass(frozen=True, eq=False)
class Verified:
    """The result of `verify`.

    changed  differences from the previous rows
    """

    checked: tuple[ClaimResult, ...]
    engines: Engines
    changed: tuple[Change, ...]

    @property
    def passed(self) -> bool:
        """Whether every verdict is the expected one, and every required engine is there."""
        return summary(self.checked).as_expected and not self.engines.wanting


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
    checked = check(
        chosen, suite.make_method, options.quick, suite.unavailable(), cache,
        _in_workers(suite, options.quick, cache, beside),
    )  # fmt: skip
    found = Verified(tuple(checked), engines, tuple(_write(checked, suite, options)))
    seen = summary(checked)
    text = markdown(seen, found.changed, engines)
    write(options.out / "verify.xml", junit(checked, engines))
    write(options.out / "verify.md", text)
    write_job_summary(text)
    show(seen)
    show_changes(found.changed)
    show_engines(engines)
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

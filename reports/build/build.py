"""`build`: verify, compare, study, draw, and write the pages."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from benchmarks.store.atomic import write
from reports.build.compare import Compared, compare
from reports.build.first_look import CLAIMS as ALL_CLAIMS
from reports.build.first_look import COMPARISONS, STUDIES, first_look, remembering
from reports.build.kept import CLAIMS, alone, kept_claims, kept_comparison, kept_sections
from reports.build.sections import write_sections
from reports.build.verify import Verified, verify
from reports.build.workers import map_in_workers
from reports.figures.drawing import draw, save
from reports.page.content import Contents, content
from reports.page.site import write_single, write_site
from reports.results.cache import BuildCache, open_cache
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.section_result import SectionResult, measure_sections, runnable
from reports.results.suite import Suite
from reports.tables.comparison_tables import comparison_tables
from reports.tables.macros import bibliography, numbers
from reports.tracking.record import for_page, history

PAGE, TIMES = "index.html", "work_precision.csv"


def build(
    suite: Suite, options: Options, single: bool = False
) -> tuple[Verified, Compared, list[SectionResult]]:
    """Run and write everything; stored rows of long studies are included with their dates.

    An interrupted build of the same sources and settings is resumed: its results are reused, and
    the provenance says so, as it does when sources change during the measurement.

    single  write all pages as one self-contained file, too
    """
    with alone(options.out):
        cache = open_cache(suite, options)
        if cache.taken:
            print(cache.greeting(), flush=True)

        def provenance(command: str) -> dict[str, str]:
            return {**suite.provenance(command), **cache.provenance()}

        try:
            found = _build(replace(suite, provenance=provenance), options, cache, single)
        except KeyboardInterrupt:
            if cache.store is not None:
                print(
                    "Finished results are kept: the same command resumes the build.",
                    file=sys.stderr,
                )
            raise
        cache.forget()
    return found


def build_kept(suite: Suite, options: Options, single: bool = False) -> Path:
    """Figures and pages from the rows that earlier commands wrote; nothing is measured.

    Verdicts are those that were judged then. Raises ValueError when the folder has no rows.
    """
    with alone(options.out):
        checked = kept_claims(options.out, suite.claims)
        compared = kept_comparison(options.out)
        if not checked and compared.work_precision is None:
            raise ValueError(
                f"{options.out} holds no rows yet; run build, verify or compare first."
            )
        sections = kept_sections(options.out, suite.sections)
        origins = read_origins(options.out)
        page = next((origins[name] for name in (CLAIMS, TIMES) if name in origins), {})
        provenance = {name: text for name, text in page.items() if name != "setting"}
        quick = origins.get(TIMES, {}).get("setting") == "quick"
        tables = comparison_tables(compared.work_precision, () if quick else suite.targets)
        report = Contents(
            suite, replace(options, quick=quick), checked, compared, tables, sections, provenance,
            kept=True,
        )  # fmt: skip
        return _pages(report, single)


def _build(
    suite: Suite, options: Options, cache: BuildCache, single: bool
) -> tuple[Verified, Compared, list[SectionResult]]:
    studies = [section.title for section in runnable(suite.sections)]
    pages = partial(_pages, each=remembering(map_in_workers))
    so_far, headlines = partial(_so_far, suite, options, pages), Comparison(None, None)
    part = 0 < len(options.claims) < len(suite.claims)
    if not (options.quick or part or options.contenders or cache.taken):
        checked, headlines = first_look(suite)
        so_far(checked, headlines, left=(ALL_CLAIMS, COMPARISONS, STUDIES))
    verified = verify(suite, options, cache, studies)
    checked = list(verified.checked)
    so_far(checked, headlines, left=(COMPARISONS, STUDIES))
    compared = compare(suite, options, cache)
    so_far(checked, compared.measured, left=(STUDIES,))
    sections = measure_sections(suite, options, suite.sections, cache)
    write_sections(sections, suite, options)
    cache.look()
    provenance = suite.provenance(options.command)
    note_origin(options.out, PAGE, provenance, options.quick)
    report = Contents(
        suite, options, checked, compared.measured, compared.tables, sections, provenance
    )
    pages(report, single)
    if cache.edited:
        print(f"Changed: {cache.provenance()['changed']}.", file=sys.stderr)
    return verified, compared, sections


def _so_far(
    suite: Suite,
    options: Options,
    pages: Callable[[Contents], Path],
    checked: list[ClaimResult],
    comparison: Comparison,
    left: tuple[str, ...],
) -> None:
    """The pages of a build that goes on, unless it is a quick one."""
    if not options.quick:
        tables = comparison_tables(comparison.work_precision, suite.targets)
        provenance = suite.provenance(options.command)
        pages(Contents(suite, options, checked, comparison, tables, [], provenance, left=left))


def _pages(
    report: Contents,
    single: bool = False,
    each: Callable[..., Iterable[Any]] = map_in_workers,
) -> Path:
    out, left = report.options.out, report.left
    gallery = draw(report.checked, report.comparison, report.sections, each)
    save(gallery, out / "figures")
    page = content(report, gallery, for_page(history(out)))
    write(out / "cite.bib", bibliography())
    if report.checked and not left:
        write(out / "tables" / "numbers.tex", numbers(out))
    first = write_site(page, out)
    print(f"{'Still to come: ' + ', '.join(left) + '. ' if left else ''}The page is {first}.")
    if single:
        print(f"All of it in one file: {write_single(page, out)}.")
    return first

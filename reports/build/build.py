"""`build`: verify, compare, study, draw, and write the site."""

from __future__ import annotations

import sys
from collections.abc import Callable, Iterable, Sequence
from dataclasses import replace
from typing import Any

from benchmarks.store.atomic import write
from reports.build.compare import compare
from reports.build.first_look import CLAIMS as ALL_CLAIMS
from reports.build.first_look import COMPARISONS, STUDIES, first_look, remembering
from reports.build.kept import CLAIMS_FILE, kept_claims, kept_comparison, kept_sections, locked
from reports.build.sections import study
from reports.build.verify import Verified, verify
from reports.build.workers import map_in_workers
from reports.figures.drawing import draw, save
from reports.results.cache import BuildCache, open_cache
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.section_result import (
    SectionResult,
    runnable,
    section_studies,
)
from reports.results.suite import Suite
from reports.site.build import SiteBuilder, write_single
from reports.site.report import TIMES, Report
from reports.tables.macros import bibliography, numbers
from reports.tracking.record import history

PAGE = "index.html"
MapFigures = Callable[..., Iterable[Any]]  # map, or its equivalent in several processes


def build(
    suite: Suite, options: Options, single: bool = False
) -> tuple[Verified, Comparison, list[SectionResult]]:
    """Run and write everything; stored rows of long studies are included with their dates.

    An interrupted build of the same sources and settings is resumed: its results are reused, and
    the provenance says so, as it does when sources change during the measurement.

    Parameters
    ----------
    single
        write all results as one self-contained file, too
    """
    with locked(options.out), SiteBuilder() as site:
        cache = open_cache(suite, options)
        if cache.resumed:
            print(cache.resumption(), flush=True)

        def provenance(command: str) -> dict[str, str]:
            return {**suite.provenance(command), **cache.provenance()}

        try:
            verified, comparison, sections = _build(
                replace(suite, provenance=provenance), options, cache, site, single
            )
        except KeyboardInterrupt:
            if cache.folder is not None:
                print(
                    "Finished results are kept: the same command resumes the build.",
                    file=sys.stderr,
                )
            raise
        cache.forget()
    return verified, comparison, sections


def build_kept(
    suite: Suite, options: Options, single: bool = False, tutorials: bool = False
) -> list[str]:
    """As `publish`; raises ValueError if the folder has no rows, unless `tutorials` is true."""
    rows = [options.out / name for name in (CLAIMS_FILE, TIMES)]
    if not (tutorials or any(file.is_file() for file in rows)):
        raise ValueError(f"{options.out} holds no rows yet; run build, verify or compare first.")
    return publish(suite, options, single, tutorials)


def publish(
    suite: Suite, options: Options, single: bool = False, tutorials: bool = False
) -> list[str]:
    """Write figures and site from the rows of earlier commands, without measuring anything.

    The verdicts are those of the earlier runs. Returns the warnings of Sphinx.

    Parameters
    ----------
    tutorials
        whether to run the code of the tutorials for their pages
    """
    with locked(options.out), SiteBuilder(tutorials) as site:
        return write_pages(kept_report(suite, options), site, single)


def kept_report(suite: Suite, options: Options) -> Report:
    """The report of the stored rows in the output folder, without pictures."""
    out = options.out
    origins = read_origins(out)
    origin = next((origins[name] for name in (CLAIMS_FILE, TIMES) if name in origins), {})
    return Report(
        suite,
        replace(options, quick=origins.get(TIMES, origin).get("setting") == "quick"),
        kept_claims(out, suite.claims),
        kept_comparison(out),
        kept_sections(out, suite.sections),
        {name: text for name, text in origin.items() if name != "setting"},
        from_rows=True,
    )


def _build(
    suite: Suite, options: Options, cache: BuildCache, site: SiteBuilder, single: bool
) -> tuple[Verified, Comparison, list[SectionResult]]:
    draw_once = remembering(map_in_workers)

    def pages(
        checked: Sequence[ClaimResult],
        comparison: Comparison,
        sections: Sequence[SectionResult] = (),
        pending: Sequence[str] = (),
    ) -> None:
        """Write the pages; an unfinished quick build writes none."""
        if not (pending and options.quick):
            provenance = suite.provenance(options.command)
            report = Report(
                suite, options, checked, comparison, sections, provenance, pending=pending
            )
            write_pages(report, site, single and not pending, draw_once)

    studies = section_studies(runnable(suite.sections), options.quick)
    headlines = Comparison(None, None)
    selects_some = 0 < len(options.claims) < len(suite.claims)
    if not (options.quick or selects_some or options.contenders or cache.resumed):
        checked, headlines = first_look(suite)
        pages(checked, headlines, pending=(ALL_CLAIMS, COMPARISONS, STUDIES))
    verified = verify(suite, options, cache, studies)
    pages(verified.checked, headlines, pending=(COMPARISONS, STUDIES))
    comparison = compare(suite, options, cache)
    pages(verified.checked, comparison, pending=(STUDIES,))
    sections = study(suite, options, suite.sections, cache)
    cache.check_sources()
    note_origin(options.out, PAGE, suite.provenance(options.command), options.quick)
    pages(verified.checked, comparison, sections)
    if cache.edited:
        print(f"Changed: {cache.provenance()['changed']}.", file=sys.stderr)
    return verified, comparison, sections


def write_pages(
    report: Report,
    site: SiteBuilder,
    single: bool = False,
    map_figures: MapFigures = map_in_workers,
) -> list[str]:
    """Draw the figures and write the site; returns the warnings of Sphinx."""
    out, pending = report.out, report.pending
    gallery = draw(report.checked, report.comparison, report.sections, map_figures)
    save(gallery, out / "figures")
    report = replace(report, gallery=gallery, history=history(out))
    write(out / "cite.bib", bibliography())
    if report.checked and not pending:
        write(out / "tables" / "numbers.tex", numbers(out))
    warnings = site(report)
    for sentence in warnings:
        print(f"Warning: {sentence}", file=sys.stderr)
    to_come = f"Still to come: {', '.join(pending)}. " if pending else ""
    print(f"{to_come}The page is {out / PAGE}.")
    if single:
        print(f"All results in one file: {write_single(report)}.")
    return warnings

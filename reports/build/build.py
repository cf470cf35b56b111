"""`build`: verify, compare, study, draw, and write the pages."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path

from benchmarks.store.atomic import write
from reports.build.compare import Compared, compare
from reports.build.kept import CLAIMS, kept_claims, kept_comparison, kept_sections
from reports.build.lock import alone
from reports.build.sections import write_sections
from reports.build.verify import Verified, verify
from reports.build.workers import map_in_workers
from reports.figures.drawing import draw, save
from reports.page.content import content
from reports.page.site import write_single, write_site
from reports.page.sources import sources
from reports.results.cache import BuildCache, open_cache
from reports.results.claim_results import ClaimResult
from reports.results.comparison import Comparison
from reports.results.options import Options
from reports.results.origins import note_origin, read_origins
from reports.results.section_result import SectionResult, measure_sections
from reports.results.suite import Suite
from reports.tables.comparison_tables import ComparisonTables, comparison_tables
from reports.tables.macros import bibliography, numbers
from reports.tracking.record import history

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
        tables = comparison_tables(compared.work_precision, suite.targets)
        quick = origins.get(TIMES, {}).get("setting") == "quick"
        return _pages(
            suite, replace(options, quick=quick), checked, compared, tables, sections, provenance,
            single, kept=True,
        )  # fmt: skip


def _build(
    suite: Suite, options: Options, cache: BuildCache, single: bool
) -> tuple[Verified, Compared, list[SectionResult]]:
    verified = verify(suite, options, cache, [one.title for one in suite.sections])
    compared = compare(suite, options, cache)
    sections = measure_sections(suite, options, suite.sections, cache)
    write_sections(sections, suite, options)
    cache.look()
    provenance = dict(suite.provenance(options.command))
    note_origin(options.out, PAGE, provenance, options.quick)
    _pages(
        suite, options, list(verified.checked), compared.measured, compared.tables, sections,
        provenance, single,
    )  # fmt: skip
    if cache.edited:
        print(f"Changed: {cache.provenance()['changed']}.", file=sys.stderr)
    return verified, compared, sections


def _pages(
    suite: Suite,
    options: Options,
    checked: list[ClaimResult],
    comparison: Comparison,
    tables: ComparisonTables,
    sections: list[SectionResult],
    provenance: dict[str, str],
    single: bool,
    kept: bool = False,
) -> Path:
    gallery = draw(checked, comparison, sections, map_in_workers)
    save(gallery, options.out / "figures")
    page = content(
        checked, comparison, tables, sections, gallery, suite.claims, provenance, options.quick,
        kept, sources(options.out, checked, comparison, sections), read_origins(options.out),
        history(options.out),
    )  # fmt: skip
    write(options.out / "cite.bib", bibliography())
    if checked:
        write(options.out / "tables" / "numbers.tex", numbers(options.out))
    first = write_site(page, options.out)
    print(f"The page is {first}.")
    if single:
        print(f"All of it in one file: {write_single(page, options.out)}.")
    return first

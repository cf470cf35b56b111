"""`build`: verify, compare, study, draw, and write the page."""

from __future__ import annotations

import sys
from dataclasses import replace

from benchmarks.store.atomic import write
from reports.build.compare import Compared, compare
from reports.build.lock import alone
from reports.build.sections import write_sections
from reports.build.verify import Verified, verify
from reports.build.workers import map_in_workers
from reports.figures.drawing import draw, save
from reports.page.content import content
from reports.page.render import render
from reports.results.cache import BuildCache, open_cache
from reports.results.options import Options
from reports.results.origins import note_origin
from reports.results.section_result import SectionResult, measure_sections
from reports.results.suite import Suite


def build(suite: Suite, options: Options) -> tuple[Verified, Compared, list[SectionResult]]:
    """Run and write everything; stored rows of long studies are included with their dates.

    An interrupted build of the same sources and settings is resumed: its results are reused, and
    the provenance says so, as it does when sources change during the measurement.
    """
    with alone(options.out):
        cache = open_cache(suite, options)
        if cache.taken:
            print(cache.greeting(), flush=True)

        def provenance(command: str) -> dict[str, str]:
            return {**suite.provenance(command), **cache.provenance()}

        try:
            found = _build(replace(suite, provenance=provenance), options, cache)
        except KeyboardInterrupt:
            if cache.store is not None:
                print(
                    "Finished results are kept: the same command resumes the build.",
                    file=sys.stderr,
                )
            raise
        cache.forget()
    return found


def _build(
    suite: Suite, options: Options, cache: BuildCache
) -> tuple[Verified, Compared, list[SectionResult]]:
    verified = verify(suite, options, cache, [one.title for one in suite.sections])
    compared = compare(suite, options, cache)
    sections = measure_sections(suite, options, suite.sections, cache)
    write_sections(sections, suite, options)
    cache.look()
    gallery = draw(verified.checked, compared.measured, sections, map_in_workers)
    save(gallery, options.out / "figures")
    provenance = dict(suite.provenance(options.command))
    page = content(
        verified.checked, compared.measured, compared.tables, sections, gallery, suite.claims,
        provenance, options,
    )  # fmt: skip
    write(options.out / "index.html", render(page))
    note_origin(options.out, "index.html", provenance, options.quick)
    if cache.edited:
        print(f"Changed: {cache.provenance()['changed']}.", file=sys.stderr)
    print(f"The page is {options.out / 'index.html'}.")
    return verified, compared, sections

"""Write the rows and tables of the studies; run their long forms."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from benchmarks.store.atomic import write
from reports.results.options import Options
from reports.results.origins import note_origin
from reports.results.progress import Studies
from reports.results.section_result import FOLDER, SectionResult
from reports.results.suite import Suite
from reports.tables.writing import as_csv, write_table


def write_sections(results: Sequence[SectionResult], suite: Suite, options: Options) -> None:
    """Write each study's rows as NAME.csv, and its table to tables/."""
    for one in results:
        if one.frame is not None:
            name = one.section.name
            write(options.out / f"{name}.csv", as_csv(one.frame))
            origin = suite.provenance(options.command)
            note_origin(options.out, f"{name}.csv", origin, options.quick)
            table = one.section.table(one.frame)[0]
            write_table(options.out / "tables", name, table, origin=origin)


def run_long_forms(suite: Suite, options: Options) -> tuple[str, ...]:
    """`studies`: do every missing run; returns a sentence for each one that raised."""
    failures: list[str] = []
    folder = options.out / FOLDER

    def say(text: str) -> None:
        print(text, file=sys.stderr)

    for section in suite.sections:
        if section.long_form is None:
            continue
        runs = section.long_form.runs(folder, say)
        missing = [one for one in runs if not one.done()]
        print(f"{section.title}: {len(runs) - len(missing)} of {len(runs)} runs are there.")
        with Studies(len(missing)) as studies:
            for one in missing:
                try:
                    with studies(section.name, one.title) as report:
                        one.run(report)
                except Exception as error:
                    failures.append(f"{one.title}: not run ({type(error).__name__}: {error}).")
    print(f"The rows are in {folder}; build shows them.")
    return tuple(failures)

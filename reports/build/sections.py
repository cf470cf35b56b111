"""Write the rows and tables of the studies; run their long forms."""

from __future__ import annotations

from collections.abc import Sequence

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv
from reports.results.cache import BuildCache, Study, not_run
from reports.results.options import Options
from reports.results.origins import note_origin
from reports.results.section import Section
from reports.results.section_result import (
    STUDIES_FOLDER,
    SectionResult,
    measure_sections,
    print_progress,
)
from reports.results.suite import Suite
from reports.tables.writing import write_table


def study(
    suite: Suite, options: Options, sections: Sequence[Section], cache: BuildCache | None = None
) -> list[SectionResult]:
    """Measure the studies; write each one's rows as NAME.csv, and its table to tables/.

    Parameters
    ----------
    cache
        the build's result cache; None stores nothing
    """
    section_results = measure_sections(suite, options, sections, cache)
    for section_result in section_results:
        if section_result.table is not None:
            name = section_result.section.name
            write(options.out / f"{name}.csv", as_csv(section_result.table))
            origin = suite.provenance(options.command)
            note_origin(options.out, f"{name}.csv", origin, options.quick)
            table = section_result.section.table(section_result.table)[0]
            write_table(options.out / "tables", name, table, origin=origin)
    return section_results


def run_long_forms(suite: Suite, options: Options, only: str = "") -> tuple[str, ...]:
    """`studies`: make every missing run of the long forms; returns a sentence for each that raised.

    Parameters
    ----------
    only
        names of studies, separated by commas; "" selects all

    Raises
    ------
    ValueError
        For a name that is no study with a long form.
    """
    failures: list[str] = []
    folder = options.out / STUDIES_FOLDER
    long_forms = {
        section.name: section.long_form
        for section in suite.sections
        if section.long_form is not None
    }
    selected_names = [name.strip() for name in only.split(",") if name.strip()] or list(long_forms)
    if unknown := [name for name in selected_names if name not in long_forms]:
        names = ", ".join(long_forms)
        raise ValueError(f"expected some of {names}; received {', '.join(unknown)}.")
    for section in suite.sections:
        if section.name not in selected_names:
            continue
        runs = long_forms[section.name].runs(folder, print_progress)
        missing = [run for run in runs if not run.is_complete()]
        print(f"{section.title}: {len(runs) - len(missing)} of {len(runs)} runs are complete.")
        errors = BuildCache().measure(
            Study(run.title, section.name, run.title, run.run) for run in missing
        )
        failures += [not_run(title, error) for title, error in errors.items()]
    print(f"The rows are in {folder}; build shows them.")
    return tuple(failures)

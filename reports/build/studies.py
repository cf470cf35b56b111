"""`studies`: the long forms, run by run; what was done before is not done again."""

from __future__ import annotations

import sys

from reports.cli.options import Order
from reports.results.progress import Studies
from reports.results.study_result import FOLDER
from reports.results.suite import Suite


def run_studies(suite: Suite, order: Order) -> tuple[str, ...]:
    """Every part that is not there yet; a sentence for each that raised."""
    failures: list[str] = []
    folder = order.out / FOLDER

    def say(text: str) -> None:
        print(text, file=sys.stderr)

    for study in suite.studies:
        if study.parts is None:
            continue
        parts = study.parts(folder, say)
        missing = [part for part in parts if not part.done()]
        print(f"{study.title}: {len(parts) - len(missing)} of {len(parts)} runs are there.")
        with Studies(len(missing)) as studies:
            for part in missing:
                try:
                    with studies(study.name, part.title) as report:
                        part.run(report)
                except Exception as error:
                    failures.append(f"{part.title}: not run ({type(error).__name__}: {error}).")
    print(f"The rows are in {folder}; build shows them.")
    return tuple(failures)

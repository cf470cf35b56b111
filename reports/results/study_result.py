"""Run the studies that have sections of their own, and keep what they found."""

from __future__ import annotations

import sys
from dataclasses import dataclass

import pandas as pd

from reports.cli.options import Order
from reports.results.atomic import write
from reports.results.cache import Parts
from reports.results.origins import note_origin
from reports.results.progress import Studies
from reports.results.study import Study
from reports.results.suite import Suite
from reports.tables.writing import as_csv, write_table

FOLDER = "studies"  # in the folder of the report: rows of the long forms


@dataclass(frozen=True, eq=False)
class StudyResult:
    """A study with what came of it.

    frame    its rows, those of the long form among them; None when there are none
    note     what the reader should know about the long form, or nothing
    failure  a sentence when it raised, or nothing
    """

    study: Study
    frame: pd.DataFrame | None
    note: str = ""
    failure: str = ""


def study_all(suite: Suite, order: Order, parts: Parts | None = None) -> list[StudyResult]:
    """Each study in its default form, beside what is stored of its long one; writes the tables.

    parts  of a build; None keeps none
    """
    if not suite.studies:
        return []
    parts = parts or Parts()
    with Studies(len(suite.studies)) as studies:
        found = [_studied(one, suite, order, studies, parts) for one in suite.studies]
    for one in found:
        if one.frame is not None:
            name = one.study.name
            write(order.out / f"{name}.csv", as_csv(one.frame))
            told = {**suite.provenance(order.command), **parts.measured([one.study.title])}
            note_origin(order.out, f"{name}.csv", told, order.quick)
            write_table(order.out / "tables", name, one.study.table(one.frame)[0])
    return found


def _studied(
    study: Study, suite: Suite, order: Order, studies: Studies, parts: Parts
) -> StudyResult:
    try:
        with studies("study", study.title) as report:
            part = parts.part(study.title, lambda: study.measure(order.quick, report))
    except Exception as error:
        frame = pd.DataFrame()
        failure = f"{study.title}: not run ({type(error).__name__}: {error})."
    else:
        failure = ""
        frame = _of_now(part.frame, suite, order, part.run)
    kept, note = pd.DataFrame(), ""
    if study.stored is not None:
        kept = study.stored(order.out / FOLDER, lambda text: print(text, file=sys.stderr))
        note = "" if len(kept) else "Its long form was not run: make studies."
    frames = [part for part in (frame, kept) if len(part)]
    return StudyResult(
        study, pd.concat(frames, ignore_index=True) if frames else None, note, failure
    )


def _of_now(frame: pd.DataFrame, suite: Suite, order: Order, run: str) -> pd.DataFrame:
    """Rows that tell their commit and date get those of this run, or of the one that measured."""
    told = suite.provenance(order.command)
    commit, plus, dirty = told.get("commit", "").partition("+")
    now = {
        "commit": f"{commit[:12]}{plus}{dirty}",
        "date": (run or told.get("date", "")).partition(" ")[0],
    }
    return frame.assign(**{name: text for name, text in now.items() if name in frame})

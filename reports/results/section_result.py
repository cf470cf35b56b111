"""Run the studies that have sections on the page."""

from __future__ import annotations

import sys
from collections.abc import Sequence
from dataclasses import dataclass

import pandas as pd

from benchmarks.applications.external.loading import describe_error
from reports.results.cache import BuildCache
from reports.results.options import Options
from reports.results.progress import Studies
from reports.results.section import Section
from reports.results.suite import Suite

FOLDER = "studies"  # subfolder of the report for rows of the long forms


@dataclass(frozen=True, eq=False)
class SectionResult:
    """A study with its rows.

    Attributes
    ----------
    frame
        its rows, those of the long form among them; None when there are none
    note
        a sentence on the long form, or on an absent engine for want of which it did not run; or ""
    failure
        a sentence when it raised, or ""
    """

    section: Section
    frame: pd.DataFrame | None
    note: str = ""
    failure: str = ""


def measure_sections(
    suite: Suite,
    options: Options,
    sections: Sequence[Section],
    cache: BuildCache | None = None,
) -> list[SectionResult]:
    """Measure each study in its default form, and add the stored rows of its long form.

    A study whose engine is absent is not run, which is no failure.
    """
    if not sections:
        return []
    cache = cache or BuildCache()
    with Studies(len(sections)) as studies:
        return [_measured(one, suite, options, studies, cache) for one in sections]


def runnable(sections: Sequence[Section]) -> list[Section]:
    """The studies whose engines are here; the others are named on stderr, with the reason."""
    absences = {section.name: section.absent() for section in sections}
    for section in sections:
        if absence := absences[section.name]:
            say(f"{section.title}: will not run. {absence}")
    return [section for section in sections if not absences[section.name]]


def _measured(
    section: Section, suite: Suite, options: Options, studies: Studies, cache: BuildCache
) -> SectionResult:
    frames, absence, failure = list[pd.DataFrame](), section.absent(), ""
    try:
        if not absence:
            frames.append(_rows(section, suite, options, studies, cache))
    except Exception as error:
        failure = f"{section.title}: not run ({describe_error(error)})."
    note = absence
    if section.long_form is not None:
        rows = section.long_form.stored(options.out / FOLDER, say)
        if not (len(rows) or absence):
            note = "Short version: make studies runs the long one."
        frames.append(rows)
    frames = [frame for frame in frames if len(frame)]
    whole = pd.concat(frames, ignore_index=True) if frames else None
    return SectionResult(section, whole, note, failure)


def _rows(
    section: Section, suite: Suite, options: Options, studies: Studies, cache: BuildCache
) -> pd.DataFrame:
    """The rows of a study's default form, measured here or taken from the cache."""
    with studies("study", section.title) as report:
        result = cache.result(section.title, lambda: section.measure(options.quick, report))
    return _dated(result.frame, suite, options, result.run)


def _dated(frame: pd.DataFrame, suite: Suite, options: Options, run: str) -> pd.DataFrame:
    """Fill missing values of the commit and date columns, where present, with those of the run."""
    origin = suite.provenance(options.command)
    commit, plus, dirty = origin.get("commit", "").partition("+")
    now = {
        "commit": f"{commit[:12]}{plus}{dirty}",
        "date": (run or origin.get("date", "")).partition(" ")[0],
    }
    return frame.assign(**{name: text for name, text in now.items() if name in frame})


def say(text: str) -> None:
    """On stderr."""
    print(text, file=sys.stderr)

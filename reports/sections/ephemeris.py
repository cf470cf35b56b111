"""The section on point masses compared with JPL's ephemeris."""

from __future__ import annotations

from functools import partial

from benchmarks.studies.ephemeris import EXPLANATION, ephemeris_table
from reports.results.section import Section
from reports.tables.study_table import readable_table

HEADINGS = {
    "contender": "contender",
    "body": "body",
    "days": "days",
    "difference_au": "from DE421 [au]",
    "difference_arcsec": "seen from the Sun [″]",
    "relativity_au": "relativity alone [au]",
    "integration_error_au": "error of the run [au]",
    "status": "status",
}

EPHEMERIS = Section(
    name="ephemeris",
    title="Point masses against JPL's ephemeris",
    text=EXPLANATION,
    measure=ephemeris_table,
    table=partial(readable_table, headings=HEADINGS),
    open=True,
    compared=True,
)

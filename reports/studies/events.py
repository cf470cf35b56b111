"""The section on transits."""

from __future__ import annotations

from functools import partial

from benchmarks.studies import transits
from reports.results.section import Section
from reports.tables.study_table import readable_table

TRANSITS_COLUMNS = {
    "contender": "contender",
    "settings": "setting",
    "transits": "transits",
    "lost": "lost",
    "largest_s": "largest error [s]",
    "seconds": "time [s]",
    "status": "status",
}

TRANSITS = Section(
    name="transits",
    title="Transit times",
    text=transits.EXPLANATION,
    measure=transits.transits_table,
    table=partial(readable_table, headings=TRANSITS_COLUMNS),
    timed=True,
)

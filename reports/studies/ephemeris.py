"""The section on planets beside JPL's ephemeris."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies import ephemeris
from references.jpl.ephemeris import JPL_EPHEMERIS
from reports.results.section import Section
from reports.tables.study_table import readable_table

SKY_COLUMNS = {
    "contender": "contender",
    "body": "body",
    "days": "days",
    "difference_au": "from DE421, barycentric [au]",
    "difference_arcsec": "seen from the Sun [″]",
    "relativity_au": "relativity alone [au]",
    "integration_error_au": "error of the run [au]",
    "in_frame": "in the Kepler frame [au]",
    "status": "status",
}


def sky_table(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each contender, body and time, with the error in the Kepler frame beside the first
    contender's, whose model it shares; and the CSS classes of the columns."""
    framed = (frame["contender"] == ephemeris.IN_FRAME) & (frame["status"] == "")
    error = frame[framed].set_index(["body", "days"])["integration_error_au"]
    rest = frame[~framed].copy()
    ours = rest["contender"] == rest["contender"].iloc[0]
    places = pd.MultiIndex.from_frame(rest[["body", "days"]])
    rest["in_frame"] = error.reindex(places).where(ours.to_numpy()).to_numpy(float)
    return readable_table(rest, SKY_COLUMNS)


EPHEMERIS = Section(
    name="ephemeris",
    title="Point masses against JPL's ephemeris",
    text=ephemeris.EXPLANATION,
    measure=ephemeris.ephemeris_table,
    table=sky_table,
    absent=lambda: JPL_EPHEMERIS.missing,
    open=True,
    compared=True,
)

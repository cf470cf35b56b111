"""The section on forces and the integrators that they work under."""

from __future__ import annotations

import pandas as pd

from benchmarks.studies import forces
from references.heyoka.taylor import HEYOKA_QUADRUPLE
from reports.results.section import Section


def matrix(frame: pd.DataFrame) -> tuple[pd.DataFrame, dict[str, str]]:
    """A line for each force and eccentricity, a column for each contender."""
    return forces.matrix(frame), {}


def versions_and_words(frame: pd.DataFrame) -> str:
    """The versions, and what contenders said or did beside being right or wrong."""
    said = frame[frame["status"].fillna("") != ""]
    words = [
        f"{contender}: {status}"
        for contender, status in dict.fromkeys(zip(said["contender"], said["status"], strict=True))
    ]
    return " ".join([*(f"{one}." for one in frame["versions"].dropna().unique()), *words])


FORCES = Section(
    name="forces",
    title="Forces and integrators",
    text=forces.EXPLANATION,
    measure=forces.forces_table,
    table=matrix,
    summary=versions_and_words,
    absent=lambda: HEYOKA_QUADRUPLE.missing,
)

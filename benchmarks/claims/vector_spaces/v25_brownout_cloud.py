"""V25: a brownout cloud of sand of several diameters (M figure 2); not run."""

from __future__ import annotations

import pandas as pd

from benchmarks.checks.bounds import NOT_RUN, Finding
from benchmarks.checks.claim import Claim, MakeMethod, Report, Row
from benchmarks.store.frames import frame


def study(make_method: MakeMethod, quick: bool, report: Report) -> pd.DataFrame:
    """An empty frame; the claim's only row gives the reason."""
    return frame([])


def judge(table: pd.DataFrame) -> list[Row]:
    """One row with the verdict "not run" and the reason."""
    return [
        V25.row("places of a cloud of particles", Finding(), float("nan"), expected=NOT_RUN),
    ]


V25 = Claim(
    "V25",
    "Brownout cloud: pictures of many particles",
    study,
    judge,
    source="M 6.2, fig. 2",
    setup="many particles of several diameters that do not meet",
    claimed="particle distributions at different time instants, a picture without numbers",
    reason="Missing are M's wind and the way in which the ground gives off sand and takes it back, "
    "neither of which M prints; in galvi.problems.brownout particles fall through the ground. V23 "
    "and V24 follow one particle, on which no other acts in M either.",
    reference="none",
)

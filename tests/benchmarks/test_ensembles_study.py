"""The study of ensembles: every code reaches the error it is timed at, and the page shows it."""

from __future__ import annotations

import pandas as pd
import pytest

from benchmarks.studies import ensembles as study
from reports.figures.picture import picture
from reports.sections.ensembles import ENSEMBLES, ensembles_table


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    rows = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "ROUNDS", 1)
        patch.setattr(study, "LEAST", 0.0)
        for made in (study.free_bodies, study.kepler_orbits):
            rows += study.compared(made(16), pool=None)
        patch.setattr(study.ExecutorsOfStudy, "clusters", lambda self: {})
        rows += study.scaling(study.kepler_orbits(64))
    return pd.DataFrame(rows, columns=list(study.COLUMNS))


def test_every_code_is_timed_where_it_reaches_the_error(frame):
    peers = frame[frame["part"] == "peers"]
    timed = peers[peers["seconds"] > 0.0]
    assert {"galvi", "MuJoCo rollout, RK4"} <= set(timed["contender"])
    assert "SciPy DOP853" in set(peers["contender"])
    assert (timed["error"] <= timed["target"]).all()
    assert (timed[timed["contender"] == "galvi"]["relative"] == 1.0).all()


def test_the_page_has_a_line_for_each_way(frame):
    table, _ = ensembles_table(frame)
    assert len(table) == len(frame)
    assert picture(ENSEMBLES.figures[0], frame)

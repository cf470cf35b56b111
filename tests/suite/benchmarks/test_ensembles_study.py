"""The study of ensembles: every code reaches the error it is timed at, and the page shows it."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from contextlib import nullcontext

import numpy as np
import pandas as pd
import pytest

import galvi
from benchmarks.studies import ensembles as study
from galvi.run.ensemble import processors
from reports.figures.picture import picture
from reports.studies.costs import ENSEMBLES, ensembles_table


@pytest.fixture(scope="module")
def frame() -> pd.DataFrame:
    rows = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "ROUNDS", 1)
        patch.setattr(study, "ROUND_SECONDS", 0.0)
        for made in (study.free_bodies, study.kepler_orbits):
            rows += study.compared(made(16))
        patch.setattr(study, "workers", lambda: nullcontext({}))
        rows += study.scaling(study.kepler_orbits(64))
    return pd.DataFrame(rows, columns=list(study.COLUMNS))


def test_every_code_is_timed_where_it_reaches_the_error(frame):
    peers = frame[frame["part"] == "peers"]
    timed = peers[peers["seconds"] > 0.0]
    assert {"galvi", "MuJoCo rollout, RK4"} <= set(timed["contender"])
    assert "SciPy DOP853" in set(peers["contender"])
    assert (timed["error"] <= timed["target"]).all()
    assert (timed[timed["contender"] == "galvi"]["relative"] == 1.0).all()
    alone = timed[timed["contender"] == "SciPy DOP853"]  # three members in one thread
    shared = 1e6 * alone["seconds"] / (3 * processors())
    assert len(alone) and alone["microseconds"].to_numpy() == pytest.approx(shared.to_numpy())


def test_the_page_has_a_line_for_each_way(frame):
    table, _ = ensembles_table(frame)
    assert len(table) == len(frame)
    assert picture(ENSEMBLES.figures[0], frame)


class Workers(ThreadPoolExecutor):
    """A client with two workers, which notes those that it is asked for."""

    def __init__(self):
        super().__init__(2)
        self.asked = []

    def nthreads(self):
        return {"one": 1, "other": 1}

    def submit(self, function, *arguments, workers=None):
        self.asked.append(workers)
        return super().submit(function, *arguments)


def test_one_worker_of_a_cluster_does_all_of_the_work():
    problem, q, v, *_ = study.kepler_orbits(300)
    arguments = (problem, q, v, galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)), 0.05, 10)
    with Workers() as client:
        alone = galvi.integrate_ensemble(*arguments, executor=study.OneWorker(client))
        assert client.asked and all(one == ["one"] for one in client.asked)
        assert sum(study.OneWorker(client).nthreads().values()) == 1
    np.testing.assert_array_equal(alone, galvi.integrate_ensemble(*arguments))

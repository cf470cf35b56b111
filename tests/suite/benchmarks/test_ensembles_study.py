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
def timings() -> pd.DataFrame:
    rows = []
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(study, "ROUNDS", 1)
        patch.setattr(study, "ROUND_SECONDS", 0.0)
        for build in (study.free_bodies, study.kepler_orbits):
            # A target that DOP853 reaches with any processor's roundings: it is at 1e-12 here.
            rows += study.compared(build(16)._replace(target=1e-11))
        patch.setattr(study, "workers", lambda: nullcontext({}))
        rows += study.scaling(study.kepler_orbits(64))
    return pd.DataFrame(rows, columns=list(study.COLUMNS))


def test_every_code_is_timed_where_it_reaches_the_error(timings):
    peers = timings[timings["part"] == "peers"]
    timed = peers[peers["seconds"] > 0.0]
    assert {"galvi", "MuJoCo rollout, RK4"} <= set(timed["contender"])
    assert "SciPy DOP853" in set(peers["contender"])
    assert (timed["error"] <= timed["target"]).all()
    assert (timed[timed["contender"] == "galvi"]["relative"] == 1.0).all()
    scipy_rows = timed[timed["contender"] == "SciPy DOP853"]  # three members in one thread
    shared = 1e6 * scipy_rows["seconds"] / (3 * processors())
    assert len(scipy_rows) and scipy_rows["microseconds"].to_numpy() == pytest.approx(
        shared.to_numpy()
    )


def test_the_page_has_a_line_for_each_way(timings):
    table, _ = ensembles_table(timings)
    assert len(table) == len(timings)
    assert picture(ENSEMBLES.figures[0], timings)


class Workers(ThreadPoolExecutor):
    """A client with two workers, which records the workers that tasks are submitted to."""

    def __init__(self):
        super().__init__(2)
        self.requested_workers = []

    def nthreads(self):
        return {"one": 1, "other": 1}

    def submit(self, function, *arguments, workers=None):
        self.requested_workers.append(workers)
        return super().submit(function, *arguments)


def test_one_worker_of_a_cluster_does_all_of_the_work():
    problem, q, v, *_ = study.kepler_orbits(300)
    arguments = (problem, q, v, galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4)), 0.05, 10)
    with Workers() as client:
        ends = galvi.integrate_ensemble(*arguments, executor=study.OneWorker(client))
        assert client.requested_workers and all(
            workers == ["one"] for workers in client.requested_workers
        )
        assert sum(study.OneWorker(client).nthreads().values()) == 1
    np.testing.assert_array_equal(ends, galvi.integrate_ensemble(*arguments))

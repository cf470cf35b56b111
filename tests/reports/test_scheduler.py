"""`build --scheduler`: studies without timings run on the workers of a Dask scheduler."""

from functools import partial

import pytest
import typer

from benchmarks.store.provenance import cpu
from reports.build import workers
from reports.build.verify import verify
from reports.build.workers import on_scheduler
from reports.cli.commands import run
from reports.results.options import Options
from tests.reports.small_studies import broken, nothing, quiet


@pytest.fixture(scope="module")
def address():
    from distributed import LocalCluster

    with LocalCluster(
        n_workers=1, threads_per_worker=1, processes=False, dashboard_address=":0", silence_logs=50
    ) as cluster:
        yield cluster.scheduler_address


def test_studies_run_there_and_those_that_raise_or_are_timed_here(
    address, make_suite, make_claim, tmp_path
):
    claims = [make_claim(name) for name in ("V1", "V2", "V3")]
    known = make_suite(*claims, in_workers={"V1": nothing, "V2": broken})  # V3 measures times
    with on_scheduler(known, address) as suite:
        found = verify(suite, Options(True, out=tmp_path))
        assert suite.provenance("")["workers"] == f"1 on {cpu()}"
    assert [one.claim.id for one in found.checked if len(one.frame)] == ["V2", "V3"]
    with on_scheduler(known, "") as suite:
        assert suite is known


def test_what_workers_have_that_is_not_the_same_is_refused(address, make_suite, monkeypatch):
    known = make_suite()
    for_each_call = iter(("here", "there", "here", "here", "here", "there"))
    monkeypatch.setattr(workers, "_sources", lambda: next(for_each_call))
    with pytest.raises(typer.BadParameter, match="sources or versions"):
        on_scheduler(known, address).__enter__()
    with on_scheduler(known, address) as suite:  # a worker that came later: done here
        assert list(suite.runner({"V1": partial(quiet, 0.0)}, True)) == []


@pytest.mark.parametrize("address", ["tcp://127.0.0.1:1", "nowhere", "http://127.0.0.1:1"])
def test_an_address_where_nothing_answers_is_refused_in_a_sentence(
    make_suite, monkeypatch, tmp_path, capsys, address
):
    monkeypatch.setattr(workers, "PATIENCE", "0.2s")
    arguments = ["build", "--scheduler", address, "--out", str(tmp_path)]
    assert run(lambda: make_suite(), arguments) == 2
    (line,) = capsys.readouterr().err.splitlines()
    assert "--scheduler" in line and "no answer" in line

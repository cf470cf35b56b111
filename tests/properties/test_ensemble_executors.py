"""Ensembles on the workers of an executor and in a folder lose nothing and change nothing."""

import os
import pickle
import random
import signal
import subprocess
import sys
import threading
import time
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numba
import numpy as np
import pytest

import galvi
from galvi.ensembles import chunk as schedule
from galvi.ensembles import integrate_ensemble as engine
from galvi.ensembles.folder import Folder
from tests.properties.ensemble_cases import CASES, starts

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
SECONDS = schedule.SECONDS
PROBLEM, STEP = CASES["henon_heiles"]


@pytest.fixture(autouse=True)
def small_chunks(monkeypatch):
    """Chunks of 16 members."""
    monkeypatch.setattr(schedule, "PROBE", 16)
    monkeypatch.setattr(schedule, "SECONDS", 0.0)
    monkeypatch.setattr(engine, "PROBE", 16)


def run(members=100, steps=10, **options):
    q, v = starts(PROBLEM, members)
    return galvi.integrate_ensemble(PROBLEM, q, v, FOUR, STEP, steps, **options)


def same(one, other):
    arrays = zip(one.kept, other.kept, strict=True)
    return one.status == other.status and all(
        np.array_equal(*pair, equal_nan=True) for pair in arrays
    )


@pytest.mark.slow(
    beside="tests/suite/benchmarks/test_ensembles_study.py::test_one_worker_of_a_cluster_does_all_of_the_work"
)
def test_on_a_cluster_of_this_machine():
    from distributed import Client, LocalCluster

    def local(**options):
        return LocalCluster(dashboard_address=":0", silence_logs=50, **options)

    one = run()
    with local(n_workers=1, threads_per_worker=2) as cluster, Client(cluster) as client:
        assert same(run(executor=client), one)


@pytest.mark.parametrize(
    ("seconds", "members", "most"),
    [(1e-5, 10**7, 100_000), (1e-5, 10**5, 12_504), (1e-5, 1000, 256), (1.0, 1000, 64)],
)
def test_a_chunk_takes_a_second_or_less_where_workers_share_few(
    monkeypatch, seconds, members, most
):
    monkeypatch.setattr(schedule, "PROBE", 64)
    monkeypatch.setattr(schedule, "SECONDS", SECONDS)
    assert schedule.members_of_a_chunk(seconds, 100.0, members, 2) == most


def test_the_states_that_a_function_is_given_count_as_memory(monkeypatch):
    asked = []

    def members_of_a_chunk(seconds, bytes_each, members, workers):
        asked.append(bytes_each)
        return 16

    monkeypatch.setattr(engine, "members_of_a_chunk", members_of_a_chunk)
    run(40, keep=galvi.FinalStates())
    run(40, keep=numba.njit(lambda t, q, p: q[-1, 0]))
    assert asked[1] - asked[0] == 8 * (11 * 4 - 3)  # all states, and a number kept instead of 4


def test_what_travels_is_text_and_numbers():
    sent = []

    class Far(ThreadPoolExecutor):
        def submit(self, function, chunk):
            sent.append(pickle.dumps(chunk))
            return super().submit(function, pickle.loads(sent[-1]))

    with Far(1) as executor:
        assert same(run(16, 2, executor=executor), run(16, 2))
    assert b"def law" in sent[0] or b"law = " in sent[0]
    assert b"Dispatcher" not in sent[0] and b"galvi.problem" not in sent[0]


@pytest.mark.slow(beside="test_ensemble_folder.py::test_the_version_is_part_of_the_name")
def test_failures_and_functions_are_kept_in_a_folder(tmp_path):
    problem = galvi.problems.kepler(0.3)
    q = np.stack([problem.q0, [1e-3, 0.0]])
    v = np.stack([problem.v0, [0.0, 0.0]])

    def ends(size):
        return galvi.integrate_ensemble(
            problem,
            q,
            v,
            FOUR,
            0.2,
            5,
            folder=tmp_path,
            keep=lambda run: run.q[-1] * size,
            version=str(size),
        )

    first = ends(1.0)
    assert not first.success[1] and same(ends(1.0), first)
    assert np.array_equal(np.asarray(ends(2.0))[0], 2.0 * np.asarray(first)[0])


def test_half_a_file_is_never_left(tmp_path, monkeypatch):
    def interrupted(*paths):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        run(folder=tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_stops_threads_and_leaves_what_is_done(tmp_path, monkeypatch):
    save, done = Folder.save, []

    def third(self, *arguments):
        save(self, *arguments)
        done.append(arguments[0])
        if len(done) == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(Folder, "save", third)
        run(folder=tmp_path)
    assert len(list(tmp_path.glob("*.npz"))) == 3
    assert not [t for t in threading.enumerate() if t.name.startswith("ThreadPool")]
    assert same(run(folder=tmp_path), run())


CLIENT = """
import os, random, signal, sys
import numpy as np
from tests.properties import test_ensemble_executors as tests

tests.schedule.PROBE = tests.engine.PROBE = 16
tests.schedule.SECONDS = 0.0
folder, mid_write = sys.argv[1], int(sys.argv[2])
write, count = np.savez, 0


def torn(target, **arrays):
    global count
    count += 1
    write(target, **arrays)
    if count == mid_write:
        target.flush()
        os.ftruncate(target.fileno(), target.tell() // 2)
        os.kill(os.getpid(), signal.SIGKILL)


np.savez = torn
print("begins", flush=True)
tests.run(2000, 300, folder=folder)
"""


@pytest.mark.slow(beside="test_half_a_file_is_never_left")
def test_fifty_kills_lose_and_change_nothing(tmp_path):
    """25 kills of a client at any time, 20 in the middle of a file, and 5 of workers."""
    chance, truth = random.Random(5), run(2000, 300)
    kills = 0
    while kills < 45:
        mid_write = chance.randint(1, 4) if kills >= 25 else 0
        before = set(tmp_path.glob("*.npz"))
        if len(before) > 100:  # nearly done: begin anew
            for path in chance.sample(sorted(before), 90):
                path.unlink()
            before = set(tmp_path.glob("*.npz"))
        known = {path: path.read_bytes() for path in before}
        client = subprocess.Popen(
            [sys.executable, "-c", CLIENT, str(tmp_path), str(mid_write)],
            stdout=subprocess.PIPE, cwd=Path(__file__).parents[2],
        )  # fmt: skip
        assert client.stdout is not None and client.stdout.readline() == b"begins\n"
        if not mid_write:
            time.sleep(chance.uniform(0.05, 0.6))
            client.kill()
        assert client.wait() in (-signal.SIGKILL, 0)
        client.stdout.close()
        kills += client.returncode == -signal.SIGKILL
        assert all(path.read_bytes() == content for path, content in known.items())
    assert same(run(2000, 300, folder=tmp_path), truth)

    import dask
    from distributed import Client, LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 50}),
        LocalCluster(silence_logs=50, **options) as cluster,
        Client(cluster) as client,
    ):
        over = threading.Event()
        killed = []

        def kill_workers():  # while both work: a nanny gives up on one that dies as it starts
            while not over.is_set() and len(killed) < 5:
                time.sleep(0.5 * chance.random())
                pids = [worker.pid for worker in cluster.workers.values() if worker.pid]
                if len(client.run(os.getpid)) == len(pids) == 2 and not over.is_set():
                    killed.append(chance.choice(pids))
                    os.kill(killed[-1], signal.SIGKILL)
                    time.sleep(5.0)

        killer = threading.Thread(target=kill_workers)
        killer.start()
        try:
            while len(killed) < 5:
                assert same(run(2000, 300, executor=client), truth)
        finally:
            over.set()
            killer.join()

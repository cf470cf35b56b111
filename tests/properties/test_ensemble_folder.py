"""Ensembles in a folder and on the workers of an executor: a folder gives what a new computation
would give, whatever happened to its files."""

from __future__ import annotations

import dataclasses
import fractions
import functools
import os
import pickle
import random
import shutil
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
from galvi.ensembles import folder as folders
from galvi.ensembles import integrate_ensemble as engine
from galvi.ensembles.folder import digest_of_galvi, identity

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
STIFFNESS = 2.0
ROOT = Path(__file__).parents[2]
SYSTEMS = [
    make().system
    for name, make in vars(galvi.problems).items()
    if callable(make) and name not in ("helmholtz", "brownout")
]


def traced():
    return galvi.Problem(
        galvi.Canonical(1.0, lambda q: 0.5 * STIFFNESS * (q @ q)), [1.0, 0.5], [0.0, 0.2]
    )


def ensemble(folder=None, members=40, steps=3, **options):
    problem = traced()
    v = problem.v0 * np.linspace(0.5, 1.5, members)[:, None]
    return galvi.integrate_ensemble(
        problem, problem.q0, v, FOUR, 0.1, steps, folder=folder, **options
    )


def set_chunk_size(monkeypatch, members=8):
    """Chunks and files get ``members`` members."""
    monkeypatch.setattr(engine, "PROBE", members)
    monkeypatch.setattr(engine, "members_of_a_chunk", lambda *arguments: members)


@pytest.fixture
def small_files(monkeypatch):
    set_chunk_size(monkeypatch)


def end(run):
    return run.q[-1]


@numba.njit
def compiled(t, q, p):
    return q[-1]


class Potential:
    """A caller's potential that cannot be traced."""

    def __call__(self, q):
        return 0.5 * float(q[0]) ** 2


# ---------------------------------------------------------------- requests are told apart


@pytest.mark.slow(beside="test_what_a_function_holds_is_told_apart_beside_its_version")
def test_values_of_galvi_are_told_apart_and_are_the_same_in_another_process():
    methods = [galvi.Galerkin(galvi.Polynomials(s), galvi.radau(s)) for s in (2, 3)]
    keeps = [galvi.FinalStates(), galvi.StatesAt([0.1]), galvi.StatesAt([0.2])]
    identities = [repr(identity(value, None)) for value in (*SYSTEMS, *methods, *keeps)]
    assert len(set(identities)) == len({repr(value) for value in identities}) >= len(SYSTEMS) + 2
    code = (
        "from tests.properties import test_ensemble_folder as t; "
        "print([repr(t.identity(value, None)) for value in t.SYSTEMS])"
    )
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(ROOT)}
    output = subprocess.run(
        [sys.executable, "-c", code],
        env=environment,
        cwd=ROOT,
        capture_output=True,
        check=True,
        text=True,
    )
    assert output.stdout.splitlines()[-1] == str(identities[: len(SYSTEMS)])


@pytest.mark.parametrize("keep", [end, lambda run: run.q[-1], compiled, np.sin])
def test_a_function_that_is_called_needs_a_version(keep, tmp_path):
    with pytest.raises(ValueError, match=r"what it calls cannot be known\. Give version='1'"):
        ensemble(tmp_path, keep=keep)
    assert not list(tmp_path.iterdir())


def test_so_does_a_potential_that_was_not_traced_and_the_version_is_part_of_the_request(tmp_path):
    problem = galvi.Problem(galvi.Canonical(1.0, Potential()), [1.0], [0.0])
    arguments = (problem, problem.q0, problem.v0, FOUR, 0.1, 3)
    with pytest.raises(ValueError, match=r"those of earlier code of .*Potential, since"):
        galvi.integrate_ensemble(*arguments, folder=tmp_path)
    for version, loaded in (("1", 0), ("1", 1), ("2", 0)):
        ends = galvi.integrate_ensemble(*arguments, folder=tmp_path, version=version)
        assert ends.files == f"files: {loaded} loaded, {1 - loaded} computed"


@dataclasses.dataclass
class Scaled:
    """The last state times ``by``, as an attribute of a dataclass."""

    by: float

    def __call__(self, run):
        return self.by * run.q[-1]


class Plain:
    def __init__(self, by):
        self.by = by

    def __call__(self, run):
        return self.by * run.q[-1]


def scaled(run, by=1.0):
    return by * run.q[-1]


@pytest.mark.parametrize(
    "make",
    [
        lambda a: lambda run: a * run.q[-1],
        lambda a: functools.partial(scaled, by=a),
        Scaled,
        Plain,
        lambda a: Plain(np.array([a], dtype=object)),
        lambda a: Plain(fractions.Fraction(a)).__call__,
        lambda a: lambda run, by=a: by * run.q[-1],
    ],
)
def test_what_a_function_holds_is_told_apart_beside_its_version(make, tmp_path):
    single, hundredfold = (
        np.asarray(ensemble(tmp_path, 3, keep=make(a), version="1"), dtype=float)
        for a in (1.0, 100.0)
    )
    assert np.allclose(hundredfold, 100.0 * single) and np.any(single)
    assert ensemble(tmp_path, 3, keep=make(1.0), version="1").files == "files: 1 loaded, 0 computed"


def test_the_text_of_a_traced_law_is_part_of_its_work(tmp_path, monkeypatch):
    first = np.array(ensemble(tmp_path)[0])
    monkeypatch.setitem(globals(), "STIFFNESS", 3.0)
    assert np.array_equal(ensemble(tmp_path)[0], ensemble()[0])
    assert not np.array_equal(ensemble(tmp_path)[0], first)


def test_the_code_of_galvi_is_part_of_the_request(tmp_path, monkeypatch):
    """Code that changes while the process runs is refused."""
    module = tmp_path / "galvi" / "ensembles" / "folder.py"
    module.parent.mkdir(parents=True)
    monkeypatch.setattr(folders, "__file__", str(module))
    monkeypatch.setattr(folders, "IMPORTED", np.inf)
    monkeypatch.setattr(folders, "digest_of_galvi", digest_of_galvi.__wrapped__)
    for code, loaded in (("x = 2\n", 0), ("x = 2\n", 1), ("x = 3\n", 0)):
        module.write_text(code)
        assert ensemble(tmp_path).files.startswith(f"files: {loaded} loaded")
    monkeypatch.setattr(folders, "IMPORTED", 0.0)
    with pytest.raises(ValueError, match=r"was changed after this process had imported galvi"):
        ensemble(tmp_path)


def test_parameters_with_the_names_of_starts_hide_none(tmp_path):
    import sympy

    x, vx, q = sympy.symbols("x vx q", real=True)
    system = galvi.Lagrangian.from_sympy(vx**2 / 2 - q * x**2 / 2, [x], [vx], parameters={q: 1.0})
    problem = galvi.Problem(system, [1.0], [0.0])

    def last(start):
        ends = galvi.integrate_ensemble(
            problem, [[start]], problem.v0, FOUR, 0.1, 2, {"q": [2.0]}, folder=tmp_path
        )
        return ends[0][0, 0]

    assert last(1.0) == pytest.approx(0.5 * last(2.0), rel=1e-12)


@pytest.mark.parametrize("keep", [galvi.StatesAt([]), lambda run: np.zeros(0)])
def test_values_without_entries_are_kept_too(keep, tmp_path):
    shapes = {ensemble(tmp_path, 3, keep=keep, version="1").kept[0].shape for _ in range(2)}
    assert shapes == {ensemble(None, 3, keep=keep).kept[0].shape}


# ---------------------------------------------------------------- files are not believed


def with_arrays(change):
    """The damage that passes the arrays of a file through ``change``."""

    def damage(path, siblings, chance):
        with np.load(path) as file:
            arrays = dict(file)
        np.savez(path, **change(arrays))

    return damage


def with_bytes(change):
    """The damage that passes the bytes of a file and a random position through ``change``."""

    def damage(path, siblings, chance):
        content = bytearray(path.read_bytes())
        path.write_bytes(change(content, int(chance.integers(len(content)))))

    return damage


def copy_of_another(path, siblings, chance):
    shutil.copyfile(siblings[chance.integers(len(siblings))], path)


def folder_in_place(path, siblings, chance):
    path.unlink()
    (path / "inside").mkdir(parents=True)


DAMAGE = {
    "a row less": with_arrays(
        lambda arrays: {name: x[1:] if x.ndim else x for name, x in arrays.items()}
    ),
    "no passes": with_arrays(lambda arrays: {x: arrays[x] for x in arrays if x != "passes"}),
    "another column": with_arrays(lambda arrays: {**arrays, "more": arrays["passes"]}),
    "no digest": with_arrays(lambda arrays: {x: arrays[x] for x in arrays if x != "digest"}),
    "other outcomes": with_arrays(lambda arrays: {**arrays, "outcomes": np.array("[]")}),
    "objects": with_arrays(lambda arrays: {**arrays, "passes": arrays["passes"].astype(object)}),
    "float32": with_arrays(
        lambda arrays: {**arrays, "value0": arrays["value0"].astype(np.float32)}
    ),
    "another number": with_arrays(
        lambda arrays: {**arrays, "passes": np.arange(len(arrays["passes"]))}
    ),
    "a bit": with_bytes(lambda x, k: x[:k] + bytes([x[k] ^ 1 << k % 8]) + x[k + 1 :]),
    "a cut": with_bytes(lambda x, k: x[:k]),
    "zeros": with_bytes(lambda x, k: x[:k] + bytes(len(x[k : k + 100])) + x[k + 100 :]),
    "an addition": with_bytes(lambda x, k: x + x[: k + 1]),
    "another file": copy_of_another,
    "a folder": folder_in_place,
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_a_file_that_is_not_what_was_written_is_computed_again(damage, tmp_path, small_files):
    first, chance = ensemble(tmp_path), np.random.default_rng(7)
    files = sorted(tmp_path.glob("*.npz"))
    contents, damage_is_random = (
        {path: path.read_bytes() for path in files},
        damage.startswith(("a ", "zeros")),
    )
    for path in [files[2]] if damage == "a folder" else files[: 5 if damage_is_random else 1]:
        DAMAGE[damage](path, [file for file in files if file != path], chance)
        reloaded = ensemble(tmp_path)
        assert np.array_equal(np.asarray(reloaded), np.asarray(first)) and np.all(reloaded.success)
        reported = "4 loaded, 1 computed, 1 of them again, since a file was damaged" in repr(
            reloaded
        )
        assert reported or damage in ("a bit", "zeros", "an addition")  # which may change nothing
        if path.is_file():
            path.write_bytes(contents[path])
            assert ensemble(tmp_path).files == "files: 5 loaded, 0 computed"


def test_the_name_of_a_file_alone_is_not_believed(tmp_path, small_files):
    first = ensemble(tmp_path)
    original, *files = sorted(tmp_path.glob("*.npz"))
    request, content = original.name.partition("-")[0], original.read_bytes()
    for path in (original, *files):
        path.unlink()
    for members in ("256-0", "0-0", "5-6", "0-3", "0-100000"):
        (tmp_path / f"{request}-{members}.npz").write_bytes(content)
    recomputed = ensemble(tmp_path)
    assert np.array_equal(np.asarray(recomputed), np.asarray(first)) and np.all(recomputed.success)
    assert recomputed.files.startswith("files: 0 loaded, 5 computed")


# ---------------------------------------------------------------- who writes, and where


def test_processes_that_began_at_once_may_have_files_of_other_sizes(tmp_path, monkeypatch):
    ends = []
    for members in (8, 16):
        set_chunk_size(monkeypatch, members)
        ends.append(ensemble(tmp_path / str(members)))
        shutil.copytree(tmp_path / str(members), tmp_path / "both", dirs_exist_ok=True)
    assert np.array_equal(*ends) and len(list((tmp_path / "both").iterdir())) == 5 + 2
    assert ensemble(tmp_path / "both").files == "files: 3 loaded, 0 computed"


def test_many_threads_may_begin_one_folder(tmp_path):
    def begin(_):
        for _ in range(20):
            folders.Folder(tmp_path / "new", (), {"q": np.zeros(1)}, None).make_writable()

    with ThreadPoolExecutor(4) as pool:
        list(pool.map(begin, range(4)))
    assert not list((tmp_path / "new").iterdir())


def test_a_folder_that_cannot_be_written_is_refused_before_any_work(tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(engine._Work, "computed", lambda *arguments: pytest.fail("worked"))
    monkeypatch.setattr(folders, "write_whole", refuse)
    with pytest.raises(ValueError, match=r"folder must be one that can be written.*Permission"):
        ensemble(tmp_path / "new")


def test_a_complete_folder_is_read_where_nothing_can_be_written(tmp_path, monkeypatch):
    first = ensemble(tmp_path)
    monkeypatch.setattr(folders, "write_whole", lambda *arguments: pytest.fail("written"))
    assert np.array_equal(np.asarray(ensemble(tmp_path)), np.asarray(first))


@pytest.mark.parametrize(
    ("seconds", "members", "expected"),
    [(1e-5, 10**7, 100_000), (1e-5, 10**5, 12_504), (1e-5, 1000, 256), (1.0, 1000, 64)],
)
def test_a_chunk_takes_a_second_or_less_where_workers_share_few(seconds, members, expected):
    assert schedule.members_of_a_chunk(seconds, 100.0, members, 2) == expected


def test_the_states_that_a_function_is_given_count_as_memory(monkeypatch):
    sizes = []

    def members_of_a_chunk(seconds, size, members, workers):
        sizes.append(size)
        return 64

    monkeypatch.setattr(engine, "members_of_a_chunk", members_of_a_chunk)
    for keep in (galvi.FinalStates(), compiled):
        ensemble(None, 80, keep=keep)
    assert sizes[1] - sizes[0] == 8 * (4 * 4 - 2)  # all states, and two numbers kept, not four


def test_what_travels_is_text_and_numbers():
    sent = []

    class RemoteExecutor(ThreadPoolExecutor):
        def submit(self, function, chunk):
            sent.append(pickle.dumps(chunk))
            return super().submit(function, pickle.loads(sent[-1]))

    with RemoteExecutor(1) as executor:
        assert np.array_equal(ensemble(members=16, executor=executor), ensemble(members=16))
    assert b"def law" in sent[0] or b"law = " in sent[0]
    assert b"Dispatcher" not in sent[0] and b"galvi.problem" not in sent[0]


# ---------------------------------------------------------------- interrupted and killed


def test_half_a_file_is_never_left(tmp_path, monkeypatch):
    def interrupted(*paths):
        raise KeyboardInterrupt

    monkeypatch.setattr(os, "replace", interrupted)
    with pytest.raises(KeyboardInterrupt):
        ensemble(tmp_path)
    assert list(tmp_path.iterdir()) == []


def test_ctrl_c_stops_threads_and_leaves_what_is_done(tmp_path, monkeypatch, small_files):
    save, members = folders.Folder.save, []

    def save_then_interrupt(self, *arguments):
        save(self, *arguments)
        members.append(arguments[0])
        if len(members) == 3:
            raise KeyboardInterrupt

    with monkeypatch.context() as patched, pytest.raises(KeyboardInterrupt):
        patched.setattr(folders.Folder, "save", save_then_interrupt)
        ensemble(tmp_path)
    assert len(list(tmp_path.glob("*.npz"))) == 3
    assert not [t for t in threading.enumerate() if t.name.startswith("ThreadPool")]
    assert np.array_equal(ensemble(tmp_path), ensemble())


CLIENT = """
import os, signal, sys
import numpy as np
from tests.properties import test_ensemble_folder as tests

tests.set_chunk_size(__import__("pytest").MonkeyPatch(), 16)
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
tests.ensemble(folder, 2000, 300)
"""


@pytest.mark.slow(beside="test_half_a_file_is_never_left")
def test_fifty_kills_lose_and_change_nothing(tmp_path, monkeypatch):
    """25 kills of a client at any time, 20 in the middle of a file, and 5 of workers."""
    set_chunk_size(monkeypatch, 16)
    chance, truth, kills = random.Random(5), ensemble(None, 2000, 300), 0
    while kills < 45:
        mid_write = chance.randint(1, 4) if kills >= 25 else 0
        files = sorted(tmp_path.glob("*.npz"))
        if len(files) > 100:  # nearly complete: delete most of them
            for path in chance.sample(files, 90):
                path.unlink()
        contents = {path: path.read_bytes() for path in tmp_path.glob("*.npz")}
        client = subprocess.Popen(
            [sys.executable, "-c", CLIENT, str(tmp_path), str(mid_write)],
            stdout=subprocess.PIPE,
            cwd=ROOT,
        )
        assert client.stdout is not None and client.stdout.readline() == b"begins\n"
        if not mid_write:
            time.sleep(chance.uniform(0.05, 0.6))
            client.kill()
        assert client.wait() in (-signal.SIGKILL, 0)
        client.stdout.close()
        kills += client.returncode == -signal.SIGKILL
        assert all(path.read_bytes() == content for path, content in contents.items())
    assert np.array_equal(ensemble(tmp_path, 2000, 300), truth)

    import dask
    from distributed import Client, LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with (
        dask.config.set({"distributed.scheduler.allowed-failures": 50}),
        LocalCluster(silence_logs=50, **options) as cluster,
        Client(cluster) as client,
        ThreadPoolExecutor(1) as pool,
    ):
        for _ in range(5):
            client.wait_for_workers(2)  # a nanny gives up on one that dies as it starts
            future = pool.submit(ensemble, None, 2000, 300, executor=client)
            time.sleep(chance.uniform(0.0, 1.0))
            victim = chance.choice([worker.pid for worker in cluster.workers.values()])
            os.kill(victim, signal.SIGKILL)
            assert np.array_equal(future.result(), truth)

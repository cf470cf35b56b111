"""A folder of an ensemble gives what would be computed now, whatever happened to its files."""

from __future__ import annotations

import concurrent.futures
import dataclasses
import fractions
import functools
import os
import shutil
import subprocess
import sys
from pathlib import Path

import numba
import numpy as np
import pytest

import galvi
from galvi.ensembles import folder as folders
from galvi.ensembles import integrate_ensemble as engine
from galvi.ensembles.folder import digest_of_galvi, identity

FOUR = galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
K = 2.0
SYSTEMS = [
    make().system for name, make in vars(galvi.problems).items()
    if callable(make) and name not in ("helmholtz", "brownout")
]  # fmt: skip


def traced():
    return galvi.Problem(galvi.Canonical(1.0, lambda q: 0.5 * K * (q @ q)), [1.0, 0.5], [0.0, 0.2])


def ensemble(folder, members=40, **options):
    problem = traced()
    v = problem.v0 * np.linspace(0.5, 1.5, members)[:, None]
    return galvi.integrate_ensemble(problem, problem.q0, v, FOUR, 0.1, 3, folder=folder, **options)


@pytest.fixture
def small_files(monkeypatch):
    """Files of eight members."""
    monkeypatch.setattr(engine, "PROBE", 8)
    monkeypatch.setattr(engine, "members_of_a_chunk", lambda *arguments: 8)


def end(run):
    return run.q[-1]


@numba.njit
def compiled(t, q, p):
    return q[-1]


class Potential:
    """A potential of the caller's that cannot be traced."""

    def __call__(self, q):
        return 0.5 * float(q[0]) ** 2


@pytest.mark.slow(beside="test_what_a_function_holds_is_told_apart_beside_its_version")
def test_values_of_galvi_are_told_apart_and_are_the_same_in_another_process():
    methods = [galvi.Galerkin(galvi.Polynomials(s), galvi.radau(s)) for s in (2, 3)]
    keeps = [galvi.FinalStates(), galvi.StatesAt([0.1]), galvi.StatesAt([0.2])]
    found = [repr(identity(value, None)) for value in (*SYSTEMS, *methods, *keeps)]
    assert len(set(found)) == len({repr(value) for value in found}) >= len(SYSTEMS) + 2
    code = (
        "from tests.properties import test_ensemble_folder as t; "
        "print([repr(t.identity(value, None)) for value in t.SYSTEMS])"
    )
    root = Path(__file__).parents[2]
    environment = os.environ | {"PYTHONHASHSEED": "7", "PYTHONPATH": str(root)}
    output = subprocess.run(
        [sys.executable, "-c", code], env=environment, cwd=root, capture_output=True, check=True,
        text=True,
    )  # fmt: skip
    assert output.stdout.splitlines()[-1] == str(found[: len(SYSTEMS)])


@pytest.mark.parametrize("keep", [end, lambda run: run.q[-1], compiled, np.sin])
def test_a_function_that_is_called_needs_a_version(keep, tmp_path):
    with pytest.raises(ValueError, match=r"what it calls cannot be known\. Give version='1'"):
        ensemble(tmp_path, keep=keep)
    assert not list(tmp_path.iterdir())


def test_so_does_a_potential_that_was_not_traced(tmp_path):
    problem = galvi.Problem(galvi.Canonical(1.0, Potential()), [1.0], [0.0])
    arguments = (problem, problem.q0, problem.v0, FOUR, 0.1, 3)
    with pytest.raises(ValueError, match=r"those of earlier code of .*Potential, since"):
        galvi.integrate_ensemble(*arguments, folder=tmp_path)
    first = galvi.integrate_ensemble(*arguments, folder=tmp_path, version="1")
    again = galvi.integrate_ensemble(*arguments, folder=tmp_path, version="1")
    assert np.array_equal(first, again) and again.files == "files: 1 loaded, 0 computed"


def test_the_version_is_part_of_the_name(tmp_path):
    for version, files in (
        ("1", "files: 0 l"),
        ("1", "files: 1 l"),
        ("2", "files: 0 l"),
    ):
        assert ensemble(tmp_path, 5, keep=end, version=version).files.startswith(files)
    with pytest.raises(TypeError, match="version must be a text, or None; received 3"):
        ensemble(tmp_path, version=3)


@dataclasses.dataclass
class Scaled:
    """The last state times a number; ``other`` is what a class of the caller's may hold."""

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
    one, other = (
        np.asarray(ensemble(tmp_path, 3, keep=make(a), version="1"), dtype=float)
        for a in (1.0, 100.0)
    )
    assert np.allclose(other, 100.0 * one) and np.any(one)
    assert ensemble(tmp_path, 3, keep=make(1.0), version="1").files == "files: 1 loaded, 0 computed"


def test_code_that_was_changed_while_this_process_runs_is_not_believed(tmp_path, monkeypatch):
    monkeypatch.setattr(folders, "IMPORTED", 0.0)
    monkeypatch.setattr(folders, "digest_of_galvi", digest_of_galvi.__wrapped__)
    with pytest.raises(ValueError, match=r"was changed after this process had imported galvi"):
        ensemble(tmp_path)


def test_many_threads_may_begin_one_folder(tmp_path):
    def begin(_):
        for _ in range(50):
            folders.Folder(tmp_path / "new", (), {"q": np.zeros(1)}, None).make_writable()

    with concurrent.futures.ThreadPoolExecutor(4) as pool:
        list(pool.map(begin, range(4)))
    assert not list((tmp_path / "new").iterdir())


def test_the_text_of_a_traced_law_is_part_of_its_work(tmp_path, monkeypatch):
    first = np.array(ensemble(tmp_path)[0])
    monkeypatch.setitem(globals(), "K", 3.0)
    assert np.array_equal(ensemble(tmp_path)[0], ensemble(None)[0])
    assert not np.array_equal(ensemble(tmp_path)[0], first)


def test_the_code_of_galvi_is_part_of_the_name(tmp_path, monkeypatch):
    place = tmp_path / "galvi" / "ensembles" / "folder.py"
    place.parent.mkdir(parents=True)
    monkeypatch.setattr(folders, "__file__", str(place))
    monkeypatch.setattr(folders, "IMPORTED", np.inf)

    def digest(code):
        place.write_text(code)
        return digest_of_galvi.__wrapped__()

    before = digest("def f(x):\n    return 2 * x\n")
    assert before == digest("def f(x):\n    return 2 * x\n")
    assert before != digest("def f(x):\n    return 3 * x\n")


def test_results_of_other_code_of_galvi_are_not_believed(tmp_path, monkeypatch):
    ensemble(tmp_path)
    monkeypatch.setattr(folders, "digest_of_galvi", lambda: "other")
    assert ensemble(tmp_path).files == "files: 0 loaded, 1 computed"


def test_parameters_with_the_names_of_starts_hide_none(tmp_path):
    import sympy

    x, vx, q = sympy.symbols("x vx q", real=True)
    system = galvi.Lagrangian.from_sympy(vx**2 / 2 - q * x**2 / 2, [x], [vx], parameters={q: 1.0})
    problem = galvi.Problem(system, [1.0], [0.0])

    def last(start):
        found = galvi.integrate_ensemble(
            problem, [[start]], problem.v0, FOUR, 0.1, 2, {"q": [2.0]}, folder=tmp_path
        )
        return found[0][0, 0]

    assert last(1.0) == pytest.approx(0.5 * last(2.0), rel=1e-12)


@pytest.mark.parametrize("keep", [galvi.StatesAt([]), lambda run: np.zeros(0)])
def test_values_without_entries_are_kept_too(keep, tmp_path):
    shapes = {ensemble(tmp_path, 3, keep=keep, version="1").kept[0].shape for _ in range(2)}
    assert shapes == {ensemble(None, 3, keep=keep).kept[0].shape}


def row_less(arrays):
    return {name: array[1:] if array.ndim else array for name, array in arrays.items()}


ODD = {
    "a row less": row_less,
    "no passes": lambda arrays: {name: arrays[name] for name in arrays if name != "passes"},
    "another column": lambda arrays: {**arrays, "more": arrays["passes"]},
    "no digest": lambda arrays: {name: arrays[name] for name in arrays if name != "digest"},
    "other outcomes": lambda arrays: {**arrays, "outcomes": np.array("[]")},
    "objects": lambda arrays: {**arrays, "passes": arrays["passes"].astype(object)},
    "float32": lambda arrays: {**arrays, "value0": arrays["value0"].astype(np.float32)},
    "another number": lambda arrays: {**arrays, "passes": np.arange(len(arrays["passes"]))},
}


@pytest.mark.parametrize("damage", ODD)
def test_a_file_that_is_not_what_was_written_is_computed_again(damage, tmp_path, small_files):
    first = ensemble(tmp_path)
    path = sorted(tmp_path.glob("*.npz"))[1]
    with np.load(path) as file:
        arrays = dict(file)
    np.savez(path, **ODD[damage](arrays))
    again = ensemble(tmp_path)
    assert np.array_equal(np.asarray(again), np.asarray(first))
    assert "files: 4 loaded, 1 computed, 1 of them again, since a file was damaged" in repr(again)
    assert ensemble(tmp_path).files == "files: 5 loaded, 0 computed"


def damaged(path, others, chance):
    """One of the ways in which a file is damaged; returns which."""
    content, kind = bytearray(path.read_bytes()), chance.integers(8)
    if kind <= 2:
        content[chance.integers(len(content))] ^= 1 << int(chance.integers(8))
    elif kind == 3:
        content = content[: chance.integers(len(content))]
    elif kind == 4:
        first, size = chance.integers(len(content)), int(chance.integers(1, 200))
        content[first : first + size] = bytes(len(content[first : first + size]))
    elif kind == 5:
        content += content[: chance.integers(1, len(content))]
    if kind <= 5:
        path.write_bytes(content)
    elif kind == 6:
        shutil.copyfile(others[chance.integers(len(others))], path)
    else:
        path.unlink()
        path.mkdir()
    return int(kind)


@pytest.mark.slow(beside="test_a_file_that_is_not_what_was_written_is_computed_again")
def test_no_damage_is_believed(tmp_path, small_files):
    """Five hundred random damages: bits, cuts, zeros, additions, files of others, folders."""
    chance, first = np.random.default_rng(7), np.asarray(ensemble(tmp_path))
    files = sorted(tmp_path.glob("*.npz"))
    known = {path: path.read_bytes() for path in files}
    kinds = set()
    for _ in range(500):
        path = files[chance.integers(len(files))]
        kinds.add(damaged(path, [one for one in files if one != path], chance))
        again = ensemble(tmp_path)
        assert np.array_equal(np.asarray(again), first) and np.all(again.success)
        if path.is_dir():
            path.rmdir()
        path.write_bytes(known[path])
    assert len(kinds) == 8


def test_the_name_of_a_file_alone_is_not_believed(tmp_path, small_files):
    first = ensemble(tmp_path)
    some, *others = sorted(tmp_path.glob("*.npz"))
    request, content = some.name.partition("-")[0], some.read_bytes()
    for path in (some, *others):
        path.unlink()
    for members in ("256-0", "0-0", "5-6", "0-3", "0-100000"):
        (tmp_path / f"{request}-{members}.npz").write_bytes(content)
    again = ensemble(tmp_path)
    assert np.array_equal(np.asarray(again), np.asarray(first)) and np.all(again.success)
    assert again.files.startswith("files: 0 loaded, 5 computed")


def test_processes_that_began_at_once_may_have_files_of_other_sizes(tmp_path, monkeypatch):
    sizes = iter((8, 16))
    monkeypatch.setattr(engine, "PROBE", 8)
    monkeypatch.setattr(engine, "members_of_a_chunk", lambda *arguments: next(sizes))
    with monkeypatch.context() as patched:
        patched.setattr(folders.Folder, "members_of_a_file", lambda self: 0)
        first, second = ensemble(tmp_path), ensemble(tmp_path)
    assert np.array_equal(first, second) and len(list(tmp_path.iterdir())) == 5 + 2
    assert ensemble(tmp_path).files == "files: 3 loaded, 0 computed"


def test_a_folder_in_place_of_a_file_is_named(tmp_path, small_files):
    """It cannot be replaced by a file, which is said before any work."""
    ensemble(tmp_path)
    path = sorted(tmp_path.glob("*.npz"))[2]
    path.unlink()
    (path / "inside").mkdir(parents=True)
    assert ensemble(tmp_path).files.endswith("1 of them again, since a file was damaged")


def test_a_folder_that_cannot_be_written_is_refused_before_any_work(tmp_path, monkeypatch):
    def refuse(*arguments, **options):
        raise PermissionError(13, "Permission denied")

    monkeypatch.setattr(engine._Work, "computed", lambda *arguments: pytest.fail("worked"))
    monkeypatch.setattr(folders, "write_whole", refuse)
    with pytest.raises(ValueError, match=r"folder must be one that can be written.*Permission"):
        ensemble(tmp_path / "new")


def test_a_complete_folder_is_read_where_nothing_can_be_written(tmp_path, monkeypatch):
    first = ensemble(tmp_path)
    monkeypatch.setattr(Path, "touch", lambda *arguments: pytest.fail("written"))
    assert np.array_equal(np.asarray(ensemble(tmp_path)), np.asarray(first))


@pytest.mark.parametrize("mask", [0o077, 0o022, 0o002])
def test_files_have_the_permissions_of_the_umask(mask, tmp_path):
    before = os.umask(mask)
    try:
        ensemble(tmp_path, 3)
        run = galvi.integrate(traced(), FOUR, 0.1, 3)
        galvi.save(run, tmp_path / "run.npz")
    finally:
        os.umask(before)
    modes = {path.stat().st_mode & 0o777 for path in tmp_path.iterdir()}
    assert modes == {0o666 & ~mask}

"""Compiled kernels on disk: missing, stale, damaged, not writeable, or written by two at once."""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import time
import zipfile
from pathlib import Path

import llvmlite
import numba
import pytest
from numba.core import caching
from numba.core.serialize import dumps

import galvi
from galvi.kernels.compile import cache
from galvi.kernels.compile.jit import jit

RUN = """
import hashlib, galvi
kepler, method = galvi.problems.kepler(0.6), galvi.Galerkin(galvi.Polynomials(4), galvi.gauss(4))
run = galvi.integrate(kepler, method, 0.1, 20)
print(hashlib.sha256(run.q.tobytes()).hexdigest(), run.counts)
"""
SMALL = """
import sys
sys.path.insert(0, {folder!r})
import small
print(small.kernel(2.0), small.kernel(3))
"""


def kernel(x):
    """What is compiled here; any function will do."""
    return x * x + 1.0


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, and the only one where anything can be kept."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    only = [caching.UserProvidedCacheLocator]
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", only)
    return tmp_path


def compiled_anew(function):
    """Whether another process would have to compile the function; its value is checked."""
    dispatcher = jit(function)
    assert dispatcher(3.0) == function(3.0)
    return not dispatcher.stats.cache_hits


def kept(folder):
    return [path for path in folder.rglob("*") if path.is_file()]


def test_what_is_missing_is_compiled_and_kept_for_the_next_process(folder):
    assert compiled_anew(kernel)
    assert len(kept(folder)) == 1
    assert not compiled_anew(kernel)


OTHER = "0123456789abcdef" * 4
REAL = cache.stamp


@pytest.mark.parametrize(
    "stamp", [lambda *files: OTHER, lambda *files: OTHER if files else REAL()],
    ids=["other kernels", "other file"],
)  # fmt: skip
def test_what_other_sources_left_is_neither_loaded_nor_kept(folder, monkeypatch, stamp):
    monkeypatch.setattr(cache, "stamp", stamp)
    assert compiled_anew(kernel)
    (stale,) = kept(folder)
    monkeypatch.undo()
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder))
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    assert len(kept(folder)) == 1 and not stale.exists()
    assert len(list(folder.glob("*/*"))) == 1


def test_what_a_function_left_that_moved_or_went_is_not_kept(tmp_path):
    def saved(name, kernels, source):
        files = cache.StampedFiles(tmp_path, name, kernels * 64, source * 64)
        files.save("int", name)
        return files.path("int")

    saved("laws.gone-3.py311", "0", "a"), saved("laws.moved-9.py311", "0", "a")
    saved("laws.moved-7.py311", "1", "b"), saved("laws.other-20.py311", "1", "b")
    assert [path.name[:9] for path in sorted(kept(tmp_path))] == ["laws.move", "laws.othe"]
    others = [saved("maps.one-1.py311", "1", "c"), saved("laws2.one-1.py311", "1", "d")]
    last = saved("laws.moved-8.py311", "1", "e")
    assert sorted(kept(tmp_path)) == sorted([*others, last])
    module = tmp_path / "galvi-kernels.cpython-311.pyc"
    module.touch()
    saved("laws.moved-8.py311", "2", "e")
    assert len(kept(tmp_path)) == 2 and module.exists()


def test_what_an_ended_process_left_half_written_is_removed_after_an_hour(tmp_path):
    files = cache.StampedFiles(tmp_path, "laws.one-1.py311", "0" * 64, "0" * 64)
    files.save("int", 1)
    old, new = (files.place / f"maps.one-1.py311.{name}.part" for name in ("old", "new"))
    old.touch(), new.touch()
    os.utime(old, (time.time() - cache.HOUR - 60,) * 2)
    files.save("int", 2)
    assert sorted(kept(tmp_path)) == sorted([files.path("int"), new])


def test_the_stamp_is_of_every_kernel(tmp_path, monkeypatch):
    for name in ("cache.py", "one.py", "two.py"):
        (tmp_path / name).write_text(name)
    monkeypatch.setattr(cache, "__file__", str(tmp_path / "cache.py"))
    stamp = cache.stamp.__wrapped__
    before = stamp(tmp_path / "one.py")
    assert stamp(tmp_path / "one.py") == before != stamp(tmp_path / "two.py")
    (tmp_path / "two.py").write_text("changed")
    assert stamp(tmp_path / "one.py") != before


DAMAGE = {
    "truncated": lambda whole: whole[: len(whole) // 2],
    "empty": lambda whole: b"",
    "one bit turned": lambda whole: whole[:-100] + bytes([whole[-100] ^ 1]) + whole[-99:],
    "something else": lambda whole: b"no kernel",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_damaged_is_compiled_anew_and_mended(folder, damage):
    compiled_anew(kernel)
    (path,) = kept(folder)
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    assert compiled_anew(kernel)
    assert not compiled_anew(kernel)


class Unreadable:
    """A pickle that raises what no reader of files expects."""

    def __reduce__(self):
        return _raises, ()


def _raises():
    raise LookupError("no such class in this version")


WHOLE = {
    "no pickle": b"no pickle",
    "no such class": dumps(Unreadable()),
    "another format": dumps(("of", "another", "version")),
}


@pytest.mark.parametrize("code", WHOLE)
def test_what_is_whole_and_cannot_be_read_is_compiled_anew_and_mended(folder, code):
    compiled_anew(kernel)
    (path,) = kept(folder)
    path.write_bytes(hashlib.sha256(WHOLE[code]).digest() + WHOLE[code])
    assert compiled_anew(kernel)
    assert not compiled_anew(kernel)


@pytest.mark.parametrize("library", [0, 1])
def test_what_another_compiler_made_is_not_loaded(folder, monkeypatch, library):
    compiled_anew(kernel)
    versions = list(cache.VERSIONS)
    assert versions == [numba.__version__, llvmlite.__version__]
    versions[library] += ".1"
    monkeypatch.setattr(cache, "VERSIONS", tuple(versions))
    assert compiled_anew(kernel) and not compiled_anew(kernel)


def test_without_sources_to_read_every_process_compiles(folder, monkeypatch):
    def unreadable(*files):
        raise NotADirectoryError("in a zip file")

    monkeypatch.setattr(cache, "stamp", unreadable)
    assert compiled_anew(kernel) and compiled_anew(kernel)
    assert kept(folder) == []


def test_galvi_is_imported_from_a_zip_file(tmp_path):
    whole = tmp_path / "galvi.zip"
    with zipfile.ZipFile(whole, "w") as packed:
        for path in Path(galvi.__file__).parent.rglob("*.py"):
            packed.write(path, path.relative_to(Path(galvi.__file__).parents[1]))
    code = f"import sys; sys.path.insert(0, {str(whole)!r}); import galvi; print(galvi.__file__)"
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert done.stdout.startswith(str(whole)), done.stderr


def test_numbas_own_cache_would_have_stopped_the_run(folder):
    """The planted fault: what the tests above would find without galvi's own files."""
    numba.njit(cache=True)(kernel)(3.0)
    for path in kept(folder):
        path.write_bytes(DAMAGE["truncated"](path.read_bytes()))
    with pytest.raises(Exception, match=r"truncated|Ran out of input|pickle"):
        numba.njit(cache=True)(kernel)(3.0)


def test_without_a_folder_to_write_every_process_compiles(folder, monkeypatch):
    (folder / "file").touch()
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(folder / "file" / "below"))
    assert compiled_anew(kernel) and compiled_anew(kernel)
    with pytest.raises(RuntimeError, match="no locator available"):
        numba.njit(cache=True)(kernel)


def test_a_folder_that_is_lost_before_the_first_call_stops_nothing(folder):
    dispatcher = jit(kernel)
    (place,) = folder.iterdir()
    shutil.rmtree(place)
    place.touch()
    assert dispatcher(3.0) == 10.0
    assert kept(folder) == [place]


def test_a_write_that_fails_half_way_leaves_nothing(folder, monkeypatch):
    def full(path, target):
        raise OSError("no space left on device")

    monkeypatch.setattr(Path, "replace", full)
    assert compiled_anew(kernel)
    assert kept(folder) == []


def test_two_who_write_at_once_do_not_exchange_their_code(tmp_path):
    name, stamps = "kernel.one-1.py311", ("0" * 64, "1" * 64)
    one, two = (cache.StampedFiles(tmp_path, name, *stamps) for _ in range(2))
    assert one.load("int") is None and two.load("float") is None
    one.save("int", "code for int")
    two.save("float", "code for float")
    assert [one.load("float"), two.load("int")] == ["code for float", "code for int"]
    one.flush()
    assert two.load("int") is None and kept(tmp_path) == []


def at_once(code, cache_folder, **more):
    """What two new processes print that share a folder for compiled code."""
    settings = os.environ | {"NUMBA_CACHE_DIR": str(cache_folder)} | more
    both = [
        subprocess.Popen([sys.executable, "-c", code], env=settings, text=True,
                         stdout=subprocess.PIPE, stderr=subprocess.PIPE)
        for _ in range(2)
    ]  # fmt: skip
    told = [process.communicate(timeout=600) for process in both]
    assert [process.returncode for process in both] == [0, 0], told
    return [out for out, _ in told]


def test_two_processes_compile_at_once(tmp_path):
    source = (
        "from galvi.kernels.compile.jit import jit\n@jit\ndef kernel(x):\n    return x * x + 1.0\n"
    )
    (tmp_path / "small.py").write_text(source)
    code = SMALL.format(folder=str(tmp_path))
    assert at_once(code, tmp_path / "cache") == ["5.0 10.0\n"] * 2
    files = sorted(kept(tmp_path / "cache"))
    assert len(files) == 2  # one for each type
    assert at_once(code, tmp_path / "cache") == ["5.0 10.0\n"] * 2
    assert sorted(kept(tmp_path / "cache")) == files


@pytest.mark.slow
def test_runs_are_the_same_with_any_cache(tmp_path):
    """The whole kernel: two at once from nothing, then damaged files, then no folder at all."""
    with_cache = at_once(RUN, tmp_path / "cache")
    for path in kept(tmp_path / "cache"):
        path.write_bytes(path.read_bytes()[:-1])
    damaged = at_once(RUN, tmp_path / "cache")
    (tmp_path / "file").touch()
    only = {"NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    without = at_once(RUN, tmp_path / "file" / "below", **only)
    assert len({*with_cache, *damaged, *without}) == 1

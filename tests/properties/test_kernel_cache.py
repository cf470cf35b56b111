"""Compiled kernels on disk: missing, stale, damaged, not writeable, or written by two at once."""

import os
import shutil
import subprocess
import sys
import threading
import time
from collections import Counter
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


def kernel(x):
    """A function to compile."""
    return x * x + 1.0


FILE_LOCK = cache.file_lock


class NoLock:
    """A lock that is never held."""

    def __init__(self, path):
        self.acquire = self.release = lambda: None


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """An empty folder, which is the only place for compiled code."""
    monkeypatch.setattr(numba.config, "CACHE_DIR", str(tmp_path))
    only = [caching.UserProvidedCacheLocator]
    monkeypatch.setattr(caching.CacheImpl, "_locator_classes", only)
    monkeypatch.setattr(cache, "file_lock", NoLock)
    return tmp_path


def compiled_anew(function):
    """Whether the function is compiled and not loaded by a new dispatcher; asserts its value."""
    dispatcher = jit(function)
    assert dispatcher(3.0) == function(3.0)
    return not dispatcher.stats.cache_hits


def files_in(folder):
    return [path for path in folder.rglob("*") if path.is_file()]


def test_what_is_missing_is_compiled_and_kept_for_the_next_process(folder):
    assert compiled_anew(kernel)
    assert len(files_in(folder)) == 1
    assert not compiled_anew(kernel)


STALE = {
    "other sources": ("stamp", lambda *files: "0123456789abcdef" * 4),
    "another numba": ("VERSIONS", (f"{numba.__version__}.1", llvmlite.__version__)),
    "another llvmlite": ("VERSIONS", (numba.__version__, f"{llvmlite.__version__}.1")),
}


@pytest.mark.parametrize("stale_kind", STALE)
def test_what_another_compiler_made_or_of_other_sources_is_neither_loaded_nor_kept(
    folder, monkeypatch, stale_kind
):
    assert (numba.__version__, llvmlite.__version__) == cache.VERSIONS
    with monkeypatch.context() as patched:
        patched.setattr(cache, *STALE[stale_kind])
        assert compiled_anew(kernel)
    (path,) = files_in(folder)
    code = path.read_bytes()
    assert compiled_anew(kernel) and not compiled_anew(kernel)
    assert files_in(folder) == [path] and path.read_bytes() != code


KERNELS = {
    "kernels/compile/jit.py": "",
    "kernels/lie/__init__.py": "",
    "kernels/lie/arithmetic.py": "from galvi.kernels.compile.jit import jit\n",
    "kernels/lie/maps/__init__.py": "",
    "kernels/lie/maps/one.py": "from galvi.kernels.lie.arithmetic import (\n    dot,\n)\n",
    "kernels/lie/choice.py": "from galvi.kernels.lie import maps\n",
    "lanes/step.py": "from galvi.kernels.lie import arithmetic, choice\n",
    "lanes/law.py": "from galvi.lanes.step import steps\n",
    "lanes/other.py": "import numpy\n",
}
CALLED_BY_STEP = {*KERNELS} - {
    "lanes/step.py",
    "lanes/law.py",
    "lanes/other.py",
    "kernels/lie/__init__.py",
}
CALLED = {  # file -> the other kernels that it may call
    "kernels/lie/arithmetic.py": {"kernels/compile/jit.py"},
    "kernels/lie/choice.py": {
        "kernels/lie/maps/__init__.py",
        "kernels/lie/maps/one.py",
        "kernels/lie/arithmetic.py",
        "kernels/compile/jit.py",
    },
    "lanes/step.py": CALLED_BY_STEP,
    "lanes/law.py": CALLED_BY_STEP | {"lanes/step.py"},
    "lanes/other.py": set(),
    "user.py": {*KERNELS},
    "kernels/lie/__pycache__/galvi-expressions/0/expression.source": {*KERNELS},
}


@pytest.fixture
def few_kernels(tmp_path, monkeypatch):
    """A folder with KERNELS in place of galvi's; functions that cache its contents do not."""
    galvi_folder = tmp_path / "galvi"
    for name, text in KERNELS.items():
        (galvi_folder / name).parent.mkdir(parents=True, exist_ok=True)
        (galvi_folder / name).write_text(text)
    monkeypatch.setattr(cache, "__file__", str(galvi_folder / "kernels/compile/cache.py"))
    for name in ("content", "kernels", "sources", "imported", "stamp"):
        monkeypatch.setattr(cache, name, getattr(cache, name).__wrapped__)
    return galvi_folder


@pytest.mark.parametrize("changed", KERNELS)
def test_an_edit_compiles_anew_what_may_call_it_and_nothing_else(few_kernels, changed):
    def stamps():
        files = {name: few_kernels / name for name in CALLED} | {"user.py": few_kernels.parent}
        return {name: cache.stamp(*cache.sources(str(path))) for name, path in files.items()}

    before = stamps()
    with (few_kernels / changed).open("a") as file:
        file.write("# changed")
    after = stamps()
    stale = {name for name in CALLED if after[name] != before[name]}
    assert stale == {name for name in CALLED if changed in CALLED[name] | {name}}


@pytest.mark.slow(beside="test_an_edit_compiles_anew_what_may_call_it_and_nothing_else")
def test_a_file_that_changes_in_a_running_process_is_still_the_one_that_was_imported(tmp_path):
    """Code imported before an edit must not be stored as that of the edited file."""
    package, without = Path(galvi.__file__).parent, shutil.ignore_patterns("__pycache__")
    shutil.copytree(package, tmp_path / "galvi", ignore=without)
    edit = """
import sys
from pathlib import Path
import galvi
from galvi.kernels.compile import cache
laws = Path(galvi.__file__).parent / "lanes/laws.py"
laws.write_text(laws.read_text() + "# changed")
print(cache.stamp(*cache.sources("generated")))
"""
    stamps = [
        subprocess.run(
            [sys.executable, "-c", code],
            cwd=tmp_path,
            text=True,
            capture_output=True,
            check=True,
            env={**os.environ, "PYTHONPATH": str(tmp_path)},
        ).stdout
        for code in (edit.replace("laws.write", "None and laws.write"), edit, edit)
    ]
    assert stamps[0] == stamps[1] != stamps[2]


def test_the_imports_read_from_the_sources_are_those_of_the_interpreter():
    """Each name of a kernel that comes from another kernel has that file among its sources."""
    root, checked = Path(galvi.__file__).parent, Counter()
    folders = [root / name_of_folder for name_of_folder in cache.KERNEL_FOLDERS]
    for name, module in list(sys.modules.items()):
        file = Path(getattr(module, "__file__", None) or "/")
        (kernel_folder,) = [top for top in folders if top in file.parents] or [None]
        if kernel_folder is not None and file.name != "__init__.py":
            files = cache.sources(module.__file__)
            for value in vars(module).values():
                source_module = sys.modules.get(
                    getattr(getattr(value, "py_func", value), "__module__", "")
                )
                source_path = Path(getattr(source_module, "__file__", None) or "/")
                if any(top in source_path.parents for top in folders):
                    assert source_path in files, (name, source_module.__name__)
                    checked[kernel_folder] += 1
    assert all(checked[top] > 100 for top in folders), checked


DAMAGE = {
    "truncated": lambda content: content[: len(content) // 2],
    "empty": lambda content: b"",
    "one bit turned": lambda content: content[:-100] + bytes([content[-100] ^ 1]) + content[-99:],
    "something else": lambda content: b"no kernel",
}


@pytest.mark.parametrize("damage", DAMAGE)
def test_what_is_damaged_is_compiled_anew_and_mended(folder, damage):
    compiled_anew(kernel)
    (path,) = files_in(folder)
    path.write_bytes(DAMAGE[damage](path.read_bytes()))
    assert compiled_anew(kernel)
    assert not compiled_anew(kernel)


class Unreadable:
    """A pickle that raises LookupError when it is read."""

    def __reduce__(self):
        return _raises, ()


def _raises():
    raise LookupError("no such class in this version")


UNREADABLE_CODE = {
    "no pickle": b"no pickle",
    "no such class": dumps(Unreadable()),
    "another format": dumps(("of", "another", "version")),
}


@pytest.mark.parametrize("code", UNREADABLE_CODE)
def test_what_is_whole_and_cannot_be_read_is_compiled_anew_and_mended(folder, monkeypatch, code):
    compiled_anew(kernel)
    (path,) = files_in(folder)
    monkeypatch.setattr(cache.KernelFiles, "_digest", lambda *arguments: bytes(cache.DIGEST_BYTES))
    path.write_bytes(bytes(cache.DIGEST_BYTES) + UNREADABLE_CODE[code])
    assert compiled_anew(kernel)
    assert not compiled_anew(kernel)


def test_without_sources_to_read_every_process_compiles(folder, monkeypatch):
    def unreadable(*files):
        raise NotADirectoryError("in a zip file")

    monkeypatch.setattr(cache, "stamp", unreadable)
    assert compiled_anew(kernel) and compiled_anew(kernel)
    assert files_in(folder) == []


def test_numbas_own_cache_would_have_stopped_the_run(folder):
    """Planted: numba's cache in place of galvi's."""
    numba.njit(cache=True)(kernel)(3.0)
    for path in files_in(folder):
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
    (cache_path,) = folder.iterdir()
    shutil.rmtree(cache_path)
    cache_path.touch()
    assert dispatcher(3.0) == 10.0
    assert files_in(folder) == [cache_path]


@pytest.mark.parametrize("partly_written", [False, True])
def test_a_write_that_fails_leaves_nothing(folder, monkeypatch, partly_written):
    def fail_to_write(path, content):
        if partly_written:
            path.write_text("half of it")
        raise OSError("no space left on device")

    monkeypatch.setattr(Path, "write_bytes", fail_to_write)
    assert compiled_anew(kernel)
    assert files_in(folder) == []


def test_each_signature_and_kind_of_processor_has_its_own_file(tmp_path):
    writer, reader = (cache.KernelFiles(tmp_path, "kernel.one", "0" * 64) for _ in range(2))
    keys = [("int", "haswell", 1), ("float", "haswell", 1), ("int", "generic", 1)]
    for key in keys:
        writer.save(key, key)
    assert [reader.load(key) for key in keys] == keys
    assert writer.load(("int", "haswell", 2)) is None  # another bytecode
    assert len(files_in(tmp_path)) == 3


HOLDER = """
import sys
import filelock
lock = filelock.FileLock(sys.argv[1])
lock.acquire()
print("taken", flush=True)
sys.stdin.read()
"""


def test_who_comes_second_waits_for_the_first_and_loads_what_it_kept(folder, monkeypatch):
    """The code appears while the process waits, which loads it once the first process is killed."""
    assert compiled_anew(kernel)
    (path,) = files_in(folder)
    code = path.read_bytes()
    path.unlink()
    monkeypatch.setattr(cache, "file_lock", FILE_LOCK)
    command = [sys.executable, "-c", HOLDER, str(path.with_suffix(".lock"))]
    with subprocess.Popen(
        command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as holder:
        assert holder.stdout is not None and holder.stdout.readline() == "taken\n"

        def write_code_and_kill():
            path.write_bytes(code)
            holder.kill()

        timer = threading.Timer(0.3, write_code_and_kill)
        timer.start()
        start_seconds = time.monotonic()
        assert not compiled_anew(kernel)
        assert time.monotonic() - start_seconds >= 0.29
        timer.join()


def test_nobody_waits_longer_than_patience(folder, monkeypatch):
    monkeypatch.setattr(cache, "file_lock", FILE_LOCK)
    monkeypatch.setattr(cache, "LOCK_SECONDS", 0.1)
    first = jit(kernel)
    assert first(3.0) == 10.0
    (path,) = folder.rglob("*.nbc")
    path.unlink()
    lock = cache.file_lock(path.with_suffix(".lock"))
    lock.acquire()
    assert compiled_anew(kernel) and path.exists()
    lock.release()


def test_a_function_that_cannot_be_compiled_holds_nobody_up(folder, monkeypatch):
    acquired = []

    class Lock:
        def __init__(self, path):
            self.acquire, self.release = lambda: acquired.append(path), acquired.clear

    monkeypatch.setattr(cache, "file_lock", Lock)
    wrong = jit(lambda x: x.no_such_attribute)
    with pytest.raises(numba.TypingError):
        wrong(1.0)
    assert acquired == []


def outputs_of_two_processes(code, cache_folder, **variables):
    """The outputs of two new processes that share a folder for compiled code."""
    settings = os.environ | {"NUMBA_CACHE_DIR": str(cache_folder)} | variables
    processes = [
        subprocess.Popen(
            [sys.executable, "-c", code],
            env=settings,
            text=True,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
        )
        for _ in range(2)
    ]
    outputs = [process.communicate(timeout=600) for process in processes]
    assert [process.returncode for process in processes] == [0, 0], outputs
    return [out for out, _ in outputs]


@pytest.mark.slow(beside="test_what_is_damaged_is_compiled_anew_and_mended")
def test_runs_are_the_same_with_any_cache(tmp_path):
    """The whole kernel: two at once from nothing, then damaged files, then no folder at all."""
    with_cache = outputs_of_two_processes(RUN, tmp_path / "cache")
    for path in files_in(tmp_path / "cache"):
        path.write_bytes(path.read_bytes()[:-1])
    damaged = outputs_of_two_processes(RUN, tmp_path / "cache")
    (tmp_path / "file").touch()
    only = {"NUMBA_CACHE_LOCATOR_CLASSES": "UserProvidedCacheLocator"}
    without = outputs_of_two_processes(RUN, tmp_path / "file" / "below", **only)
    assert len({*with_cache, *damaged, *without}) == 1

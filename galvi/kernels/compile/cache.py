"""A cache of compiled kernels on disk that detects stale and damaged files and never stops a run.

numba's own cache checks only the file that defines a function, not those of the functions it calls;
it raises when a file is damaged or its folder is not writable; and two processes that write at the
same time may exchange their code. Here each file starts with a digest of its code and of everything
the code depends on. A kernel whose file is missing, stale, damaged or unwritable is compiled again,
by one process while the others wait. A kernel depends on its file and on those that it imports,
directly or not, so that after an edit only the kernels that may call the edited code are compiled.

The digest is not a signature: as with numba, anyone with write access to the folder can run code.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import re
import sys
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba

from galvi.kernels.compile.internals import FunctionCache, dumps

DIGEST_BYTES = 32  # length of SHA-256
KERNELS_FOLDER = "galvi-kernels"
IMPORTS = re.compile(
    r"^from galvi\.((?:kernels|lanes)(?:\.[\w.]+)?) import (\([^)]*\)|.*)", re.MULTILINE
)
KERNEL_FOLDERS = ("kernels", "lanes")  # folders of galvi with kernels
VERSIONS = (numba.__version__, llvmlite.__version__)

LOCK_SECONDS = 180.0  # more than the longest compilation takes on a busy machine


def file_lock(path: Path) -> Any:
    """A lock between processes, which the end of its process releases; ``acquire`` raises OSError
    after LOCK_SECONDS."""
    import filelock  # takes 0.1 s, and only compilation needs it

    return filelock.FileLock(path, timeout=LOCK_SECONDS)


@cache
def content(path):
    """The bytes of a file, read once, so that they are those of the code that the process imported.

    Raises
    ------
    OSError
        If the file cannot be read.
    """
    return path.read_bytes()


@cache
def kernels():
    """The paths of the sources of all kernels, sorted."""
    paths = []
    for top in KERNEL_FOLDERS:
        for folder, folders, names in os.walk(Path(__file__).parents[2] / top):
            folders[:] = [name for name in folders if name != "__pycache__"]
            paths += [Path(folder, name) for name in names if name.endswith(".py")]
    return tuple(sorted(paths))


for _path in kernels():  # before any of them can change
    content(_path)


@cache
def stamp(*files):
    """A digest of the contents of files; raises OSError if a file cannot be read."""
    digest = hashlib.sha256()
    for path in files:
        digest.update(content(Path(path)))
    return digest.hexdigest()


@cache
def sources(file):
    """The kernel sources that functions of a file may call: itself, and its imports, recursively.

    For a file outside the kernels, such as generated code, all kernel sources, and, if it is a
    module of a package, the modules of the package. Raises OSError if a file cannot be read.
    """
    path = Path(file)
    if path not in kernels():
        beside = path.parent.glob("*.py") if (path.parent / "__init__.py").exists() else ()
        return (*kernels(), *sorted(beside))
    visited: set[Path] = set()
    pending = {path}
    while pending:
        visited |= pending
        pending = set().union(*(imported(source) for source in pending)) - visited
    return tuple(sorted(visited))


@cache
def imported(path):
    """The kernel sources that the kernel source ``path`` imports; all modules of a package."""
    top = Path(__file__).parents[2]
    paths: set[Path] = set()
    for module, names in IMPORTS.findall(content(path).decode()):
        package = top.joinpath(*module.split("."))
        for name in re.findall(r"\w+", names):
            module_path = package / name
            if module_path.is_dir():
                paths.update(kernel for kernel in kernels() if module_path in kernel.parents)
            else:
                files = (
                    module_path.with_suffix(".py"),
                    package.with_suffix(".py"),
                    package / "__init__.py",
                )
                paths.add(next(candidate for candidate in files if candidate.is_file()))
    return paths


class KernelFiles:
    """The compiled forms of one function, one file for each signature and processor type.

    Parameters
    ----------
    folder
        parent of the folder of all these files
    name
        name of the function, with its module and the Python version
    source
        the stamp of the function's file and of the kernel sources that it may call
    """

    def __init__(self, folder, name, source):
        self.folder, self.name, self.source = Path(folder) / KERNELS_FOLDER, name, source

    def path(self, key):
        """The file for a key of numba: signature, processor, bytecode."""
        key_digest = hashlib.sha256(repr(key[:2]).encode()).hexdigest()
        return self.folder / f"{self.name}.{key_digest[:16]}.nbc"

    def load(self, key):
        """The saved code; None if its file is missing or damaged, or belongs to other sources."""
        try:
            content = self.path(key).read_bytes()
            if content[:DIGEST_BYTES] == self._digest(key, content[DIGEST_BYTES:]):
                return pickle.loads(content[DIGEST_BYTES:])
        except Exception:  # unpickling damaged data can raise any exception
            pass
        return None

    def save(self, key, payload):
        """Write the file; raises OSError if that fails, after it has deleted the file."""
        self.folder.mkdir(exist_ok=True)
        code, path = dumps(payload), self.path(key)
        try:
            path.write_bytes(self._digest(key, code) + code)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def _digest(self, key, code):
        return hashlib.sha256(repr((VERSIONS, self.source, key)).encode() + code).digest()


class KernelCache(FunctionCache):
    """The cache of one function, with the interface of numba's and the files of `KernelFiles`.

    Raises
    ------
    RuntimeError
        If no folder is writable: neither that of the source, nor the user's cache, nor
        NUMBA_CACHE_DIR.
    OSError
        If the sources cannot be read, as in a zip file.
    """

    def __init__(self, function):
        super().__init__(function)
        file = function.__code__.co_filename
        called_sources = sources(file)
        name = f"{function.__module__}.{function.__qualname__}.{sys.implementation.cache_tag}"
        name = name.replace("<", "").replace(">", "")
        self._cache_file: Any = KernelFiles(self.cache_path, name, stamp(*called_sources, file))
        self._lock: Any = None

    def serve(self, dispatcher):
        """Let a dispatcher use this cache, and release the lock after each compilation, even if it
        fails."""
        compile_function = dispatcher.compile

        def compile_and_release(signature):
            try:
                return compile_function(signature)
            finally:
                if self._lock is not None:
                    self._lock.release()

        dispatcher._cache, dispatcher.compile = self, compile_and_release

    def load_overload(self, sig, target_context):
        """The saved code, ready to call; None if this process has to compile it, for which it then
        holds the lock where that can be had."""
        overload = self._loaded(sig, target_context)
        if overload is None:
            path = self._cache_file.path(self._index_key(sig, target_context.codegen()))
            with suppress(OSError):  # unwritable folder or lock time-out: continue without a lock
                self._cache_file.folder.mkdir(exist_ok=True)
                self._lock = file_lock(path.with_suffix(".lock"))
                self._lock.acquire()
            overload = self._loaded(sig, target_context)
        return overload

    def save_overload(self, sig, payload):
        """Save the code where possible; otherwise the next process compiles again."""
        with suppress(OSError):
            super().save_overload(sig, payload)

    def _loaded(self, sig, target_context):
        """The saved code, ready to call; None if there is none or it cannot be loaded."""
        with suppress(Exception):
            return super().load_overload(sig, target_context)
        return None

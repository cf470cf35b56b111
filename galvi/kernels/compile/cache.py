"""Compiled kernels on disk: no process loads a wrong one, and no fault of a file stops a run.

numba's own cache watches only the file that defines a function, not the files of what it calls; it
stops a run when a file is damaged or its folder cannot be written; and two processes that write at
once may exchange each other's code. Here a file starts with a digest of its code and of everything
that the code depends on: what is missing, stale, damaged or not writeable is compiled anew, by one
process while the others wait. Files are in one folder for each state of the kernels, and the
folders of other states are removed.

The digest is no signature: as with numba, whoever can write in the folder can run code of theirs.
"""

from __future__ import annotations

import hashlib
import pickle
import shutil
import sys
from collections.abc import Callable
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

DIGEST = 32  # bytes of SHA-256
VERSIONS = (numba.__version__, llvmlite.__version__)

Locks = Callable[[Path], Any]
_locks: Locks | None = None


def use_locks(locks: Locks | None) -> None:
    """Let one process compile a kernel while others wait; until then each compiles its own.

    locks  path of a file -> a lock with ``acquire()``, which may raise OSError, and ``release()``,
           such as filelock.FileLock
    """
    global _locks
    _locks = locks


@cache
def stamp(*files):
    """A digest of the files and of every kernel's source; OSError when one cannot be read."""
    digest = hashlib.sha256()
    for path in [*map(Path, files), *sorted(Path(__file__).parents[1].rglob("*.py"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


class KernelFiles:
    """The compiled forms of one function, a file for each signature and kind of processor.

    folder   where the folders are, one for each state of the kernels
    name     of the function, with its module and Python's version
    kernels  the stamp of all kernels
    source   the stamp of all kernels and of the function's own file
    """

    def __init__(self, folder, name, kernels, source):
        self.folder, self.name, self.source = Path(folder), name, source
        self.place = self.folder / f"galvi-kernels-{kernels[:16]}"

    def path(self, key):
        """Where the code for a key is; a key is numba's: signature, processor, bytecode."""
        which = hashlib.sha256(repr(key[:2]).encode()).hexdigest()
        return self.place / f"{self.name}.{which[:16]}.nbc"

    def load(self, key):
        """What was saved; None when it is not there, of other sources, or not as it was written."""
        try:
            content = self.path(key).read_bytes()
            if content[:DIGEST] == self._digest(key, content[DIGEST:]):
                return pickle.loads(content[DIGEST:])
        except Exception:  # what is not a pickle of these versions can raise anything
            pass
        return None

    def save(self, key, data):
        """Write it; raises OSError, and leaves nothing, when that fails."""
        self.make_place()
        code, path = dumps(data), self.path(key)
        try:
            path.write_bytes(self._digest(key, code) + code)
        except OSError:
            path.unlink(missing_ok=True)
            raise

    def make_place(self):
        """The folder of this state of the kernels; those of others are removed when it is new."""
        if not self.place.is_dir():
            for other in self.folder.glob("galvi-kernels-*"):
                shutil.rmtree(other, ignore_errors=True)
            self.place.mkdir(exist_ok=True)

    def _digest(self, key, code):
        return hashlib.sha256(repr((VERSIONS, self.source, key)).encode() + code).digest()


class KernelCache(FunctionCache):
    """numba's cache of one function, kept in `KernelFiles`.

    Raises RuntimeError when no folder can be written: neither the one of the source, nor the
    user's, nor NUMBA_CACHE_DIR; OSError when the sources cannot be read, as in a zip file.
    """

    def __init__(self, function):
        super().__init__(function)
        source = stamp(function.__code__.co_filename)
        name = f"{function.__module__}.{function.__qualname__}.{sys.implementation.cache_tag}"
        name = name.replace("<", "").replace(">", "")
        self._cache_file: Any = KernelFiles(self.cache_path, name, stamp(), source)
        self._lock: Any = None

    def serve(self, dispatcher):
        """Keep what a dispatcher compiles, and let others go on whatever becomes of it."""
        compile_it = dispatcher.compile

        def compile_and_release(signature):
            try:
                return compile_it(signature)
            finally:
                if self._lock is not None:
                    self._lock.release()

        dispatcher._cache, dispatcher.compile = self, compile_and_release

    def load_overload(self, sig, target_context):
        """What was saved, ready to call; None when this process has to compile it."""
        found = self._loaded(sig, target_context)
        if found is None and _locks is not None:
            path = self._cache_file.path(self._index_key(sig, target_context.codegen()))
            with suppress(OSError):  # no place for it, or held for too long: as if there were none
                self._cache_file.make_place()
                self._lock = _locks(path.with_suffix(".lock"))
                self._lock.acquire()
            found = self._loaded(sig, target_context)
        return found

    def save_overload(self, sig, data):
        """Save it where that is possible; otherwise the next process compiles anew."""
        with suppress(OSError):
            super().save_overload(sig, data)

    def _loaded(self, sig, target_context):
        """None also when what was saved cannot be made ready."""
        with suppress(Exception):
            return super().load_overload(sig, target_context)
        return None

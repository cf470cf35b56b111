"""Compiled kernels on disk: no process loads a wrong one, and no fault of a file stops a run.

numba's own cache watches only the file that defines a function, not the files of what it calls; it
stops a run when a file is damaged or its folder cannot be written; and two processes that write at
once may exchange each other's code. Here a file is named after everything that its code depends on,
appears whole, and carries its digest: what is missing, damaged or not writeable is compiled anew,
by one process while the others wait. Files are in one folder for each state of the kernels, and the
folders of other states are removed.

The digest is no signature: as with numba, whoever can write in the folder can run code of theirs.
"""

from __future__ import annotations

import hashlib
import pickle
import shutil
import time
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import llvmlite
import numba
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

from galvi.kernels.compile.compile_lock import Turn

DIGEST = 32  # bytes of SHA-256
HOUR = 3600.0  # seconds after which a file that is not whole belongs to a process that was ended
VERSIONS = (numba.__version__, llvmlite.__version__)


@cache
def stamp(*files):
    """A digest of the files and of every kernel's source; OSError when one cannot be read."""
    digest = hashlib.sha256()
    for path in [*map(Path, files), *sorted(Path(__file__).parents[1].rglob("*.py"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


class StampedFiles:
    """The compiled forms of one function, a file for each signature.

    folder   where the folders are, one for each state of the kernels
    name     of the module and the function, its line and Python's version
    kernels  the stamp of all kernels
    source   the stamp of all kernels and of the function's own file
    """

    def __init__(self, folder, name, kernels, source):
        self.folder, self.name, self.source = Path(folder), name, source[:16]
        self.place = self.folder / f"galvi-kernels-{kernels[:16]}"

    def path(self, key):
        """Where the code for a key is: a signature, the processor and the function's bytecode."""
        digest = hashlib.sha256(repr((VERSIONS, key)).encode()).hexdigest()
        return self.place / f"{self.name}.{self.source}.{digest[:16]}.nbc"

    def load(self, key):
        """What was saved, or None when it is not there or not as it was written."""
        try:
            content = self.path(key).read_bytes()
        except OSError:
            return None
        code = content[DIGEST:]
        if hashlib.sha256(code).digest() != content[:DIGEST]:
            return None
        try:
            return pickle.loads(code)
        except Exception:  # what is not a pickle of these versions can raise anything
            return None

    def save(self, key, data):
        """Write it, whole or not at all, and remove what other sources left."""
        code = dumps(data)
        partial = self.place / f"{self.name}.{uuid.uuid4().hex}.part"
        self.place.mkdir(exist_ok=True)
        try:
            partial.write_bytes(hashlib.sha256(code).digest() + code)
            partial.replace(self.path(key))
        except BaseException:
            partial.unlink(missing_ok=True)
            raise
        self.tidy()

    def flush(self):
        """Remove the files of this function."""
        for path in self.place.glob(f"{self.name}.*"):
            path.unlink(missing_ok=True)

    def tidy(self):
        """Remove what other kernels, other sources of this module and ended processes left."""
        for place in self.folder.glob("galvi-kernels-*"):
            if place != self.place:
                shutil.rmtree(place, ignore_errors=True)
        module = self.name.partition(".")[0]
        for path in self.place.iterdir():
            if path.suffix in (".part", ".turn"):
                left = time.time() - path.stat().st_mtime > HOUR
            else:
                left = path.name.startswith(f"{module}.") and f".{self.source}." not in path.name
            if left:
                path.unlink(missing_ok=True)


class KernelCache(FunctionCache):
    """numba's cache of one function, kept in `StampedFiles`.

    Raises RuntimeError when no folder can be written: neither the one of the source, nor the
    user's, nor NUMBA_CACHE_DIR; OSError when the sources cannot be read, as in a zip file.
    """

    def __init__(self, function):
        super().__init__(function)
        source = stamp(function.__code__.co_filename)
        name = self._impl.filename_base
        self._cache_file: Any = StampedFiles(self.cache_path, name, stamp(), source)
        self._turn = Turn(self._cache_file.place)

    def load_overload(self, sig, target_context):
        """What was saved, ready to call; None when this process has to compile it."""
        found = self._loaded(sig, target_context)
        if found is None:
            key = self._index_key(sig, target_context.codegen())
            self._turn = Turn(self._cache_file.path(key))
            if self._turn.take():
                found = self._loaded(sig, target_context)
            if found is not None:
                self._turn.end()
        return found

    def save_overload(self, sig, data):
        """Save it where that is possible; otherwise the next process compiles anew."""
        with suppress(OSError):
            super().save_overload(sig, data)
        self._turn.end()

    def watch(self, compiler):
        """Let the next process have its turn also when numba's compiler of the function fails."""
        compile_it = compiler.compile

        def compile_or_leave(args, return_type):
            try:
                return compile_it(args, return_type)
            except BaseException:
                self._turn.end()
                raise

        compiler.compile = compile_or_leave

    def _loaded(self, sig, target_context):
        """None also when what was saved cannot be made ready."""
        with suppress(Exception):
            return super().load_overload(sig, target_context)
        return None

"""Compiled kernels on disk: no process loads a wrong one, and no fault of a file stops a run.

numba's own cache watches only the file that defines a function, not the files of what it calls; it
stops a run when a file is damaged or its folder cannot be written; and two processes that write at
once may exchange each other's code. Here a file is named after everything that its code depends on,
appears whole, and carries its digest: what is missing, damaged or not writeable is compiled anew.
"""

from __future__ import annotations

import hashlib
import pickle
import uuid
from contextlib import suppress
from functools import cache
from pathlib import Path
from typing import Any

import numba
from numba.core.caching import FunctionCache
from numba.core.serialize import dumps

DIGEST = 32  # bytes of SHA-256


@cache
def stamp(file):
    """A digest of a file and of every kernel's source."""
    digest = hashlib.sha256()
    for path in [Path(file), *sorted(Path(__file__).parent.glob("*.py"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


class StampedFiles:
    """The compiled forms of one function, a file for each signature.

    folder  where they are
    name    of the function, its line and Python's version
    source  the stamp of its source
    """

    def __init__(self, folder, name, source):
        self.folder, self.name, self.source = Path(folder), name, source[:16]

    def path(self, key):
        """Where the code for a key is: a signature, the processor and the function's bytecode."""
        digest = hashlib.sha256(repr((numba.__version__, key)).encode()).hexdigest()
        return self.folder / f"{self.name}.{self.source}.{digest[:16]}.nbc"

    def load(self, key):
        """What was saved, or None when it is not there or not as it was written."""
        try:
            content = self.path(key).read_bytes()
        except OSError:
            return None
        code = content[DIGEST:]
        if hashlib.sha256(code).digest() != content[:DIGEST]:
            return None
        return pickle.loads(code)

    def save(self, key, data):
        """Write it, whole or not at all, and remove what other sources left."""
        code = dumps(data)
        partial = self.folder / f"{self.name}.{self.source}.{uuid.uuid4().hex}"
        try:
            partial.write_bytes(hashlib.sha256(code).digest() + code)
            partial.replace(self.path(key))
        except BaseException:
            partial.unlink(missing_ok=True)
            raise
        self.flush(all_but=self.source)

    def flush(self, all_but=None):
        """Remove the files of this function, or those of other sources."""
        for path in self.folder.glob(f"{self.name}.*"):
            if all_but is None or not path.name.startswith(f"{self.name}.{all_but}."):
                path.unlink(missing_ok=True)


class KernelCache(FunctionCache):
    """numba's cache of one function, kept in `StampedFiles`.

    Raises RuntimeError when no folder can be written: neither the one of the source, nor the
    user's, nor NUMBA_CACHE_DIR.
    """

    def __init__(self, function):
        super().__init__(function)
        source = stamp(function.__code__.co_filename)
        name = self._impl.filename_base
        self._cache_file: Any = StampedFiles(self.cache_path, name, source)

    def save_overload(self, sig, data):
        """Save it where that is possible; otherwise the next process compiles anew."""
        with suppress(OSError):
            super().save_overload(sig, data)

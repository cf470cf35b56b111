"""How every kernel is compiled: cached on disk, IEEE division, no reordering of sums.

numba's cache watches only the file that defines a function, not the files of what it calls. Here
every cache is stamped with the contents of that file and of all kernel files, so that none can be
stale.
"""

from __future__ import annotations

import hashlib
from functools import cache
from pathlib import Path

import numba


@cache
def stamp(file):
    """A digest of a file and of every kernel's source."""
    digest = hashlib.sha256()
    for path in [Path(file), *sorted(Path(__file__).parent.glob("*.py"))]:
        digest.update(path.read_bytes())
    return digest.hexdigest()


def jit(function):
    """``function`` compiled when first called, for the types it is called with."""
    dispatcher = numba.njit(cache=True, error_model="numpy")(function)
    index = getattr(getattr(dispatcher, "_cache", None), "_cache_file", None)
    if index is not None and hasattr(
        index, "_source_stamp"
    ):  # not public in numba; without it the cache is numba's own
        index._source_stamp = stamp(function.__code__.co_filename)
    return dispatcher


def compiled_for(dispatcher, signature):
    """A dispatcher of the same function that takes these types and no others."""
    fixed = jit(dispatcher.py_func)
    fixed.compile(signature)
    fixed.disable_compile()
    return fixed

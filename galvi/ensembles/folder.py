"""Chunks of an ensemble on disk, one Parquet file each, and the names that tell them apart."""

from __future__ import annotations

import ast
import hashlib
import json
import math
import os
import platform
import time
import uuid
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from functools import cache, cached_property
from importlib.metadata import version
from pathlib import Path
from pickle import PicklingError
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np
from numba.core.dispatcher import Dispatcher

from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.run.saving.whole_files import write_whole

ATOMS = (type(None), bool, int, float, complex, str, bytes, Decimal)
OTHERS = {"analysis", "diagnostics", "interop", "properties", "recommend"}  # no run needs them
IMPORTED = time.time()
NAMED = (ast.Module, ast.ClassDef, ast.FunctionDef, ast.AsyncFunctionDef)


def identity(value: Any, version: str | None) -> Any:
    """A value as nested tuples of numbers and texts that tell it from others.

    version  of the caller's functions and classes, of which only names and values are looked at

    Raises ValueError when there is such a function or class, and no version: which other code it
    calls cannot be known.
    """
    kind = type(value)
    if kind in ATOMS:
        return kind.__name__, repr(value)
    if isinstance(value, np.ndarray | np.generic) and not value.dtype.hasobject:
        return "array", value.dtype.str, value.shape, value.tobytes().hex()
    if isinstance(value, tuple | list):
        return kind.__name__, tuple(identity(item, version) for item in value)
    if isinstance(value, set | frozenset):
        return "set", tuple(sorted((identity(item, version) for item in value), key=repr))
    if isinstance(value, Mapping):
        items = [(identity(key, version), identity(item, version)) for key, item in value.items()]
        return "mapping", tuple(sorted(items, key=repr))
    if isinstance(value, np.ndarray):
        return "array", value.shape, identity(value.ravel().tolist(), version)
    named = hasattr(value, "__qualname__")  # functions and classes
    owner: Any = value if named else kind
    name = f"{owner.__module__}.{owner.__qualname__}"
    known = (named and "<" not in name) or (not named and is_dataclass(value))
    if version is None and not (name.startswith("galvi.") and known):
        raise ValueError(
            f"files in a folder cannot be told from those of earlier code of {name}, since what it "
            f"calls cannot be known. Give version='1', and another text whenever that code, or "
            f"what it calls, has changed."
        )
    if is_dataclass(value) and not named:
        own = {one.name: getattr(value, one.name) for one in fields(value)}
        return name, identity(own, version)
    return (name,) if version is None else (name, identity(_values(value), version))


def _values(value: Any) -> Any:
    """What a function or an object holds, which its version does not tell.

    Its own bytecode is among that, since two functions may have one name, such as <lambda>.
    """
    if isinstance(value, type | BuiltinFunctionType | np.ufunc):
        return None
    if isinstance(value, Dispatcher):
        return _values(value.py_func)
    if isinstance(value, MethodType):
        return value.__self__, _values(value.__func__)
    if isinstance(value, FunctionType):
        code, cells = value.__code__, value.__closure__ or ()
        constants = [one for one in code.co_consts if not isinstance(one, CodeType)]
        held = [one.cell_contents for one in cells if one != CellType()]
        return code.co_code, constants, value.__defaults__, value.__kwdefaults__, held
    try:
        return value.__reduce_ex__(2)[1:3]
    except (TypeError, ValueError, AttributeError, NotImplementedError, PicklingError) as error:
        raise ValueError(
            f"files in a folder are told apart by values; those of {type(value).__qualname__} "
            f"cannot be had: {error}. Give numbers, arrays, functions of them, or no folder."
        ) from error


@cache
def digest_of_galvi() -> str:
    """A digest of the code that runs depend on: syntax trees without docstrings and comments.

    Raises ValueError where a file was changed since this process imported galvi.
    """
    digest, top = hashlib.sha256(), Path(__file__).parents[1]
    for path in sorted(top.rglob("*.py")):
        if not OTHERS & {*path.relative_to(top).parts}:
            if IMPORTED < path.stat().st_mtime <= time.time():
                raise ValueError(
                    f"galvi's {path.name} was changed after this process had imported galvi, so "
                    f"that results in a folder would be of unknown code. Start Python anew."
                )
            tree = ast.parse(path.read_bytes())
            for node in _documented(tree):
                node.body = node.body[1:]
            digest.update(ast.dump(tree).encode())
    return digest.hexdigest()


def _documented(tree: ast.Module) -> Iterator[Any]:
    """The module, classes and functions that have a docstring."""
    for node in ast.walk(tree):
        if isinstance(node, NAMED) and ast.get_docstring(node, clean=False) is not None:
            yield node


FORMAT = 3
VERSIONS = ("numba", "llvmlite", "numpy")
Rows = tuple[tuple[Array, ...], Any, Any, dict[int, str]]  # values, failed, passes and messages


class Folder:
    """The files of one ensemble.

    facts    what all its members share: law, method, times and what is kept
    version  of the caller's functions among the facts
    loaded, damaged  how many files `load` has read, and how many of them it did not believe

    A file holds the members of one chunk and is written as a whole under another name, then
    renamed. It says what it was computed from, and has a digest of its numbers; without both it is
    not believed. Raises ImportError without pyarrow, TypeError or ValueError for another path than
    that of a folder, and ValueError for facts that cannot be told from others.
    """

    def __init__(
        self, path: Any, facts: Any, starts: Mapping[str, Array], version_of_functions: str | None
    ) -> None:
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError as error:
            raise ImportError(
                f"an ensemble in a folder needs pyarrow: {error}. Install it: pip install pyarrow."
            ) from error
        if not isinstance(path, str | os.PathLike):
            raise TypeError(
                f"folder must be the path of a folder, or None; received {shown(path)}."
            )
        self.path, self.starts = Path(path), dict(starts)
        self.loaded = self.damaged = 0
        versions = [platform.python_version(), *map(version, VERSIONS), version_of_functions]
        known = FORMAT, digest_of_galvi(), versions, identity(facts, version_of_functions)
        self.shared = hashlib.sha256(repr(known).encode()).digest()
        if self.path.exists() and not self.path.is_dir():
            raise ValueError(
                f"folder must be the path of a folder; received {str(path)!r}, where a file is. "
                f"Give another path."
            )

    def make_writable(self) -> None:
        """Create the folder; ValueError where no file can be written."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            tried = self.path / f".tried-{uuid.uuid4().hex}"
            write_whole(tried, b"")
            tried.unlink()
        except OSError as error:
            raise ValueError(
                f"folder must be one that can be written; received {str(self.path)!r}: "
                f"{error.strerror}. Give another path."
            ) from error

    @property
    def known(self) -> bool:
        """Whether some call has begun this ensemble."""
        return self._known_members() is not None

    @cached_property
    def _about(self) -> Path:
        everyone = slice(0, len(next(iter(self.starts.values()))))
        return self.path / f"ensemble-{self._digest(everyone)}.json"

    def members_of_a_file(self, found: int) -> int:
        """How many members a file of this ensemble has: as in the first call, else ``found``."""
        known = self._known_members()
        if known is not None:
            return known
        text = json.dumps({"members": found})
        self.make_writable()
        write_whole(self._about, text)
        return found

    def _known_members(self) -> int | None:
        try:
            known = json.loads(self._about.read_text())["members"]
        except (OSError, KeyError, TypeError, ValueError, RecursionError):
            return None  # missing or damaged: written again
        return known if type(known) is int and known > 0 else None

    def summary(self, computed: int) -> str:
        """What was loaded and computed, in words."""
        again = f", {self.damaged} of them again, since a file was damaged" if self.damaged else ""
        return f"files: {self.loaded} loaded, {computed} computed{again}"

    def load(self, members: slice) -> Rows | None:
        """What `save` wrote of these members; None where nothing is, or it is damaged."""
        path = self._file(members)
        if not os.path.lexists(path):
            return None
        try:
            found = self._read(path, members)
        except Exception:  # damaged data can raise any exception
            self.damaged += 1
            return None
        self.loaded += 1
        return found

    def _read(self, path: Path, members: slice) -> Rows:
        """The rows of a file; an exception where they are not those of these members."""
        import pyarrow.parquet as pq

        table = pq.read_table(path, page_checksum_verification=True)
        facts = json.loads(table.schema.metadata[b"facts"])
        count = members.stop - members.start
        columns = {name: table[name].combine_chunks() for name in table.column_names}
        values = tuple(
            np.asarray(columns.pop(f"value{k}").flatten())[: count * math.prod(shape)].reshape(
                count, *shape
            )
            for k, shape in enumerate(facts["shapes"])
        )
        failed, passes = (np.asarray(columns.pop(name)) for name in ("failed", "passes"))
        messages = {int(member): str(text) for member, text in facts["messages"].items()}
        rows = values, failed, passes, messages
        if facts["digest"] != self._digest_of(members, rows) or columns:
            raise ValueError("not what was written")
        return rows

    def save(
        self, members: slice, values: tuple[Array, ...], failed: Any, passes: Any,
        messages: dict[int, str],
    ) -> None:  # fmt: skip
        """Write what some members left, completely or not at all.

        messages  by number from the first of these members
        """
        import pyarrow as pa
        import pyarrow.parquet as pq

        columns: dict[str, Any] = {}
        for k, value in enumerate(values):
            size = math.prod(value.shape[1:])
            flat = np.ascontiguousarray(value, dtype=np.float64).reshape(len(value), size)
            if not size:
                flat = np.zeros((len(value), 1))  # a row has at least one number
            columns[f"value{k}"] = pa.FixedSizeListArray.from_arrays(
                pa.array(flat.ravel()), flat.shape[1]
            )
        columns |= {"failed": pa.array(failed), "passes": pa.array(passes)}
        facts = {
            "shapes": [list(value.shape[1:]) for value in values],
            "messages": messages,
            "digest": self._digest_of(members, (values, failed, passes, messages)),
        }
        table = pa.table(columns).replace_schema_metadata({"facts": json.dumps(facts)})
        path = self._file(members)
        try:
            write_whole(path, lambda to: pq.write_table(table, to, write_page_checksum=True))
        except IsADirectoryError:
            return  # computed again by each call, which says so
        except OSError as error:
            raise OSError(
                error.errno,
                f"a file of the ensemble could not be written ({error.strerror or error}). The "
                f"next call goes on from what is in the folder",
                str(path),
            ) from error

    def _digest_of(self, members: slice, rows: Rows) -> str:
        """A digest of what a file was computed from, and of all that it holds."""
        values, failed, passes, messages = rows
        digest = hashlib.sha256(self._digest(members).encode())
        for array in (*values, failed, passes):
            digest.update(f"{array.dtype.str}{array.shape}".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        digest.update(repr(sorted(messages.items())).encode())
        return digest.hexdigest()

    def _file(self, members: slice) -> Path:
        return self.path / f"{self._digest(members)}.parquet"

    def _digest(self, members: slice) -> str:
        digest = hashlib.sha256(self.shared)
        for name, values in sorted(self.starts.items()):
            part = np.ascontiguousarray(values[members])
            digest.update(f"{name}{part.shape}".encode() + part.tobytes())
        return digest.hexdigest()[:32]

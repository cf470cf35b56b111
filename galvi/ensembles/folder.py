"""Chunks of an ensemble on disk, one .npz file each, and the digest of the request that names
them."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import time
import uuid
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from decimal import Decimal
from functools import cache
from importlib.metadata import version
from pathlib import Path
from pickle import PicklingError
from types import BuiltinFunctionType, CellType, CodeType, FunctionType, MethodType
from typing import Any

import numpy as np
from numba.extending import is_jitted

from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.outcome import Outcome
from galvi.whole_files import write_whole

PLAIN_TYPES = (type(None), bool, int, float, complex, str, bytes, Decimal)
IMPORTED = time.time()
VERSIONS = ("numba", "llvmlite", "numpy")
Rows = tuple[tuple[Array, ...], Any, dict[int, Outcome]]  # values, passes and outcomes


def identity(value: Any, version: str | None) -> Any:
    """A value as nested tuples of numbers and texts, which are equal only for equal values.

    Parameters
    ----------
    version
        version of the caller's functions and classes, of which only names and values are compared;
        None where there are none

    Raises
    ------
    ValueError
        For a function or class of the caller without a version, since the code that it calls
        cannot be known.
    """
    value_type = type(value)
    if value_type in PLAIN_TYPES:
        return value_type.__name__, repr(value)
    if isinstance(value, np.ndarray | np.generic):
        if value.dtype.hasobject:
            return "array", value.shape, identity(value.ravel().tolist(), version)
        return "array", value.dtype.str, value.shape, hashlib.sha256(value.tobytes()).hexdigest()
    if isinstance(value, tuple | list):
        return value_type.__name__, tuple(identity(item, version) for item in value)
    if isinstance(value, set | frozenset | Mapping):
        items = value.items() if isinstance(value, Mapping) else value
        return value_type.__name__, tuple(
            sorted((identity(item, version) for item in items), key=repr)
        )
    is_named = hasattr(value, "__qualname__")  # functions and classes
    owner: Any = value if is_named else value_type
    name = f"{owner.__module__}.{owner.__qualname__}"
    identifiable = (is_named and "<" not in name) or (not is_named and is_dataclass(value))
    if version is None and not (name.startswith("galvi.") and identifiable):
        raise ValueError(
            f"files in a folder cannot be told from those of earlier code of {name}, since what it "
            f"calls cannot be known. Give version='1', and another text whenever that code, or "
            f"the code that it calls, has changed."
        )
    if is_dataclass(value) and not is_named:
        return name, identity(
            {field.name: getattr(value, field.name) for field in fields(value)}, version
        )
    return (name,) if version is None else (name, identity(_values(value), version))


def _values(value: Any) -> Any:
    """The values that a function or an object holds; None for a class or a built-in function.

    The bytecode of a function is included, since two functions may share a name, such as <lambda>.
    """
    if isinstance(value, type | BuiltinFunctionType | np.ufunc):
        return None
    if is_jitted(value):
        return _values(value.py_func)
    if isinstance(value, MethodType):
        return value.__self__, _values(value.__func__)
    if isinstance(value, FunctionType):
        code, cells = value.__code__, value.__closure__ or ()
        constants = [constant for constant in code.co_consts if not isinstance(constant, CodeType)]
        cell_contents = [cell.cell_contents for cell in cells if cell != CellType()]
        return code.co_code, constants, value.__defaults__, value.__kwdefaults__, cell_contents
    try:
        return value.__reduce_ex__(2)[1:3]
    except (TypeError, ValueError, AttributeError, NotImplementedError, PicklingError) as error:
        raise ValueError(
            f"files in a folder are told apart by values; those of {type(value).__qualname__} "
            f"cannot be had: {error}. Give numbers, arrays, functions of them, or no folder."
        ) from error


@cache
def digest_of_galvi() -> str:
    """A digest of galvi's files; ValueError where one was changed since this process imported
    galvi."""
    digest = hashlib.sha256()
    for path in sorted(Path(__file__).parents[1].rglob("*.py")):
        if IMPORTED < path.stat().st_mtime <= time.time():
            raise ValueError(
                f"galvi's {path.name} was changed after this process had imported galvi, so "
                f"that results in a folder would be of unknown code. Start Python anew."
            )
        digest.update(path.read_bytes())
    return digest.hexdigest()


class Folder:
    """The files of one ensemble.

    Attributes
    ----------
    request
        digest of the law, method, times and what is kept, of the members' starts and numbers, and
        of the code that computes
    loaded, damaged
        numbers of files that `load` read, and that it found damaged

    Raises
    ------
    TypeError, ValueError
        For a path that is no text or that of a file.
    ValueError
        For facts that have no `identity`.

    Notes
    -----
    The name of a file consists of the request and the numbers of its members. A file whose digest
    does not match its name and arrays counts as damaged. Several processes that compute the same
    file write the same bits.
    """

    def __init__(
        self, path: Any, facts: Any, starts: Mapping[str, Array], version_of_functions: str | None
    ) -> None:
        if not isinstance(path, str | os.PathLike):
            raise TypeError(
                f"folder must be the path of a folder, or None; received {shown(path)}."
            )
        self.path = Path(path)
        self.loaded = self.damaged = 0
        versions = [platform.python_version(), *map(version, VERSIONS), version_of_functions]
        request_parts = digest_of_galvi(), versions, identity((facts, starts), version_of_functions)
        self.request = hashlib.sha256(repr(request_parts).encode()).hexdigest()[:32]
        if self.path.exists() and not self.path.is_dir():
            raise ValueError(
                f"folder must be the path of a folder; received {str(path)!r}, where a file is. "
                f"Give another path."
            )

    def make_writable(self) -> None:
        """Create the folder; ValueError where no file can be written."""
        try:
            self.path.mkdir(parents=True, exist_ok=True)
            probe_path = self.path / f".tried-{uuid.uuid4().hex}"
            write_whole(probe_path, b"")
            probe_path.unlink()
        except OSError as error:
            raise ValueError(
                f"folder must be one that can be written; received {str(self.path)!r}: "
                f"{error.strerror}. Give another path."
            ) from error

    def members_of_a_file(self) -> int:
        """The number of members in each readable file of this ensemble except the last; 0 without
        files."""
        names = (path.name for path in self.path.glob(f"{self.request}-*"))
        matches = (re.fullmatch(r"\w+-(\d+)-(\d+)\.npz", name) for name in names)
        ranges = (slice(int(match[1]), int(match[2])) for match in matches if match)
        for members in sorted(ranges, key=lambda members: members.start - members.stop):
            size = members.stop - members.start
            if size > 0 and members.start % size == 0 and self._read(members) is not None:
                return size
        return 0

    def summary(self, computed: int) -> str:
        """A clause on the numbers of files that were loaded and computed."""
        damaged_clause = (
            f", {self.damaged} of them again, since a file was damaged" if self.damaged else ""
        )
        return f"files: {self.loaded} loaded, {computed} computed{damaged_clause}"

    def load(self, members: slice) -> Rows | None:
        """The rows that `save` wrote of these members; None without a file or for a damaged one."""
        path = self._file(members)
        if not os.path.lexists(path):
            return None
        arrays = self._read(members)
        if arrays is None:
            self.damaged += 1
            return None
        self.loaded += 1
        passes, facts = arrays.pop("passes"), json.loads(str(arrays.pop("outcomes")))
        outcomes = {
            members.start + int(k): Outcome.from_json(fields) for k, fields in facts.items()
        }
        return tuple(arrays[f"value{k}"] for k in range(len(arrays))), passes, outcomes

    def _read(self, members: slice) -> dict[str, Any] | None:
        """The arrays of these members' file; None unless they have the digest that was written."""
        try:
            path = self._file(members)
            with open(path, "rb") as stream, np.load(stream, allow_pickle=False) as file:
                arrays = {name: file[name] for name in file.files}
            return arrays if str(arrays.pop("digest")) == self._digest(members, arrays) else None
        except Exception:  # damaged data can raise any exception
            return None

    def save(
        self, members: slice, values: tuple[Array, ...], passes: Any, outcomes: dict[int, Outcome]
    ) -> None:
        """Write the rows of some members, completely or not at all.

        Parameters
        ----------
        outcomes
            outcomes of members of the ensemble by their numbers; the file counts from the first of
            its members
        """
        arrays: dict[str, Any] = {f"value{k}": value for k, value in enumerate(values)}
        numbered_outcomes = ((k, outcomes.get(members.start + k)) for k in range(len(passes)))
        facts = {k: outcome.to_json() for k, outcome in numbered_outcomes if outcome is not None}
        arrays |= {"passes": passes, "outcomes": np.array(json.dumps(facts))}
        digest, path = np.array(self._digest(members, arrays)), self._file(members)
        try:
            write_whole(path, lambda to: np.savez(to, digest=digest, **arrays))
        except IsADirectoryError:
            return  # a folder has that name: each call computes these members again, and says so
        except OSError as error:
            raise OSError(
                error.errno,
                f"a file of the ensemble could not be written ({error.strerror or error}). The "
                f"next call goes on from what is in the folder",
                str(path),
            ) from error

    def _digest(self, members: slice, arrays: Mapping[str, Array]) -> str:
        """A digest of a file's name and arrays."""
        digest = hashlib.sha256(self._file(members).name.encode())
        for name, array in sorted(arrays.items()):
            digest.update(f"{name}{array.dtype.str}{array.shape}".encode() + array.tobytes())
        return digest.hexdigest()

    def _file(self, members: slice) -> Path:
        return self.path / f"{self.request}-{members.start}-{members.stop}.npz"

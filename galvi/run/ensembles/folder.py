"""Chunks of an ensemble on disk: one Parquet file each, named by what it was computed from."""

from __future__ import annotations

import hashlib
import json
import os
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import fields, is_dataclass
from functools import cached_property, partial
from importlib.metadata import version
from pathlib import Path
from types import CodeType, FunctionType
from typing import Any

import numpy as np

from galvi.arrays import Array

FORMAT = 1
VERSIONS = ("galvi", "numba", "llvmlite", "numpy")


class Folder:
    """The files of one ensemble.

    facts  what all its members share: law, method, times and what is kept

    A file holds the members of one chunk and is written as a whole under another name, then
    renamed. Raises ImportError without pyarrow.
    """

    def __init__(self, path: Any, facts: Any, starts: Mapping[str, Array]) -> None:
        try:
            import pyarrow.parquet  # noqa: F401
        except ImportError as error:
            raise ImportError(
                f"an ensemble in a folder needs pyarrow: {error}. Install it: pip install pyarrow."
            ) from error
        self.path, self.starts = Path(path), dict(starts)
        self.path.mkdir(parents=True, exist_ok=True)
        versions = [version(name) for name in VERSIONS]
        self.shared = hashlib.sha256(repr((FORMAT, versions, _plain(facts))).encode()).digest()

    @property
    def known(self) -> bool:
        """Whether some call has begun this ensemble."""
        return self._about.exists()

    @cached_property
    def _about(self) -> Path:
        everyone = slice(0, len(next(iter(self.starts.values()))))
        return self.path / f"ensemble-{self._digest(everyone)}.json"

    def members_of_a_file(self, found: int) -> int:
        """How many members a file of this ensemble has: as in the first call, else ``found``."""
        path = self._about
        if not path.exists():
            self._write(path, lambda target: target.write_text(json.dumps({"members": found})))
        return int(json.loads(path.read_text())["members"])

    def load(self, members: slice) -> tuple[tuple[Array, ...], Any, Any, dict[int, str]] | None:
        """What `save` wrote of these members: values, failed, passes and messages; None where
        nothing is, or it cannot be read."""
        import pyarrow as pa
        import pyarrow.parquet as pq

        path = self._file(members)
        if not path.exists():
            return None
        try:
            table = pq.read_table(path)
            shapes = json.loads(table.schema.metadata[b"shapes"])
            messages = json.loads(table.schema.metadata[b"messages"])
        except (pa.ArrowInvalid, OSError, KeyError, TypeError, ValueError):
            return None  # not a file of ours, or damaged: it is computed again
        count = members.stop - members.start
        values = tuple(
            table[f"value{k}"].combine_chunks().values.to_numpy().reshape(count, *shape)
            for k, shape in enumerate(shapes)
        )
        columns = (table[name].to_numpy() for name in ("failed", "passes"))
        return values, *columns, {int(member): text for member, text in messages.items()}

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
            flat = np.ascontiguousarray(value, dtype=np.float64).reshape(len(value), -1)
            columns[f"value{k}"] = pa.FixedSizeListArray.from_arrays(
                pa.array(flat.ravel()), max(flat.shape[1], 1)
            )
        columns |= {"failed": pa.array(failed), "passes": pa.array(passes)}
        shapes = json.dumps([list(value.shape[1:]) for value in values])
        about = {"shapes": shapes, "messages": json.dumps(messages)}
        table = pa.table(columns).replace_schema_metadata(about)
        self._write(self._file(members), lambda target: pq.write_table(table, target))

    def _file(self, members: slice) -> Path:
        return self.path / f"{self._digest(members)}.parquet"

    def _digest(self, members: slice) -> str:
        digest = hashlib.sha256(self.shared)
        for name, values in sorted(self.starts.items()):
            part = np.ascontiguousarray(values[members])
            digest.update(f"{name}{part.shape}".encode() + part.tobytes())
        return digest.hexdigest()[:32]

    def _write(self, path: Path, write: Any) -> None:
        handle, partial_name = tempfile.mkstemp(dir=self.path, suffix=".partial")
        os.close(handle)
        target = Path(partial_name)
        try:
            write(target)
            target.chmod(0o644)
            target.replace(path)
        except BaseException:
            target.unlink(missing_ok=True)
            raise


def _plain(value: Any) -> Any:
    """A value as nested tuples of numbers and texts that tell it from others, also in another
    process: a function by its code, defaults and closure."""
    if isinstance(value, np.ndarray):
        return "array", value.shape, value.tobytes().hex()
    if isinstance(value, tuple | list):
        return tuple(map(_plain, value))
    if isinstance(value, Mapping):
        return tuple((str(key), _plain(item)) for key, item in sorted(value.items()))
    if isinstance(value, partial):
        return "partial", _plain(value.func), _plain(value.args), _plain(value.keywords)
    function = getattr(value, "py_func", value)
    if isinstance(function, FunctionType):
        cells = tuple(cell.cell_contents for cell in function.__closure__ or ())
        return "function", _plain(function.__code__), _plain(function.__defaults__), _plain(cells)
    if isinstance(value, CodeType):
        return value.co_code.hex(), value.co_names, tuple(map(_plain, value.co_consts))
    if is_dataclass(value) and not isinstance(value, type):
        return type(value).__name__, tuple(_named_fields(value))
    return repr(value)


def _named_fields(value: Any) -> Iterator[tuple[str, Any]]:
    for field in fields(value):
        yield field.name, _plain(getattr(value, field.name))

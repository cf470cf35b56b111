"""Chunks of an ensemble on disk: one Parquet file each, named by what it was computed from."""

from __future__ import annotations

import hashlib
import json
import math
import os
import platform
import tempfile
from collections.abc import Mapping
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

import numpy as np

from galvi.arrays import Array
from galvi.input_checks import shown
from galvi.run.ensembles.identity import identity

FORMAT = 2
VERSIONS = ("galvi", "numba", "llvmlite", "numpy")


class Folder:
    """The files of one ensemble.

    facts  what all its members share: law, method, times and what is kept

    A file holds the members of one chunk and is written as a whole under another name, then
    renamed. Raises ImportError without pyarrow, TypeError or ValueError for another path than that
    of a folder, and ValueError for facts that cannot be told from others.
    """

    def __init__(self, path: Any, facts: Any, starts: Mapping[str, Array]) -> None:
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
        versions = [platform.python_version(), *(version(name) for name in VERSIONS)]
        self.shared = hashlib.sha256(repr((FORMAT, versions, identity(facts))).encode()).digest()
        try:
            self.path.mkdir(parents=True, exist_ok=True)
        except (FileExistsError, NotADirectoryError) as error:
            raise ValueError(
                f"folder must be the path of a folder; received {str(path)!r}, where a file is. "
                f"Give another path."
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
        self._write(self._about, lambda target: target.write_text(text))
        return found

    def _known_members(self) -> int | None:
        try:
            known = json.loads(self._about.read_text())["members"]
        except (FileNotFoundError, KeyError, TypeError, ValueError):
            return None  # missing or damaged: written again
        return known if type(known) is int and known > 0 else None

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
            table[f"value{k}"]
            .combine_chunks()
            .values.to_numpy()[: count * math.prod(shape)]
            .reshape(count, *shape)
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
            size = math.prod(value.shape[1:])
            flat = np.ascontiguousarray(value, dtype=np.float64).reshape(len(value), size)
            if not size:
                flat = np.zeros((len(value), 1))  # a row has at least one number
            columns[f"value{k}"] = pa.FixedSizeListArray.from_arrays(
                pa.array(flat.ravel()), flat.shape[1]
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

"""Rows in .csv files, written atomically and checked on reading.

The last line of each .csv is a comment with the digest of the lines above it.
"""

from __future__ import annotations

import hashlib
import io
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from benchmarks.store.cells import as_csv, read_csv

DIGEST_MARK = "# sha256 "
DAMAGED = ".damaged"


@dataclass(frozen=True)
class RowFiles:
    """The .csv files of one folder, all with the same columns.

    Attributes
    ----------
    folder
        created by the first write
    columns
        columns of every file: name -> type (str, int or float)
    report
        called with a sentence on each damaged file that is renamed
    """

    folder: Path
    columns: Mapping[str, type]
    report: Callable[[str], None] = print

    def path(self, name: str, suffix: str = ".csv") -> Path:
        """The path of a file by its name."""
        return self.folder / f"{name}{suffix}"

    def write(self, name: str, table: pd.DataFrame) -> None:
        """Write the table, replacing an earlier one."""
        text = as_csv(table[list(self.columns)])
        write(self.path(name), f"{text}{DIGEST_MARK}{digest_of(text)}\n")

    def read(self, name: str) -> pd.DataFrame | None:
        """The rows with all digits; None when the file is missing or damaged."""
        path = self.path(name)
        try:
            text, _, digest = path.read_text(encoding="utf-8").rpartition(DIGEST_MARK)
        except FileNotFoundError:
            return None
        except (OSError, UnicodeDecodeError) as error:
            self.set_aside(path, str(error))
            return None
        if not text or digest.strip() != digest_of(text):
            self.set_aside(path, "its contents are not what was written")
            return None
        table = read_csv(io.StringIO(text), dtype=str, keep_default_na=False)
        if tuple(table.columns) != tuple(self.columns):
            self.set_aside(path, "it has other columns")
            return None
        for column, kind in self.columns.items():
            if kind is not str:
                table[column] = [kind(text or "nan") for text in table[column]]
        return table

    def all(self) -> pd.DataFrame:
        """The rows of every undamaged file."""
        names = sorted(path.stem for path in self.folder.glob("*.csv"))
        tables = [table for table in map(self.read, names) if table is not None]
        if not tables:
            return pd.DataFrame(columns=list(self.columns))
        return pd.concat(tables, ignore_index=True)

    def set_aside(self, path: Path, why: str) -> None:
        """Rename a damaged file, so that it is neither read again nor lost."""
        new_path, k = path.with_name(path.name + DAMAGED), 1
        while new_path.exists():
            new_path, k = path.with_name(f"{path.name}{DAMAGED}.{k}"), k + 1
        path.replace(new_path)
        self.report(f"{path.name} is set aside as {new_path.name}: {why}.")


def stored_rows(
    folder: str, columns: Mapping[str, type]
) -> Callable[[Path, Callable[[str], None]], pd.DataFrame]:
    """A function (studies, report) that returns all rows of a study's folder, of any version; an
    empty table where the study was not run."""
    return lambda studies, report: RowFiles(studies / folder, columns, report).all()


def digest_of(text: str) -> str:
    return hashlib.sha256(text.encode()).hexdigest()

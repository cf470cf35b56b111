"""Comparisons measured on other machines, merged into a report.

The folder `machines` of a report has a subfolder for each machine, that is, for each processor and
vector set compiled for. It holds work_precision.csv and, in provenance.json, the origin of these
rows. The files of pytest-benchmark share one folder, since each of them names its machine.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from benchmarks.work_precision.dependable import dependable
from reports.results.origins import PROVENANCE_FILE, note_origin, read_origins, short_commit
from reports.results.rows import read_rows

MACHINES_FOLDER, BENCHMARKS_FOLDER = "machines", "benchmarks"
ROWS_FILE = "work_precision.csv"
NEEDED_COLUMNS = ("problem", "contender", "settings", "error", "seconds", "is_truth")


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine with the rows of its comparison.

    Attributes
    ----------
    runs
        rows of work_precision.csv, with the errors of `dependable`
    origin
        of the rows: "cpu", "compiled for", "date", "commit" and "setting", where known
    """

    runs: pd.DataFrame
    origin: Mapping[str, str]

    @property
    def vector_set(self) -> str:
        """The widest vector instructions compiled for, such as AVX-512; "" where unknown."""
        return self.origin.get("compiled for", "").partition(", ")[2]

    @property
    def folder_name(self) -> str:
        """The processor and what was compiled for, by which two machines are told apart."""
        text = f"{self.origin.get('cpu', '')} {self.origin.get('compiled for', '')}".casefold()
        return re.sub(r"[^a-z0-9]+", "-", text).strip("-")

    @property
    def date(self) -> str:
        return self.origin.get("date", "")

    @property
    def title(self) -> str:
        """Processor, what galvi and heyoka compiled for, date and commit."""
        return (
            f"{self.origin.get('cpu', 'unknown processor')} "
            f"({self.origin.get('compiled for', 'unknown')}), {self.date.partition(' ')[0]}, "
            f"commit {short_commit(self.origin.get('commit', ''))}"
        )


def machines(out: Path) -> list[Machine]:
    """The report's own machine, where its rows have an origin, then those merged into it."""
    own_machine = _read(out)
    return [own_machine, *_merged_into(out, own_machine)] if own_machine else _merged_into(out)


def other_machines(out: Path) -> list[Machine]:
    """The machines that were merged into a report and are not its own, the newest first."""
    return _merged_into(out, _read(out))


def _merged_into(out: Path, own_machine: Machine | None = None) -> list[Machine]:
    """Without folders whose rows cannot be read or whose origin names no processor."""
    merged = filter(None, map(_read, sorted((out / MACHINES_FOLDER).glob("*"))))
    own_name = own_machine.folder_name if own_machine else ""
    different = [machine for machine in merged if machine.folder_name != own_name]
    return sorted(different, key=lambda machine: machine.date, reverse=True)


def merge(out: Path, folders: Sequence[Path]) -> list[str]:
    """Copy the rows and benchmark files of other reports into `out`.

    For each machine the newest rows are kept. Rows of other machines inside a folder are skipped
    where they cannot be read.

    Returns
    -------
    list of str
        one sentence for each source of rows, and for each folder with benchmark files

    Raises
    ------
    ValueError
        Before anything is written, for a folder with neither rows nor benchmark files, and for
        one whose own rows lack a column or the processor of their origin.
    """
    for folder in folders:
        _check(folder)
    return [sentence for folder in folders for sentence in _merge_folder(out, folder)]


def _merge_folder(out: Path, folder: Path) -> Iterator[str]:
    """Copy what one report has and `out` has not; yield the sentences of `merge`."""
    for source in (folder, *sorted((folder / MACHINES_FOLDER).glob("*"))):
        machine = _read(source)
        if machine is None:
            continue
        target = out / MACHINES_FOLDER / machine.folder_name
        before = _read(target)
        if before is not None and before.date >= machine.date:
            yield f"{source}: skipped; the rows of {before.title} are at least as new."
            continue
        write(target / ROWS_FILE, (source / ROWS_FILE).read_bytes())
        note_origin(target, ROWS_FILE, machine.origin, machine.origin.get("setting") == "quick")
        yield f"{source}: {len(machine.runs)} rows of {machine.title}."
    benches = [
        path.relative_to(folder)
        for path in (folder / BENCHMARKS_FOLDER).rglob("*")
        if path.is_file()
    ]
    new = [path for path in benches if not (out / path).exists()]
    for path in new:
        write(out / path, (folder / path).read_bytes())
    if benches:
        present = len(benches) - len(new)
        yield f"{folder}: {len(new)} benchmark files copied, {present} already present."


def _check(folder: Path) -> None:
    """Raises ValueError for what `merge` refuses of one folder."""
    rows_path, provenance_path = folder / ROWS_FILE, folder / PROVENANCE_FILE
    columns = ", ".join(NEEDED_COLUMNS)
    if not rows_path.is_file():
        if any((folder / BENCHMARKS_FOLDER).rglob("*")):
            return
        raise ValueError(
            f"expected folders of reports, with {ROWS_FILE} and {PROVENANCE_FILE}, or "
            f"{BENCHMARKS_FOLDER}/; received {folder}, which has neither. Name the folder that "
            "`galvi compare --out` wrote."
        )
    table = read_rows(rows_path, NEEDED_COLUMNS[0])
    if table is None:
        raise ValueError(
            f"{rows_path} must be a table with the columns {columns}; it cannot be read, or has no "
            f"column {NEEDED_COLUMNS[0]}. Run `galvi compare` there again."
        )
    lacking = [name for name in NEEDED_COLUMNS if name not in table]
    if lacking:
        raise ValueError(
            f"{rows_path} expects the columns {columns}; received a file without "
            f"{', '.join(lacking)}. Run `galvi compare` there again."
        )
    if not read_origins(folder).get(ROWS_FILE, {}).get("cpu"):
        raise ValueError(
            f"{provenance_path} must name the processor on which {ROWS_FILE} was measured; it does "
            "not. Copy it from where the rows were measured."
        )


def _read(folder: Path) -> Machine | None:
    """The machine of a folder; None without readable rows or a processor in their origin."""
    origin = read_origins(folder).get(ROWS_FILE, {})
    runs = read_rows(folder / ROWS_FILE, "is_truth") if origin.get("cpu") else None
    return None if runs is None else Machine(dependable(runs), origin)

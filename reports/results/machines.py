"""Rows of other machines beside one's own: their comparisons, by processor, and their benches.

A folder MACHINES of the report has a subfolder for each, with work_precision.csv and the origin of
these rows in provenance.json. Benches are kept together, as each file says its machine.
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

MACHINES, ROWS, BENCHES = "machines", "work_precision.csv", "benchmarks"
NEEDED = ("problem", "contender", "settings", "error", "seconds", "is_truth")


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine with the rows of its comparison.

    Attributes
    ----------
    origin
        date, commit, versions and processor
    """

    runs: pd.DataFrame
    origin: Mapping[str, str]

    @property
    def kind(self) -> str:
        """The widest vectors of the machine, e.g. AVX-512; '' where unknown."""
        return self.origin.get("compiled for", "").partition(", ")[2]

    @property
    def name(self) -> str:
        """The name of its folder."""
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
    """The report's own machine first, then the merged ones of other processors, the newest first;
    rows without an origin are left out."""
    own_machine, *merged = (_read(folder) for folder in (out, *sorted((out / MACHINES).glob("*"))))
    by_age = sorted(filter(None, merged), key=lambda machine: machine.date, reverse=True)
    different = [
        machine for machine in by_age if not own_machine or machine.name != own_machine.name
    ]
    return [own_machine, *different] if own_machine else different


def merge(out: Path, folders: Sequence[Path]) -> list[str]:
    """Bring the rows and benches of other reports into `out`; a sentence on each.

    Of rows of the same processor the newer stay.

    Raises
    ------
    ValueError
        Before anything is written, for a folder that holds neither, or rows whose origin or columns
        are not known.
    """
    for folder in folders:
        _check(folder)
    return [sentence for folder in folders for sentence in _merged(out, folder)]


def _merged(out: Path, folder: Path) -> Iterator[str]:
    for source in (folder, *sorted((folder / MACHINES).glob("*"))):
        machine = _read(source)
        if machine is None:
            continue
        target = out / MACHINES / machine.name
        before = _read(target)
        if before is not None and before.date >= machine.date:
            yield f"{source}: rows of {before.title} are as new, and stay."
            continue
        write(target / ROWS, (source / ROWS).read_bytes())
        note_origin(target, ROWS, machine.origin, machine.origin.get("setting") == "quick")
        yield f"{source}: {len(machine.runs)} rows of {machine.title}."
    benches = [path.relative_to(folder) for path in (folder / BENCHES).rglob("*") if path.is_file()]
    new = [path for path in benches if not (out / path).exists()]
    for path in new:
        write(out / path, (folder / path).read_bytes())
    if benches:
        yield f"{folder}: {len(new)} files of benches, {len(benches) - len(new)} were here."


def _check(folder: Path) -> None:
    if not (folder / ROWS).is_file():
        if any((folder / BENCHES).rglob("*")):
            return
        raise ValueError(
            f"expected folders of reports, with {ROWS} and {PROVENANCE_FILE}, or {BENCHES}/; "
            "received "
            f"{folder}, which has neither. Name the folder that `galvi compare --out` wrote."
        )
    table = read_rows(folder / ROWS, NEEDED[0])
    lacking = [name for name in NEEDED if table is None or name not in table]
    if lacking:
        raise ValueError(
            f"{folder / ROWS} expects the columns {', '.join(NEEDED)}; received a file without "
            f"{', '.join(lacking)}. Run `galvi compare` there again."
        )
    if not read_origins(folder).get(ROWS, {}).get("cpu"):
        raise ValueError(
            f"{folder / PROVENANCE_FILE} expects the origin of {ROWS} with its processor; "
            "received none. "
            "Copy it from where the rows were measured."
        )


def _read(folder: Path) -> Machine | None:
    origin = read_origins(folder).get(ROWS, {})
    runs = read_rows(folder / ROWS, "is_truth") if origin.get("cpu") else None
    return None if runs is None else Machine(dependable(runs), origin)

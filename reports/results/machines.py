"""Rows of other machines beside one's own: their comparisons, by processor, and their benches.

A folder MACHINES of the report has a subfolder for each, with work_precision.csv and the origin of
these rows in provenance.json. Benches are kept together, as each file says its machine.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from benchmarks.store.atomic import write
from reports.results.comparison import written
from reports.results.origins import NAME, read_origins, short

MACHINES, ROWS, BENCHES = "machines", "work_precision.csv", "benchmarks"
NEEDED = ("problem", "contender", "settings", "error", "seconds", "is_truth")


@dataclass(frozen=True, eq=False)
class Machine:
    """A machine with the rows of its comparison.

    origin  date, commit, versions and processor
    """

    runs: pd.DataFrame
    origin: Mapping[str, str]

    @property
    def kind(self) -> str:
        """Its widest vectors, e.g. AVX-512; '' where unknown."""
        return self.origin.get("compiled for", "").partition(", ")[2]

    @property
    def title(self) -> str:
        """Processor, what galvi and heyoka compiled for, date and commit."""
        date, commit = self.origin.get("date", "").partition(" ")[0], self.origin.get("commit", "")
        return (
            f"{self.origin.get('cpu', 'unknown processor')} "
            f"({self.origin.get('compiled for', 'unknown')}), {date}, commit {short(commit)}"
        )


def machines(out: Path) -> list[Machine]:
    """The report's own machine first, then the merged ones of other processors, the newest first;
    rows without an origin are left out."""
    own = [one for one in (_read(out),) if one]
    others = [one for folder in sorted((out / MACHINES).glob("*")) if (one := _read(folder))]
    others.sort(key=lambda one: one.origin.get("date", ""), reverse=True)
    known = {_name(one.origin) for one in own}
    return [*own, *(one for one in others if _name(one.origin) not in known)]


def merge(out: Path, folders: Sequence[Path]) -> list[str]:
    """Bring the rows and benches of other reports into `out`; a sentence on each.

    Of rows of the same processor the newer stay. Raises ValueError, before anything is written,
    for a folder that holds neither, or rows whose origin or columns are not known.
    """
    for folder in folders:
        _check(folder)
    return [said for folder in folders for said in _merged(out, folder)]


def _merged(out: Path, folder: Path) -> Iterator[str]:
    for place in (folder, *sorted((folder / MACHINES).glob("*"))):
        one = _read(place)
        if one is None:
            continue
        target = out / MACHINES / _name(one.origin)
        before = _read(target)
        if before is not None and before.origin.get("date", "") >= one.origin.get("date", ""):
            yield f"{place}: rows of {before.title} are as new, and stay."
            continue
        target.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(place / ROWS, target / ROWS)
        write(target / NAME, json.dumps({ROWS: dict(one.origin)}, indent=2) + "\n")
        yield f"{place}: {len(one.runs)} rows of {one.title}."
    found = [path for path in (folder / BENCHES).rglob("*") if path.is_file()]
    new = [path for path in found if not (out / path.relative_to(folder)).exists()]
    for path in new:
        target = out / path.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(path, target)
    if found:
        yield f"{folder}: {len(new)} files of benches, {len(found) - len(new)} were here."


def _check(folder: Path) -> None:
    rows = (folder / ROWS).is_file()
    if not rows and not any((folder / BENCHES).rglob("*")):
        raise ValueError(
            f"expected folders of reports, with {ROWS} and {NAME}, or {BENCHES}/; received "
            f"{folder}, which has neither. Name the folder that `galvi compare --out` wrote."
        )
    if not rows:
        return
    table = written(folder / ROWS, NEEDED[0], {})
    lacking = [name for name in NEEDED if table is None or name not in table]
    if lacking:
        raise ValueError(
            f"{folder / ROWS} expects the columns {', '.join(NEEDED)}; received a file without "
            f"{', '.join(lacking)}. Run `galvi compare` there again."
        )
    if not read_origins(folder).get(ROWS, {}).get("cpu"):
        raise ValueError(
            f"{folder / NAME} expects the origin of {ROWS} with its processor; received none. "
            "Copy it from where the rows were measured."
        )


def _read(folder: Path) -> Machine | None:
    origin = read_origins(folder).get(ROWS, {})
    runs = written(folder / ROWS, "is_truth", origin) if origin.get("cpu") else None
    return None if runs is None else Machine(runs, origin)


def _name(origin: Mapping[str, str]) -> str:
    """The name of its folder."""
    words = f"{origin.get('cpu', '')} {origin.get('compiled for', '')}".casefold()
    return re.sub(r"[^a-z0-9]+", "-", words).strip("-")

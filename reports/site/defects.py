"""The page of defects: what the suite saw in peers, and, apart, what others report of them.

``docs/defects.csv`` and ``docs/engine_versions.csv`` are measured, by the command that they name;
``reported.csv`` is written by hand, and nothing in it was run.
"""

from __future__ import annotations

import csv
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from benchmarks.experiments.engine_defects import (
    CHANGE,
    DEFECT,
    DEFECTS,
    ROUND_OFF,
    SHOWN,
    VERSIONS,
)

REPORTED = Path(__file__).with_name("reported.csv")
INTRODUCTION = (
    "What the suite finds in the codes it compares, each with the command that shows it again, the "
    "versions that ran, and what was seen. Where results depend on it, a reference here refuses "
    "the version or the option. A maintainer who finds a line wrong corrects it by running its "
    "command: the tables are written by it."
)
CHANGED = (
    "A body turns otherwise from version to version, by design or since a fault was corrected: "
    "compare results of one version only. Errors are those of H's free body after 10 units of "
    f"time; orders are fitted to errors above {ROUND_OFF:g}, errors shown at a step of {SHOWN:g}. "
    "*Free, nested*: half of the inertia is in a body that is fixed in the free one, the same "
    "motion."
)


def pages() -> Iterator[tuple[str, str]]:
    """(file, text) of the page."""
    seen, versions, reported = (read(path) for path in (DEFECTS, VERSIONS, REPORTED))
    links = [{**line, "where": f"<{line['where']}>"} for line in reported]
    runs = [{**line, "command": f"`{line['command']}`"} for line in seen]
    found, changed = (
        [{k: v for k, v in line.items() if k != "kind"} for line in runs if line["kind"] == kind]
        for kind in (DEFECT, CHANGE)
    )
    yield "defects.md", "\n".join((
        "# Defects of other codes", "", INTRODUCTION, "", *table(found), "",
        "## How versions of MuJoCo turn a free body", "", CHANGED, "", *table(changed), "",
        *table(versions), "",
        "## Reported by others, not run here", "", *table(links), "",
    ))  # fmt: skip


def read(path: Path) -> list[dict[str, str]]:
    """The lines of a CSV file."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(file))


def table(lines: Sequence[Mapping[str, str]]) -> Iterator[str]:
    """As Markdown."""
    headings = [name.replace("_", " ") for name in lines[0]]
    yield f"| {' | '.join(headings)} |"
    yield f"|{'---|' * len(headings)}"
    for line in lines:
        yield f"| {' | '.join(cell.replace('|', ' ') for cell in line.values())} |"

"""The page of defects: what the suite saw in peers, and, apart, what others report of them.

``docs/defects.csv`` and ``docs/engine_versions.csv`` were measured, and the command of a line shows
it again; ``reported.csv`` is written by hand, and nothing in it was run.
"""

from __future__ import annotations

import csv
import re
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

from benchmarks.store.provenance import ROOT

VERSIONS, DEFECTS = ROOT / "docs" / "engine_versions.csv", ROOT / "docs" / "defects.csv"
DEFECT, CHANGE = "defect", "change"  # kinds of a line
ROUND_OFF, SHOWN = 1e-12, 0.0125  # of attitudes, not fitted; and the step of the errors
FORCES = ROOT / "docs" / "forces.md"
HIGH_ORDER = {"ias15": "IAS15", "bs": "BS", "whfast": "WHFast", "saba": "SABA", "trace": "TRACE",
              "mercurius": "MERCURIUS"}  # fmt: skip
REPORTED = Path(__file__).with_name("reported.csv")
INTRODUCTION = (
    "What the suite finds in the codes it compares, each with the command that shows it again, the "
    "versions that ran, and what was seen. A line may be a limit that the code's own documentation "
    "states: whoever does not read it there is as wrong. Where results depend on it, a reference "
    "here refuses the version or the option. A maintainer who finds a line wrong shows so by "
    "running its command."
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
    found_too = of_forces(FORCES.read_text(encoding="utf-8"))
    links = [{**line, "where": f"<{line['where']}>"} for line in reported]
    runs = [{**line, "command": f"`{line['command']}`"} for line in seen]
    found, changed = (
        [{k: v for k, v in line.items() if k != "kind"} for line in runs if line["kind"] == kind]
        for kind in (DEFECT, CHANGE)
    )
    yield "defects.md", "\n".join((
        "# Defects and limits of other codes", "", INTRODUCTION, "",
        *table([*found, *found_too]), "",
        "## How versions of MuJoCo turn a free body", "", CHANGED, "", *table(changed), "",
        *table(versions), "",
        "## Reported by others, not run here", "", *table(links), "",
    ))  # fmt: skip


def of_forces(page: str) -> Iterator[dict[str, str]]:
    """A line for each of HIGH_ORDER that is wrong with some force, from the table of a page as
    ``docs/forces.md``, which a command prints."""
    _, _, after = page.partition("prints this table")
    lines = [line.strip("| ").split(" | ") for line in after.splitlines() if line[:1] == "|"]
    headings, rows = lines[0], [row for row in lines[2:] if len(row) == len(lines[0])]
    (command,) = re.findall(r"`(python -m \S+forces)` prints this table", page)
    (engines,) = re.findall(r"With (REBOUND \S+ and REBOUNDx [\d.]+\d)", page)
    for integrator, name in HIGH_ORDER.items():
        k = headings.index(integrator)
        wrong = [f"{row[0]}, e = {row[1]}: {row[k]}" for row in rows if row[k].startswith("wrong")]
        if wrong:
            yield {
                "what": f"{name} with forces of REBOUNDx: rates of elements",
                "versions": engines,
                "seen": "; ".join(wrong),
                "command": f"`{command}`",
                "date": "",
            }


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

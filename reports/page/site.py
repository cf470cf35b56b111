"""The pages of a report: which there are, their motion and their headings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from benchmarks.claims.statements import EFFECTS, FALSE, PAPERS, STATUSES, counted, statements
from benchmarks.store.atomic import write
from reports.page.render import ASSETS, PARTS, Part, render, script, style


@dataclass(frozen=True)
class Grid:
    """headings (text, class) and lines of cells (text, class)."""

    headings: tuple[tuple[str, str], ...]
    lines: tuple[tuple[tuple[str, str], ...], ...]


@dataclass(frozen=True)
class Explained:
    """A table with an introduction."""

    text: str
    rows: Grid


def grid(
    frame: pd.DataFrame,
    kinds: Mapping[str, str] | None = None,
    best: Iterable[tuple[int, str]] = (),
    absent: Iterable[str] = ("not reached", "not run"),
) -> Grid:
    """The grid of a frame of text.

    kinds   column -> CSS class
    best    cells (line, column) to highlight
    absent  texts that stand for a missing number
    """
    kinds, best, absent = dict(kinds or {}), set(best), set(absent)

    def cell(line: int, column: str, text: str) -> tuple[str, str]:
        classes = [kinds.get(column, "")]
        classes += ["absent"] if text in absent else []
        classes += ["best"] if (line, column) in best else []
        return text, " ".join(filter(None, classes))

    return Grid(
        headings=tuple((str(column), kinds.get(column, "")) for column in frame.columns),
        lines=tuple(
            tuple(cell(k, *pair) for pair in zip(frame.columns, map(str, line), strict=True))
            for k, line in enumerate(frame.itertuples(index=False, name=None))
        ),
    )


def ledger() -> dict[str, Any]:
    """What the template needs: the statements that are false as printed, and counts of all."""
    printed = statements()
    by_status = Counter((statement.status, statement.where[0]) for statement in printed)
    lines = [[status, *(by_status[status, paper] for paper in PAPERS)] for status in STATUSES]
    counts = pd.DataFrame([line for line in lines if any(line[1:])], columns=["status", *PAPERS])
    return {
        "headline": counted(printed),
        "misprints": [statement for statement in printed if statement.status == FALSE],
        "effects": EFFECTS.items(),
        "counts": grid(counts, dict.fromkeys(PAPERS, "number")),
    }


SINGLE = "report.html"
DOCUMENTATION = "docs/index.html"  # of `make docs`, in the folder of the report
Entry = tuple[str, str, int]  # anchor, title, level


def write_site(content: dict[str, Any], out: Path) -> Path:
    """Write every page, and the files they share; returns the path of the first."""
    write_assets(out)
    for part in PARTS:
        if part not in shown(content):
            (out / f"{part.name}.html").unlink(missing_ok=True)
            continue
        page = render(
            content, (part,), contents=list(contents(part, content)), documentation=documented(out)
        )
        write(out / f"{part.name}.html", page)
    return out / f"{PARTS[0].name}.html"


def documented(out: Path) -> str:
    """Where the documentation is beside these pages; "" where there is none."""
    return DOCUMENTATION if (out / DOCUMENTATION).is_file() else ""


def write_single(content: dict[str, Any], out: Path) -> Path:
    """Write all parts as one self-contained file; returns its path."""
    parts = shown(content)
    listed = [(part.name, part.title, 2) for part in parts]
    return write(out / SINGLE, render(content, parts, contents=listed, single=True))


def shown(content: Mapping[str, Any]) -> tuple[Part, ...]:
    """The pages, without that of the performance history where no benches are kept."""
    return tuple(part for part in PARTS if part.name != "history" or content["history"])


def write_assets(out: Path) -> None:
    """Write the style sheet and the script."""
    write(out / ASSETS / "page.css", style())
    write(out / ASSETS / "page.js", script())


def contents(part: Part, content: dict[str, Any]) -> Iterator[Entry]:
    """The entries of a page's contents."""
    if part.name == "index":
        yield from (
            ("results", "The result in two figures", 2),
            *(
                (("default-step", "MuJoCo's RK4 at its default step", 3),)
                if content["default_step"]
                else ()
            ),
            ("choose", "Which integrator for my error?", 2),
            *((("fastest", "Who is fastest", 3),) if content["summary_sentences"] else ()),
            ("verdicts", "What the papers claim", 2),
        )
    elif part.name == "statements":
        yield "misprints", "False as printed", 2
    elif part.name == "claims":
        for group in content["claim_groups"]:
            yield group.anchor, group.title, 2
            for item in group.claims:
                yield item.claim.id, f"{item.claim.id}: {item.claim.title}", 3
    elif part.name == "comparisons":
        yield from ((("profiles", "All problems together", 2),) if content["profiles"] else ())
        yield from ((item.anchor, item.title, 2) for item in content["comparisons"])
        yield from ((("targets", "Targets", 2),) if content["targets"] else ())
        yield "cost", "Cost of a step", 2
    elif part.name == "studies":
        yield from ((item.anchor, item.title, 2) for item in content["studies"])
    elif part.name == "history" and content["history"]:
        yield from ((place.anchor, place.name, 2) for place in content["history"].places)

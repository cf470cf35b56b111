"""Where the numbers of the pages come from: when, from which commit and by which command."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from reports.page.site import Grid, grid
from reports.results.claim_results import ClaimResult
from reports.results.comparison import MARKS, Comparison, written
from reports.results.origins import described, read_origins, short
from reports.results.section_result import SectionResult

CLAIMS = "claims.csv"
OF_A_RUN = (*MARKS, "command")  # what of an origin is not a version or the machine


@dataclass(frozen=True)
class Source:
    """A part of the pages that one or several measurements gave.

    part     its name
    origins  of its rows, see `reports.results.origins`
    """

    part: str
    origins: tuple[Mapping[str, str], ...]


def sources(
    out: Path,
    checked: Sequence[ClaimResult],
    comparison: Comparison,
    sections: Sequence[SectionResult],
) -> tuple[Source, ...]:
    """The parts with rows, from what the folder says of its files; claims row by row."""
    known = read_origins(out)
    found = [("Claims", _of_claims(out, checked, known.get(CLAIMS, {})))] if checked else []
    for part, file, frame in (
        ("Comparisons", "work_precision.csv", comparison.work_precision),
        ("Cost of a step", "cost.csv", comparison.cost),
    ):
        found += [] if frame is None else [(part, (known.get(file, {}),))]
    files = [f"{one.section.name}.csv" for one in sections if one.frame is not None]
    found += [("Studies", tuple(known.get(file, {}) for file in files))] if files else []
    return tuple(Source(*one) for one in found)


def _of_claims(
    out: Path, checked: Sequence[ClaimResult], last: Mapping[str, str]
) -> tuple[Mapping[str, str], ...]:
    """Each origin of the rows of these claims once; `last` is that of the last measurement."""
    rows = written(out / CLAIMS, "id", last)
    if rows is None:
        return (last,)
    rows = rows[rows["id"].isin([one.claim.id for one in checked])]
    marks = rows[list(MARKS)].drop_duplicates().astype(str).to_dict("records")
    command = last.get("command", "")
    return tuple(
        {**mark, "command": command if mark["commit"] == last.get("commit") else ""}
        for mark in marks
    )


def statements(found: Sequence[Source]) -> list[str]:
    """E.g. "Claims: 2026-01-02 03:04 UTC, commit 01234"; parts of the same origin in one."""
    parts: dict[str, list[str]] = {}
    for one in found:
        parts.setdefault(described(one.origins), []).append(one.part)
    if len(parts) == 1 and len(found) > 1:
        return [f"All numbers: {text}" for text in parts]
    return [
        f"{', '.join([names[0], *(name.lower() for name in names[1:])])}: {text}"
        for text, names in parts.items()
    ]


def commands(found: Sequence[Source]) -> str:
    """The lines that measure all of it again: each commit, and the commands run there."""
    by_commit: dict[str, list[str]] = {}
    for origin in (one for source in found for one in source.origins):
        listed = by_commit.setdefault(short(origin.get("commit") or "unknown"), [])
        command = without_folder(origin.get("command", ""))
        listed += [command] if command and command not in listed else []
    lines = []
    for commit, listed in by_commit.items():
        hash_, _, changed = commit.partition(" ")
        lines += [f"git checkout {hash_}{f'  # {changed}' if changed else ''}"]
        lines += ["make install", ". .venv/bin/activate", *listed]
    return "\n".join(lines)


def without_folder(command: str) -> str:
    """A command without `--out`: it writes to reports/out."""
    return re.sub(r""" --out(?:=| +)(?:'[^']*'|"[^"]*"|\S+)""", "", command)


def files(origins: Mapping[str, Mapping[str, str]], shown: Mapping[str, str]) -> Grid | None:
    """A line for each file; its versions and machine where they differ from the shown ones."""
    lines = []
    for file, one in origins.items():
        other = [
            f"{name} {text}"
            for name, text in one.items()
            if name not in OF_A_RUN and shown.get(name) != text
        ]
        lines.append(
            {
                "file": file,
                "written": one.get("date", ""),
                "commit": short(one.get("commit") or "unknown"),
                "setting": one.get("setting", ""),
                "command": without_folder(one.get("command", "")),
                "what differs from above": "; ".join(other),
            }
        )
    table = pd.DataFrame(lines)
    if len(table) and not table["what differs from above"].any():
        table = table.drop(columns="what differs from above")
    return grid(table) if lines else None
